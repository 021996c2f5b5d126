//! Contact between cloths on the CPU: finds the particles of other cloths that each cloth may touch in a frame.

use super::World;
use crate::cpu::body::Body;
use crate::cpu::fabric::meeting::shadow::Shadow;
use crate::cpu::rows::Threads;
use crate::limits::Warning;
use crate::number::real::Real;
use crate::options::Solver;

/// A cloth that other cloths may touch.
struct Neighbour<'a, T: Real> {
    index: usize,
    body: &'a mut Body<T>,
    shadow: Option<Shadow<T>>,
    /// Cloths that it wakes.
    struck: Vec<usize>,
}

impl World {
    /// Has cloths that have contact find those particles of other cloths that they may touch in a frame of `steps` steps. Cloth that is asleep
    /// wakes if particles touch it that move faster than [`crate::Sleep::speed`].
    pub(super) fn meet_others<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let touches = self.scene.cloths.iter().filter(|cloth| cloth.contact.is_some()).count();
        if touches == 0 || steps == 0 {
            return;
        }
        if touches == 1 {
            // Others may have left.
            return bodies.iter_mut().enumerate().for_each(|(index, body)| _ = body.meet(&[], index));
        }
        // Cloth that wakes may wake more.
        loop {
            let struck = self.meet_once(bodies, threads, steps);
            if struck.is_empty() {
                return;
            }
            struck.into_iter().for_each(|cloth| self.wake(cloth));
        }
    }

    /// One search; returns the cloths that are asleep and wake.
    fn meet_once<T: Real>(&self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) -> Vec<usize> {
        let clock = &self.control.clock;
        let length = T::of(f64::from(steps) * clock.dt);
        let speed = self.control.options.sleep.map_or(f64::INFINITY, |sleep| sleep.speed);
        let each = bodies.iter_mut().enumerate();
        let mut all: Vec<_> =
            each.map(|(index, body)| Neighbour { index, body, shadow: None, struck: Vec::new() }).collect();
        let particles = all.iter().map(|n| n.body.count()).sum();
        threads.each(&mut all, particles, |n| {
            let (rate, wakes_at) =
                if self.runs[n.index].asleep { (0.0, speed) } else { (1.0 / clock.dt_old, f64::INFINITY) };
            n.shadow = n.body.shadow(T::of(rate), length, T::of(wakes_at));
        });
        let shadows: Vec<Option<Shadow<T>>> = all.iter_mut().map(|n| n.shadow.take()).collect();
        threads.each(&mut all, particles, |n| {
            if !self.runs[n.index].asleep {
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

    /// A warning if contact between the scene's cloths is left out on a backend.
    pub fn contact_warning(&self, on_gpu: bool) -> Option<Warning> {
        let mut touching = self.scene.cloths.iter().filter(|cloth| cloth.contact.is_some());
        let cloth = touching.next()?.name().to_owned();
        if self.control.options.solver == Solver::Classic {
            return Some(Warning::ContactClassic { cloth });
        }
        let other = touching.next()?.name().to_owned();
        on_gpu.then_some(Warning::ContactApart { cloth, other })
    }
}
