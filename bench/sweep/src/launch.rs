//! Runs one build in a child process and takes whatever becomes of it.

use std::fs::File;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::Failure;
use crate::args::{SampleArg, SweepArgs};
use crate::record::{Record, Status};

/// Wall seconds for each CPU second a build may take: on a busy machine a process gets a share of a core.
const WALL_PER_CPU: u64 = 12;

/// How often the parent looks after a child.
const LOOK: Duration = Duration::from_millis(5);

/// Builds `mesh` in a child that works in `folder`, an empty directory.
pub fn run(
    args: &SweepArgs,
    mesh: &Path,
    name: &str,
    texels: u32,
    sample: SampleArg,
    folder: &Path,
) -> Result<Record, Failure> {
    let (out, said) = (folder.join("record.json"), folder.join("stderr"));
    if out.exists() {
        std::fs::remove_file(&out)?;
    }
    let start = Instant::now();
    let mut child = Command::new(std::env::current_exe()?)
        .arg("one")
        .arg(mesh)
        .args(["--texels", &texels.to_string(), "--sample", sample.name()])
        .args(["--limit-seconds", &args.limit_seconds.to_string(), "--limit-mib", &args.limit_mib.to_string()])
        .args(args.weld.iter().flat_map(|w| ["--weld".to_owned(), w.to_string()]))
        .arg("--out")
        .arg(&out)
        .env("RAYON_NUM_THREADS", args.threads.max(1).to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said)?)
        .spawn()?;
    let longest = Duration::from_secs(args.limit_seconds.saturating_mul(WALL_PER_CPU));
    let mut late = false;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if start.elapsed() > longest && !late {
            late = true;
            child.kill()?;
        }
        std::thread::sleep(LOOK);
    };
    let said = std::fs::read(&said).unwrap_or_default();
    let said = String::from_utf8_lossy(&said);
    let finished = std::fs::read(&out).ok().and_then(|bytes| serde_json::from_slice::<Record>(&bytes).ok());
    let mut record = match finished.filter(|_| status.success()) {
        Some(record) => record,
        None => Record { status: end(status, late, &said), wall: start.elapsed().as_secs_f64(), ..Record::default() },
    };
    (record.mesh, record.texels, record.sample) = (name.into(), texels, sample.name().into());
    Ok(record)
}

/// The end of a child that left no record.
fn end(status: ExitStatus, late: bool, said: &str) -> Status {
    let panic = said.lines().position(|l| l.contains("panicked at"));
    if let Some(line) = panic {
        return Status::Panicked(said.lines().skip(line).take(2).collect::<Vec<_>>().join(" "));
    }
    if late || signal(status) == Some(SIGXCPU) {
        return Status::TimedOut;
    }
    // A refused child says why: its own failure, not the build's.
    match said.lines().next().and_then(|l| l.strip_prefix("error: ")) {
        Some(message) => Status::Refused { kind: "sweep".into(), message: message.into() },
        None => Status::Died,
    }
}

/// Sent when a process is out of CPU time.
const SIGXCPU: i32 = 24;

#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal(_: ExitStatus) -> Option<i32> {
    None
}
