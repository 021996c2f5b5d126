//! A frame on the CPU.

use super::sleep::around;
use super::{Fault, World};
use crate::cpu::body::Body;
use crate::cpu::fused;
use crate::cpu::rows::Threads;
use crate::findings::{Watchdog, is_risky};
use crate::number::real::{Real, xyz};

impl World {
    /// Runs a frame of `steps` steps on the CPU.
    pub fn run<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let solids = self.solids::<T>();
        let seconds = f64::from(steps) * self.control.clock.dt;
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        let due = watchdog.is_due(self.control.clock.time + seconds);
        for (index, body) in bodies.iter_mut().enumerate() {
            if self.runs[index].asleep {
                continue;
            }
            let (cloth, frame) = (&self.scene.cloths[index], self.frame(index, steps));
            body.bound_diagonals(T::of(cloth.bound(self.control.clock.dt).into()));
            let met = &solids[self.runs[index].coat];
            let risky = !met.is_empty() && is_risky(body.now(), body.before(), met, self.control.clock.dt, seconds);
            let prior = if risky { body.now().iter().map(|p| xyz(*p)).collect() } else { Vec::new() };
            fused::run(body, &frame, threads, met);
            let sight = self.sight(index, (body.now(), body.before()), met, seconds);
            if risky {
                watchdog.cross(&sight, &prior, seconds);
            }
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
