//! Contact between cloths on the CPU: finds the particles of other cloths that each cloth may touch in a frame.

use super::truncate::is_safe;
use super::{ClothRun, World};
use crate::cloth::Cloth;
use crate::cpu::body::Body;
use crate::cpu::fabric::meeting::shadow::Shadow;
use crate::cpu::rows::Threads;
use crate::limits::Warning;
use crate::number::real::Real;
use crate::options::Solver;
use crate::passes::{FOLLOW_STEPS, MEETING_STEPS};

/// A cloth that other cloths may touch.
struct Neighbour<'a, T: Real> {
    index: usize,
    body: &'a mut Body<T>,
    shadow: Option<Shadow<T>>,
    /// Cloths that it wakes.
    struck: Vec<usize>,
}

impl World {
    /// Whether each cloth makes every step together with others: cloths that touch one another, and cloth whose contact is safe.
    pub(super) fn step_together(&self) -> Vec<bool> {
        let cloths = &self.scene.cloths;
        let many = cloths.iter().filter(|cloth| cloth.contact.is_some()).count() > 1;
        let tangled = self.tangles.some.is_some();
        let xpbd = self.control.options.solver == Solver::Xpbd;
        cloths.iter().map(|cloth| xpbd && cloth.contact.is_some() && (many || tangled || is_safe(cloth))).collect()
    }

    /// Whether no triangle of some cloth shall cross others.
    pub fn has_safe(&self) -> bool {
        let xpbd = self.control.options.solver == Solver::Xpbd;
        xpbd && self.scene.cloths.iter().any(is_safe)
    }

    /// The cloths that may touch one another, by index.
    pub fn meeting(&self) -> Vec<usize> {
        let xpbd = self.control.options.solver == Solver::Xpbd;
        let cloths = self.scene.cloths.iter().enumerate();
        cloths.filter(|(_, cloth)| xpbd && cloth.contact.is_some()).map(|(index, _)| index).collect()
    }

    /// Has cloths that have contact find those particles of other cloths that they may touch in the first steps of a frame of `steps` steps.
    /// Cloth that is asleep wakes if particles touch it that move faster than [`crate::Sleep::speed`].
    pub(super) fn meet_others<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let touches = self.scene.cloths.iter().filter(|cloth| cloth.contact.is_some()).count();
        if touches == 0 || steps == 0 {
            return;
        }
        if touches == 1 {
            // Others may have left.
            return bodies.iter_mut().enumerate().for_each(|(index, body)| _ = body.meet(&[], index));
        }
        // Cloth that wakes may wake more. Where some is asleep, boxes are those of a whole frame, so that it wakes in time.
        loop {
            let sleeps = |(cloth, run): (&Cloth, &ClothRun)| cloth.contact.is_some() && run.asleep;
            let some = self.scene.cloths.iter().zip(&self.runs).any(sleeps);
            let ahead = if some { steps } else { steps.min(MEETING_STEPS) };
            let struck = self.meet_once(bodies, threads, (ahead, self.control.clock.dt_old), true);
            if struck.is_empty() {
                return;
            }
            struck.into_iter().for_each(|cloth| self.wake(cloth));
        }
    }

    /// The same before step `n`, from where the cloths are then.
    pub(super) fn meet_again<T: Real>(&self, bodies: &mut [Body<T>], threads: &Threads, n: u32, steps: u32) {
        let touches = self.scene.cloths.iter().filter(|cloth| cloth.contact.is_some()).count();
        if n == 0 || touches < 2 || !n.is_multiple_of(FOLLOW_STEPS) {
            return;
        }
        let awake = |(index, _): &(usize, &mut Body<T>)| {
            !self.runs[*index].asleep && self.scene.cloths[*index].contact.is_some()
        };
        bodies.iter_mut().enumerate().filter(awake).for_each(|(_, body)| body.show());
        let searches = n.is_multiple_of(MEETING_STEPS);
        let ahead = if searches { MEETING_STEPS } else { FOLLOW_STEPS };
        self.meet_once(bodies, threads, (ahead.min(steps - n), self.control.clock.dt), searches);
    }

    /// One search for `steps` steps, or a look at what was found; the last step was one of `dt` \[s\]. Returns the cloths that are asleep and wake.
    fn meet_once<T: Real>(
        &self,
        bodies: &mut [Body<T>],
        threads: &Threads,
        (steps, dt): (u32, f64),
        searches: bool,
    ) -> Vec<usize> {
        let clock = &self.control.clock;
        let length = T::of(f64::from(steps) * clock.dt);
        let speed = self.control.options.sleep.map_or(f64::INFINITY, |sleep| sleep.speed);
        let each = bodies.iter_mut().enumerate();
        let mut all: Vec<_> =
            each.map(|(index, body)| Neighbour { index, body, shadow: None, struck: Vec::new() }).collect();
        let particles = all.iter().map(|n| n.body.count()).sum();
        threads.each(&mut all, particles, |n| {
            let (rate, wakes_at) = if self.runs[n.index].asleep { (0.0, speed) } else { (1.0 / dt, f64::INFINITY) };
            n.shadow = n.body.shadow(T::of(rate), length, T::of(wakes_at));
        });
        let shadows: Vec<Option<Shadow<T>>> = all.iter_mut().map(|n| n.shadow.take()).collect();
        threads.each(&mut all, particles, |n| {
            if self.runs[n.index].asleep {
                return;
            }
            if !searches {
                n.body.follow_others(&shadows, n.index);
            } else {
                n.struck = n.body.meet(&shadows, n.index);
            }
        });
        let mut struck = Vec::new();
        for (n, shadow) in all.into_iter().zip(shadows) {
            struck.extend(n.struck);
            if let Some(shadow) = shadow {
                n.body.keep(shadow);
            }
        }
        struck
    }

    /// A warning where the solver has no contact of the scene's cloths.
    pub fn contact_warnings(&self) -> Option<Warning> {
        let cloth = self.scene.cloths.iter().find(|cloth| cloth.contact.is_some())?;
        let classic = self.control.options.solver == Solver::Classic;
        classic.then(|| Warning::ContactClassic { cloth: cloth.name().to_owned() })
    }
}
