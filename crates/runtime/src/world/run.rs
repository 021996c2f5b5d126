//! A frame on the CPU.

use super::sleep::around;
use super::{Fault, World};
use crate::cpu::body::Body;
use crate::cpu::fused;
use crate::cpu::rows::Threads;
use crate::findings::passing::{Passing, search};
use crate::findings::{Watchdog, is_risky};
use crate::number::real::Real;

/// A cloth that is awake in a frame.
struct Move<'a, T: Real> {
    index: usize,
    body: &'a mut Body<T>,
    /// Particles that went through colliders in it.
    passings: Vec<Passing>,
}

impl World {
    /// Runs a frame of `steps` steps on the CPU. Threads share the cloths, and the rows of large ones; each cloth gets the same bits.
    pub fn run<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let solids = self.solids::<T>();
        self.meet_others(bodies, threads, steps);
        let seconds = f64::from(steps) * self.control.clock.dt;
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        let due = watchdog.is_due(self.control.clock.time + seconds);
        let mut moves: Vec<Move<T>> = Vec::new();
        let awake = bodies.iter_mut().enumerate().filter(|(index, _)| !self.runs[*index].asleep);
        moves.extend(awake.map(|(index, body)| Move { index, body, passings: Vec::new() }));
        let particles = moves.iter().map(|m| m.body.now().len()).sum::<usize>();
        threads.each(&mut moves, particles * steps as usize, |of| {
            let Move { index, body, passings } = of;
            let (cloth, frame) = (&self.scene.cloths[*index], self.frame(*index, steps));
            body.bound_diagonals(T::of(cloth.bound(self.control.clock.dt).into()));
            let met = &solids[self.runs[*index].coat];
            let risky = !met.is_empty() && is_risky(body.now(), body.before(), met, self.control.clock.dt, seconds);
            let prior = risky.then(|| body.now().to_vec());
            fused::run(body, &frame, threads, met);
            *passings = prior.map_or_else(Vec::new, |prior| search(met, body.now(), &prior, seconds));
        });
        // In the order of the cloths, whichever was done first.
        for Move { index, body, passings } in moves {
            let met = &solids[self.runs[index].coat];
            let sight = self.sight(index, (body.now(), body.before()), met, seconds);
            watchdog.cross(&sight, &passings);
            if due && watchdog.knows(index, sight.time) {
                watchdog.examine(&sight);
            }
            if let Some((particles, particle)) = body.faulty.take() {
                let time = self.control.clock.time + seconds;
                self.host.report(Fault { cloth: index, particle, particles, time });
            }
            if let Some(error) = body.strain.take() {
                self.control.chooser.measured(error.get());
            }
            if let Some(limit) = self.calm_below().filter(|_| steps > 0) {
                self.note(index, body.fastest.get() <= limit, seconds, || around(body));
            }
        }
        if due {
            watchdog.done(self.control.clock.time + seconds);
        }
        self.watchdog = watchdog;
        self.forget_paths();
        self.host.touched = false;
        self.control.tick(steps);
    }
}
