//! The report of a build. It has the times, because the bytes of a bundle must not depend on them.

use serde::Serialize;

use crate::progress::Stage;
use crate::record::{Finding, Severity};

/// The time of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// The stage.
    pub stage: Stage,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Largest memory of the process so far \[bytes\], where the system tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_bytes: Option<u64>,
}

/// Times and findings of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Stages in order.
    pub stages: Vec<StageTime>,
    /// All findings, in the order of the stages.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether there is a repair, an accessory or a warning (exit code 1).
    pub fn has_findings(&self) -> bool {
        self.findings.iter().any(|f| f.severity > Severity::Note)
    }
}

/// Largest resident memory of this process so far \[bytes\], on Linux.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|k| k * 1024)
}
