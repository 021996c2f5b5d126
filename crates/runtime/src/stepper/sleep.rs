//! Sleep of cloths, as a host asks for it and sees it.

use super::Stepper;
use crate::error::Result;

impl Stepper {
    /// Whether a cloth is asleep; not where there is none.
    pub fn is_asleep(&self, cloth: usize) -> bool {
        self.world.runs.get(cloth).is_some_and(|run| run.asleep)
    }

    /// Lets cloths fall asleep on the GPU backend if [`crate::Options::sleep`] is set, and substeps be chosen by
    /// [`crate::Quality::Error`]: call it once a frame, after everything that was recorded has been submitted. It takes in
    /// what has come back, eight bytes per cloth some frames late, and never waits. Without it no cloth falls asleep and
    /// no error is known there. The CPU backend needs no call.
    pub fn settle(&mut self) -> Result<()> {
        self.gpu.as_mut().map_or(Ok(()), |gpu| gpu.settle(&mut self.world))
    }
}
