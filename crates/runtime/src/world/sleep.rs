//! When cloth falls asleep, and when it wakes.
//!
//! Asleep is a state of the host, so that a cloth at rest costs no dispatch, no binding and no recording at all.
//! Dispatches whose size a shader sets to 0 would need no word from the host, but each is still recorded, bound and, by
//! wgpu, checked by a dispatch of its own. The price is that on the GPU four bytes per cloth have to come back: they are
//! copied with the frame, and [`crate::Stepper::settle`] takes what has arrived, without waiting.
//!
//! Among colliders a cloth falls asleep once the box around it is known, so that only those that come close wake it.

use super::{ClothRun, World};
use crate::collider::way::Corners;
use crate::cpu::body::Body;
use crate::cpu::bounds::{self, Extent};
use crate::number::real::{Real, cast};

/// How calm a cloth has been.
#[derive(Clone, Copy, Debug, Default)]
pub struct Calm {
    /// For how long \[s\].
    seconds: f64,
    /// Changes so far: what was measured before one counts no more.
    pub changes: u64,
    /// The box around its particles at rest, where it is known.
    pub rest: Option<Corners>,
    /// Whether a box is being measured, or known.
    pub asked: bool,
    /// How often it began to move: a box that was measured before counts no more.
    starts: u64,
}

impl Calm {
    /// For how long it has been calm \[s\].
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// What a box is to be compared with when it arrives.
    pub fn mark(&self) -> [u64; 2] {
        [self.changes, self.starts]
    }
}

impl World {
    /// Square of the longest displacement of a step \[m^2\] that counts as calm; none where no cloth falls asleep.
    pub fn calm_below(&self) -> Option<f64> {
        let sleep = self.control.options.sleep.filter(|_| self.scene.wind.is_none())?;
        Some((sleep.speed * self.control.clock.dt).powi(2))
    }

    /// Takes in a frame of `seconds`, measured after the first `known` changes of colliders. `look` finds the box around a
    /// cloth where it can be found at once.
    pub fn note(
        &mut self,
        cloth: usize,
        calm: bool,
        (seconds, known): (f64, u64),
        look: impl FnOnce() -> Option<Corners>,
    ) {
        let run = &mut self.runs[cloth].calm;
        if !calm {
            *run = Calm { changes: run.changes, starts: run.starts + 1, ..Calm::default() };
            return;
        }
        run.seconds += seconds;
        if self.control.options.sleep.is_none_or(|s| run.seconds < s.after) {
            return;
        }
        if !self.scene.meets(self.scene.cloths[cloth].collision_groups) {
            self.runs[cloth].asleep = true;
            return;
        }
        run.rest = run.rest.or_else(look);
        let rest = run.rest;
        match rest {
            Some(rest) if self.is_stirred(cloth, known, rest) => self.wake(cloth),
            Some(_) => self.runs[cloth].asleep = true,
            None => {}
        }
    }

    /// The cloths among colliders whose boxes are not known although they sleep, or soon will.
    pub fn without_rest(&self) -> Vec<usize> {
        let sleep = self.control.options.sleep.filter(|_| self.calm_below().is_some());
        let soon = |calm: &Calm| sleep.is_some_and(|s| calm.seconds > 0.0 && calm.seconds >= 0.5 * s.after);
        let wants = |run: &ClothRun| !run.calm.asked && (run.asleep || soon(&run.calm));
        let meets = |cloth: &usize| self.scene.meets(self.scene.cloths[*cloth].collision_groups);
        (0..self.runs.len()).filter(|cloth| wants(&self.runs[*cloth])).filter(meets).collect()
    }

    /// Takes in the box around a cloth, asked for at `mark`.
    pub fn rest(&mut self, cloth: usize, mark: [u64; 2], rest: Corners) {
        let calm = &mut self.runs[cloth].calm;
        if calm.mark() == mark {
            (calm.rest, calm.asked) = (Some(rest), true);
        }
    }

    /// Finds the boxes of cloths that sleep.
    pub fn look<T: Real>(&mut self, bodies: &[Body<T>]) {
        for cloth in self.without_rest().into_iter().filter(|c| self.runs[*c].asleep).collect::<Vec<_>>() {
            self.rest(cloth, self.runs[cloth].calm.mark(), around(&bodies[cloth]));
        }
    }

    /// Wakes a cloth, and counts its rest from 0.
    pub fn wake(&mut self, cloth: usize) {
        let run = &mut self.runs[cloth];
        run.asleep = false;
        run.calm = Calm { changes: run.calm.changes + 1, ..Calm::default() };
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

/// The box of an extent. Nothing touches that of no particles.
pub fn corners<T: Real>(extent: Option<Extent<T>>) -> Corners {
    extent.map_or([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |e| [cast(e.low), cast(e.high)])
}

/// The box around a cloth, now and one step before.
pub fn around<T: Real>(body: &Body<T>) -> Corners {
    corners(bounds::run(body.now(), body.before()))
}
