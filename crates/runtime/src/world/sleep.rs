//! When cloth falls asleep, and when it wakes.
//!
//! Asleep is a state of the host, so that a cloth at rest costs no dispatch, no binding and no recording at all.
//! Dispatches whose size a shader sets to 0 would need no read-back, but each is still recorded, bound and, by
//! wgpu, checked by a dispatch of its own. The price is that on the GPU four bytes per cloth have to come back: they are
//! copied with the frame, and [`crate::Stepper::settle`] takes what has arrived, without waiting.
//!
//! Among colliders a cloth falls asleep only if the box around it is known, so that only colliders that come close wake it.

use super::{ClothRun, World};
use crate::collider::path::Corners;
use crate::cpu::body::Body;
use crate::cpu::bounds::{self, Extent};
use crate::number::real::{Real, cast};

/// How calm a cloth has been.
#[derive(Clone, Copy, Debug, Default)]
pub struct Calm {
    /// For how long \[s\].
    seconds: f64,
    /// Changes so far: measurements from before one do not count.
    pub changes: u64,
    /// The box around its particles where it is known, and how far \[m\] they may have drifted out of it.
    pub rest_box: Option<(Corners, f64)>,
    /// Whether a box is being measured, or known.
    pub asked: bool,
    /// How often it began to move: boxes from before do not count.
    starts: u64,
    /// The number of the last path of a collider when it came to rest.
    known: u64,
}

/// The state of a cloth when the measurement of its box was recorded.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    /// A box counts only if this is still the same.
    mark: [u64; 2],
    asleep: bool,
    /// The number of the last path of a collider that it allows for.
    known: u64,
}

impl Calm {
    /// For how long it has been calm \[s\].
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    fn mark(&self) -> [u64; 2] {
        [self.changes, self.starts]
    }

    /// Whether it is at rest for some time, and the box around it is not known yet.
    pub fn awaits_box(&self) -> bool {
        self.seconds > 0.0 && self.rest_box.is_none()
    }
}

impl World {
    /// Square of the longest displacement of a step \[m^2\] that counts as calm; none where no cloth falls asleep.
    pub fn calm_below(&self) -> Option<f64> {
        let sleep = self.control.options.sleep.filter(|_| self.scene.wind.is_none())?;
        Some((sleep.speed * self.control.clock.dt).powi(2))
    }

    /// How far a calm cloth may drift before it falls asleep \[m\].
    fn drift(&self) -> f64 {
        self.control.options.sleep.map_or(0.0, |sleep| sleep.speed * sleep.after)
    }

    /// Takes in a frame of `seconds`. `measure` finds the box around a cloth where that needs no wait.
    pub fn note(&mut self, cloth: usize, calm: bool, seconds: f64, measure: impl Fn() -> Option<Corners>) {
        let (drift, sleep) = (self.drift(), self.control.options.sleep);
        let meets = self.meets(cloth);
        if self.runs[cloth].asleep {
            // Measured before it fell asleep.
            if !calm {
                self.wake(cloth);
            }
            return;
        }
        let run = &mut self.runs[cloth];
        let rest = &mut run.calm;
        if !calm {
            *rest = Calm { changes: rest.changes, starts: rest.starts + 1, ..Calm::default() };
            return;
        }
        if rest.seconds == 0.0 {
            rest.known = self.paths.count();
        }
        rest.seconds += seconds;
        if meets && rest.rest_box.is_none() {
            rest.rest_box = measure().map(|found| (found, drift));
            rest.asked |= rest.rest_box.is_some();
            let (known, rest_box) = (rest.known, rest.rest_box);
            if rest_box.is_some_and(|rest_box| self.is_disturbed(cloth, known, rest_box)) {
                self.wake(cloth);
                return;
            }
        }
        let run = &mut self.runs[cloth];
        let rest = &mut run.calm;
        let ripe = sleep.is_some_and(|s| rest.seconds >= s.after);
        if ripe && (!meets || rest.rest_box.is_some()) {
            run.asleep = true;
            // Where it lies now.
            let exact = measure().filter(|_| meets).map(|found| (found, 0.0));
            rest.asked = exact.is_some();
            rest.rest_box = exact.or(rest.rest_box);
        }
    }

