//! CPU and wall time of the stages of a build.

use std::sync::Mutex;
use std::time::Instant;

use gimage::progress::{Progress, Stage};
use serde::{Deserialize, Serialize};

/// The cost of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// The stage by name.
    pub stage: String,
    /// Wall time \[s\].
    pub wall: f64,
    /// CPU time of all threads, user and system \[s\].
    pub cpu: f64,
}

/// User and system time of this process since it began, all threads \[s\]. The process clock resolves nanoseconds, where
/// `/proc/self/stat` counts ticks of 10 ms, which is a tenth of a small build.
#[cfg(unix)]
pub fn cpu_seconds() -> Option<f64> {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64)
}

/// Not known on this system.
#[cfg(not(unix))]
pub fn cpu_seconds() -> Option<f64> {
    None
}

/// Marks where each stage begins; a stage lasts until the next one, so that nothing between two is lost.
pub struct StageClock {
    marks: Mutex<Vec<(String, Instant, f64)>>,
}

impl StageClock {
    /// A clock without marks.
    pub fn new() -> Self {
        Self { marks: Mutex::new(Vec::new()) }
    }

    /// The stage `name` begins now.
    pub fn mark(&self, name: &str) {
        let mark = (name.to_owned(), Instant::now(), cpu_seconds().unwrap_or(f64::NAN));
        self.marks.lock().unwrap_or_else(|e| e.into_inner()).push(mark);
    }

    /// Ends the last stage.
    pub fn finish(self) -> Vec<Cost> {
        self.mark("");
        let marks = self.marks.into_inner().unwrap_or_else(|e| e.into_inner());
        let cost = |w: &[(String, Instant, f64)]| Cost {
            stage: w[0].0.clone(),
            wall: w[1].1.duration_since(w[0].1).as_secs_f64(),
            cpu: w[1].2 - w[0].2,
        };
        marks.windows(2).map(cost).collect()
    }
}

impl Progress for StageClock {
    fn begin(&self, stage: Stage, _steps: u64) {
        self.mark(stage.name());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_follow_one_another_and_cpu_time_grows() {
        let clock = StageClock::new();
        clock.begin(Stage::Import, 1);
        let x: f64 = (0..200_000).map(|k| f64::from(k).sqrt()).sum();
        clock.mark("write");
        let cost = clock.finish();
        assert!(x > 0.0);
        assert_eq!(cost.iter().map(|c| c.stage.as_str()).collect::<Vec<_>>(), ["import", "write"]);
        assert!(cost.iter().all(|c| c.wall >= 0.0));
        assert!(cfg!(not(unix)) || cost[0].cpu > 0.0);
    }
}
