//! Description of the machine of a run. Nothing here names the machine or a folder on it.

use std::process::Command;

use crate::args::{BenchArgs, name};

/// The text of machine.txt.
pub fn describe(args: &BenchArgs) -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let build = if cfg!(debug_assertions) { "debug, timings mean little" } else { "release" };
    let list = |v: Vec<String>| v.join(",");
    let mut settings = format!(
        "texels {}; sample {}; seams {}; effort {}; detail {}; {} timed builds each",
        list(args.texels.iter().map(|t| format!("{t}^2")).collect()),
        list(args.sample.iter().map(|&s| name(s)).collect()),
        list(args.seams.iter().map(|&s| name(s)).collect()),
        list(args.effort.iter().map(|&e| name(e)).collect()),
        list(args.detail.iter().map(f64::to_string).collect()),
        args.repeat
    );
    if !args.peers.is_empty() {
        settings += &format!("; peers {}", list(args.peers.iter().map(|&p| name(p)).collect()));
    }
    let threads = if args.threads == 0 { "one a core".into() } else { args.threads.to_string() };
    [
        ("cpu", field("/proc/cpuinfo", "model name", ':')),
        ("cores", Some(cores.to_string())),
        ("memory", field("/proc/meminfo", "MemTotal", ':')),
        ("system", field("/etc/os-release", "PRETTY_NAME", '=').map(|s| s.trim_matches('"').to_owned())),
        ("target", Some(format!("{} {}", std::env::consts::ARCH, std::env::consts::OS))),
        ("load at start", std::fs::read_to_string("/proc/loadavg").ok().and_then(|s| first_words(&s, 1))),
        ("rustc", said("rustc", &["--version"]).and_then(|s| first_words(&s, 2))),
        ("commit", said("git", &["rev-parse", "--short=12", "HEAD"])),
        ("build", Some(build.into())),
        ("threads of a build", Some(threads)),
        ("settings", Some(settings)),
    ]
    .into_iter()
    .map(|(key, value)| format!("{key}: {}\n", value.unwrap_or_else(|| "unknown".into())))
    .collect()
}

/// The value of a key in a file of lines.
fn field(path: &str, key: &str, separator: char) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find(|l| l.starts_with(key))?;
    Some(line.split_once(separator)?.1.trim().to_owned())
}

fn said(program: &str, args: &[&str]) -> Option<String> {
    let out = Command::new(program).args(args).output().ok()?;
    out.status.success().then(|| String::from_utf8_lossy(&out.stdout).trim().to_owned())
}

fn first_words(text: &str, n: usize) -> Option<String> {
    let words: Vec<&str> = text.split_whitespace().take(n).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn the_description_holds_no_folder() {
        let text = describe(&crate::args::Cli::parse_from(["fidelity"]).bench);
        assert!(
            text.contains(
                "settings: texels 65^2,129^2,257^2,513^2; sample point,fit; seams auto,short; effort default"
            )
        );
        assert!(!text.contains(env!("CARGO_MANIFEST_DIR")));
    }
}