    /// The cloths among colliders that are at rest, and whose boxes are not known.
    pub fn without_rest_box(&self) -> Vec<usize> {
        let wants = |run: &ClothRun| !run.calm.asked && (run.asleep || run.calm.seconds > 0.0);
        (0..self.runs.len()).filter(|cloth| wants(&self.runs[*cloth]) && self.meets(*cloth)).collect()
    }

    /// Takes in that the box of a cloth is being measured.
    pub fn seek(&mut self, cloth: usize) -> Sought {
        let run = &mut self.runs[cloth];
        run.calm.asked = true;
        let known = if run.asleep || run.calm.seconds == 0.0 { self.paths.count() } else { run.calm.known };
        Sought { mark: run.calm.mark(), asleep: run.asleep, known }
    }

    /// Takes in the box around a cloth; none if no particle was found.
    pub fn found(&mut self, cloth: usize, sought: &Sought, corners: Option<Corners>) {
        let drift = if sought.asleep { 0.0 } else { self.drift() };
        let calm = &mut self.runs[cloth].calm;
        if calm.mark() != sought.mark {
            return;
        }
        calm.asked = corners.is_some();
        let Some(rest) = corners.map(|found| (found, drift)) else { return };
        calm.rest_box = Some(rest);
        if self.is_disturbed(cloth, sought.known, rest) {
            self.wake(cloth);
        }
    }

    /// Drops the paths that no box to come has to be compared with.
    pub fn forget_paths(&mut self) {
        let waits = |run: &ClothRun| !run.asleep && run.calm.awaits_box();
        let waiting = (0..self.runs.len()).filter(|cloth| waits(&self.runs[*cloth]) && self.meets(*cloth));
        let known = waiting.map(|cloth| self.runs[cloth].calm.known).min();
        self.paths.forget(known.unwrap_or(self.paths.count()));
    }

    /// Measures the boxes of cloths that sleep, on the CPU.
    pub fn measure_sleepers<T: Real>(&mut self, bodies: &[Body<T>]) {
        for cloth in self.without_rest_box() {
            // Actions that wait may still move it.
            if self.runs[cloth].asleep && !self.host.awaits(cloth) {
                let sought = self.seek(cloth);
                self.found(cloth, &sought, around(&bodies[cloth]));
            }
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
        let known = self.paths.count();
        let run = &mut self.runs[cloth];
        (run.asleep, run.calm.seconds, run.calm.known) = (asleep, seconds, known);
    }

    /// Wakes the other cloths with contact, as one that has contact goes away or elsewhere: they may lie on it.
    pub fn wake_beside(&mut self, cloth: usize) {
        if self.scene.cloths[cloth].contact.is_none() {
            return;
        }
        for other in (0..self.runs.len()).filter(|other| *other != cloth) {
            if self.scene.cloths[other].contact.is_some() {
                self.wake(other);
            }
        }
    }

    /// Whether any particle of a cloth is pinned.
    pub fn is_held(&self, cloth: usize) -> bool {
        self.scene.cloths[cloth].particles().iter().any(|p| p.is_pinned())
    }

    /// Wakes every cloth.
    pub fn wake_all(&mut self) {
        (0..self.runs.len()).for_each(|cloth| self.wake(cloth));
    }
}

/// The box of an extent.
pub fn corners<T: Real>(extent: Option<Extent<T>>) -> Option<Corners> {
    extent.map(|e| [cast(e.low), cast(e.high)])
}

/// The box around a cloth, now and one step before.
pub fn around<T: Real>(body: &Body<T>) -> Option<Corners> {
    corners(bounds::run(body.now(), body.before()))
}
