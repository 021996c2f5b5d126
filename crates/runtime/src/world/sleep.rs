//! When cloth falls asleep, and when it wakes.
//!
//! Asleep is a state of the host, so that a cloth at rest costs no dispatch, no binding and no recording at all.
//! Dispatches whose size a shader sets to 0 would need no word from the host, but each is still recorded, bound and, by
//! wgpu, checked by a dispatch of its own. The price is that on the GPU four bytes per cloth have to come back: they are
//! copied with the frame, and [`crate::Stepper::settle`] takes what has arrived, without waiting.

use super::World;

/// How calm a cloth has been.
#[derive(Clone, Copy, Debug, Default)]
pub struct Calm {
    /// For how long \[s\].
    seconds: f64,
    /// Changes so far: what was measured before one counts no more.
    pub changes: u64,
}

impl Calm {
    /// For how long it has been calm \[s\].
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl World {
    /// Square of the longest displacement of a step \[m^2\] that counts as calm; none where no cloth falls asleep.
    pub fn calm_below(&self) -> Option<f64> {
        let sleep = self.control.options.sleep.filter(|_| self.scene.wind.is_none())?;
        Some((sleep.speed * self.control.clock.dt).powi(2))
    }

    /// Takes in a frame of `seconds`.
    pub fn note(&mut self, cloth: usize, calm: bool, seconds: f64) {
        let run = &mut self.runs[cloth];
        run.calm.seconds = if calm { run.calm.seconds + seconds } else { 0.0 };
        if calm && self.control.options.sleep.is_some_and(|s| run.calm.seconds >= s.after) {
            run.asleep = true;
        }
    }

    /// Wakes a cloth, and counts its rest from 0.
    pub fn wake(&mut self, cloth: usize) {
        let run = &mut self.runs[cloth];
        run.asleep = false;
        run.calm = Calm { seconds: 0.0, changes: run.calm.changes + 1 };
    }

    /// Lets a cloth sleep or be awake as it was when it had been calm for `seconds`.
    pub fn resume_sleep(&mut self, cloth: usize, asleep: bool, seconds: f64) {
        self.wake(cloth);
        let run = &mut self.runs[cloth];
        (run.asleep, run.calm.seconds) = (asleep, seconds);
    }

    /// Wakes every cloth.
    pub fn wake_all(&mut self) {
        (0..self.runs.len()).for_each(|cloth| self.wake(cloth));
    }
}
