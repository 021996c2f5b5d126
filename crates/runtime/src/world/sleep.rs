//! When cloth falls asleep, and when it wakes.
//!
//! Asleep is a state of the host, so that a cloth at rest costs no dispatch, no binding and no recording at all.
//! Dispatches whose size a shader sets to 0 would need no word from the host, but each is still recorded, bound and, by
//! wgpu, checked by a dispatch of its own. The price is that on the GPU four bytes per cloth have to come back: they are
//! copied with the frame, and [`crate::Stepper::settle`] takes what has arrived, without waiting.

use super::World;
use crate::passes::Pass;

/// How calm a cloth has been.
#[derive(Clone, Copy, Debug, Default)]
pub struct Calm {
    /// For how long \[s\].
    seconds: f64,
    /// Changes so far: what was measured before one counts no more.
    pub changes: u64,
}

impl World {
    /// Adds the passes that measure speeds, where cloth may fall asleep.
    pub fn watch(&mut self) {
        if self.calm_below().is_some() {
            self.schedules.iter_mut().for_each(|s| s.frame.extend([Pass::Speed, Pass::Fastest]));
        }
    }

    /// Square of the longest displacement of a step \[m^2\] that counts as calm; none where no cloth falls asleep.
    pub fn calm_below(&self) -> Option<f64> {
        let sleep = self.options.sleep.filter(|_| self.scene.wind.is_none())?;
        Some((sleep.speed * self.clock.dt).powi(2))
    }

    /// Takes in a frame of `seconds`.
    pub fn note(&mut self, cloth: usize, calm: bool, seconds: f64) {
        let entry = &mut self.calm[cloth];
        entry.seconds = if calm { entry.seconds + seconds } else { 0.0 };
        if calm && self.options.sleep.is_some_and(|s| entry.seconds >= s.after) {
            self.asleep[cloth] = true;
        }
    }

    /// Wakes a cloth, and counts its rest from 0.
    pub fn wake(&mut self, cloth: usize) {
        self.asleep[cloth] = false;
        self.calm[cloth] = Calm { seconds: 0.0, changes: self.calm[cloth].changes + 1 };
    }

    /// Wakes every cloth.
    pub fn wake_all(&mut self) {
        (0..self.asleep.len()).for_each(|cloth| self.wake(cloth));
    }
}
