//! A mesh at a setting, and the order in which jobs run.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Failure;
use crate::args::{BenchArgs, EffortArg, SampleArg, SeamsArg, name};
use crate::one::Run;

/// How a mesh is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Side of the square that sets the texel budget.
    pub texels: u32,
    /// Where texels go.
    pub sample: SampleArg,
    /// Which edges the cut prefers.
    pub seams: SeamsArg,
    /// How hard the search for a layout tries.
    pub effort: EffortArg,
    /// How far texels go where the surface bends.
    pub detail: f64,
}

/// One mesh at one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Which of the run's meshes.
    pub mesh: usize,
    /// How it is built.
    pub setting: Setting,
}

/// Every mesh at every setting, in the order of the table.
pub fn all(args: &BenchArgs, meshes: usize) -> Vec<Job> {
    let mut out = Vec::new();
    for mesh in 0..meshes {
        for &seams in &args.seams {
            for &effort in &args.effort {
                for &detail in &args.detail {
                    for &sample in &args.sample {
                        let setting = |&texels: &u32| Setting { texels, sample, seams, effort, detail };
                        out.extend(args.texels.iter().map(setting).map(|setting| Job { mesh, setting }));
                    }
                }
            }
        }
    }
    out
}

/// The order of repetition `round`: shuffled, each round otherwise, so that a slow minute of the machine falls on many
/// settings once and not on one of them each time. The same rounds are shuffled alike in every run.
pub fn order(jobs: usize, round: u32) -> Vec<usize> {
    let mut out: Vec<usize> = (0..jobs).collect();
    let mut state = 0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(u64::from(round) + 1);
    for k in (1..jobs).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        out.swap(k, (state >> 33) as usize % (k + 1));
    }
    out
}

impl Setting {
    /// Builds `mesh` in a child process; the bundle replaces `out`.
    pub fn build(&self, mesh: &Path, out: &Path, metrics: bool, threads: u32) -> Result<Run, Failure> {
        let mut child = Command::new(std::env::current_exe()?);
        child.arg("one").arg(mesh).arg("--out").arg(out).args(["--texels", &self.texels.to_string()]);
        child.args(["--sample", &name(self.sample), "--seams", &name(self.seams)]);
        child.args(["--effort", &name(self.effort), "--detail", &self.detail.to_string()]);
        if metrics {
            child.arg("--metrics");
        }
        if threads > 0 {
            child.env("RAYON_NUM_THREADS", threads.to_string());
        }
        Ok(serde_json::from_slice(&output(&mut child)?)?)
    }
}

/// Standard output of a child; what it said on standard error is the failure if it fails.
pub fn output(command: &mut Command) -> Result<Vec<u8>, Failure> {
    let program = PathBuf::from(command.get_program());
    let program = program.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let out = command.output().map_err(|e| format!("{program}: {e}"))?;
    if out.status.success() {
        return Ok(out.stdout);
    }
    let said = String::from_utf8_lossy(&out.stderr);
    // The last line of a Python traceback is the one that says what happened.
    let last = said.trim().lines().last().unwrap_or("it said nothing");
    Err(format!("{program} failed: {last}").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_round_holds_each_job_once_in_another_order() {
        let (a, b) = (order(40, 0), order(40, 1));
        assert_ne!(a, b);
        for mut round in [a, b] {
            round.sort_unstable();
            assert_eq!(round, (0..40).collect::<Vec<_>>());
        }
        assert!(order(0, 3).is_empty());
        assert_eq!(order(7, 5), order(7, 5));
    }

    #[test]
    fn a_child_that_fails_is_a_failure_in_its_own_words() {
        let failed = output(Command::new(std::env::current_exe().unwrap()).arg("--no-such-option"));
        assert!(failed.unwrap_err().to_string().contains("failed: "));
    }
}
