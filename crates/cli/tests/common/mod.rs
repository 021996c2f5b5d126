//! Helpers that the tests of the command share.
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The end of one run of `gimage`.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}", self.stdout))
    }

    /// Fails with everything said unless the code is one of these.
    #[track_caller]
    pub fn expect(self, codes: &[i32]) -> Self {
        assert!(codes.contains(&self.code), "exit {}\n{}\n{}", self.code, self.stdout, self.stderr);
        self
    }
}

/// A directory to work in, with a garment.
pub struct Place(pub tempfile::TempDir);

impl Place {
    pub fn new() -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        place.write("tube.obj", &tube());
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs `gimage` here; arguments are split at blanks.
    pub fn run(&self, args: &str) -> Run {
        self.run_with(args, |_| {})
    }

    pub fn run_with(&self, args: &str, change: impl FnOnce(&mut Command)) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gimage"));
        command.current_dir(self.0.path()).args(args.split_whitespace());
        change(&mut command);
        let Output { status, stdout, stderr } = command.output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run { code: status.code().unwrap(), stdout: text(stdout), stderr: text(stderr) }
    }

    /// A small bundle of the tube.
    pub fn built(&self, flags: &str) -> Run {
        self.run(&format!("build tube.obj -o tube.gim --texels 600 {flags}")).expect(&[0, 1])
    }

    /// The names here, in order.
    pub fn list(&self) -> Vec<String> {
        list(self.0.path())
    }
}

pub fn list(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// All files of a bundle.
pub fn bytes(bundle: &Path) -> Vec<(String, Vec<u8>)> {
    list(bundle).into_iter().map(|name| (name.clone(), fs::read(bundle.join(&name)).unwrap())).collect()
}

/// An open tube of 16 x 8 quads with texture coordinates: two boundary loops.
fn tube() -> String {
    let (n, m) = (16, 8);
    let mut text = String::from("o tube\n");
    for j in 0..=m {
        for i in 0..n {
            let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            writeln!(text, "v {} {} {}", 0.3 * a.cos(), 0.1 * f64::from(j), 0.3 * a.sin()).unwrap();
        }
        for i in 0..=n {
            writeln!(text, "vt {} {}", f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)).unwrap();
        }
    }
    for j in 0..m {
        for i in 0..n {
            let corner = |i: i32, j: i32| format!("{}/{}", j * n + i % n + 1, j * (n + 1) + i + 1);
            let (a, b, c, d) = (corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j));
            writeln!(text, "f {a} {b} {c} {d}").unwrap();
        }
    }
    text
}
