//! A frame on the CPU.

use super::sleep::around;
use super::{Fault, World};
use crate::cpu::body::Body;
use crate::cpu::fused;
use crate::cpu::rows::Threads;
use crate::findings::passing::{Passing, search};
use crate::findings::{Fate, Watchdog, is_risky, thrown};
use crate::number::real::Real;

/// A cloth that is awake in a frame.
struct Move<'a, T: Real> {
    index: usize,
    body: &'a mut Body<T>,
    watch: &'a mut Watch<T>,
}

/// How a cloth may fail in a frame.
struct Watch<T> {
    /// Where its particles were as the frame began, if they may go through colliders.
    prior: Option<Vec<[T; 4]>>,
    /// Particles that went through colliders in it.
    passings: Vec<Passing>,
    /// Whether something was put elsewhere before it, and what became of the cloth inside colliders.
    is_put: bool,
    thrown: Option<(Fate, usize)>,
}

impl World {
    /// Runs a frame of `steps` steps on the CPU. Threads share the cloths, and the rows of large ones; each cloth gets the same bits. Cloths
    /// that touch one another make each step before any of them makes the next one; all others make one frame each.
    pub fn run<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let solids = self.solids::<T>();
        self.begin_safe(bodies);
        self.begin_tangles(bodies);
        self.meet_others(bodies, threads, steps);
        let together = self.step_together();
        let seconds = f64::from(steps) * self.control.clock.dt;
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        let due = watchdog.is_due(self.control.clock.time + seconds);
        let mut watches: Vec<Watch<T>> = Vec::new();
        watches.resize_with(bodies.len(), || Watch { prior: None, passings: Vec::new(), is_put: false, thrown: None });
        if self.host.put {
            watchdog.put();
        }
        if steps > 0 {
            let awake = watches.iter_mut().enumerate().filter(|(index, _)| !self.runs[*index].asleep);
            awake.for_each(|(index, watch)| watch.is_put = watchdog.take_put(index));
        }
        let mut each =
            |world: &World, bodies: &mut [Body<T>], chosen: bool, work: &(dyn Fn(&World, &mut Move<T>) + Sync)| {
                let both = bodies.iter_mut().zip(&mut watches).enumerate();
                let here = both.filter(|(index, _)| !world.runs[*index].asleep && together[*index] == chosen);
                let mut moves: Vec<_> = here.map(|(index, (body, watch))| Move { index, body, watch }).collect();
                let particles = moves.iter().map(|m| m.body.now().len()).sum::<usize>();
                threads.each(&mut moves, particles * steps as usize, |of| work(world, of));
            };
        let start = |world: &World, Move { index, body, watch }: &mut Move<T>| {
            let (cloth, dt) = (&world.scene.cloths[*index], world.control.clock.dt);
            body.bound_diagonals(T::of(cloth.bound(dt).into()));
            let met = &solids[world.runs[*index].coat];
            let risky = !met.is_empty() && is_risky(body.now(), body.before(), met, dt, seconds);
            watch.prior = risky.then(|| body.now().to_vec());
            watch.thrown = watch.is_put.then(|| thrown::search(body.now(), met, dt, seconds)).flatten();
        };
        let finish = |world: &World, Move { index, body, watch }: &mut Move<T>| {
            let met = &solids[world.runs[*index].coat];
            watch.passings = watch.prior.take().map_or_else(Vec::new, |prior| search(met, body.now(), &prior, seconds));
        };
        each(self, bodies, false, &|world, of| {
            start(world, of);
            fused::run(of.body, &world.frame(of.index, steps), threads, &solids[world.runs[of.index].coat]);
            finish(world, of);
        });
        if together.contains(&true) {
            each(self, bodies, true, &|world, of| {
                start(world, of);
                of.body.begin();
            });
            for n in 0..steps {
                self.meet_again(bodies, threads, n, steps);
                each(self, bodies, true, &|world, of| {
                    let met = &solids[world.runs[of.index].coat];
                    fused::step(of.body, &world.frame(of.index, steps), n, threads, met);
                });
                self.move_tangles(bodies);
                self.step_safe(bodies, threads);
                self.look_again(bodies, n, steps);
            }
            each(self, bodies, true, &|world, of| {
                fused::end(of.body, &world.frame(of.index, steps), threads, &solids[world.runs[of.index].coat]);
                finish(world, of);
            });
        }
        let mut crossed = self.end_safe(bodies);
        crossed.extend(self.end_tangles(bodies, seconds));
        // In the order of the cloths, whichever was done first.
        for (index, (body, watch)) in bodies.iter_mut().zip(watches).enumerate() {
            if self.runs[index].asleep {
                continue;
            }
            let met = &solids[self.runs[index].coat];
            let sight = self.sight(index, (body.now(), body.before()), met, seconds);
            watchdog.cross(&sight, &watch.passings);
            watchdog.throw(&sight, watch.thrown);
            crossed.iter().filter(|(cloth, _)| *cloth == index).for_each(|(_, fate)| watchdog.find(&sight, *fate));
            if let Some(fate) = self.squeezed(index, body.now(), met) {
                watchdog.find(&sight, fate);
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
        (self.host.touched, self.host.put) = (false, false);
        self.control.tick(steps);
    }
}
