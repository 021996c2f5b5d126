//! The state that both backends share: the scene, its schedules and the clock.

use crate::actions::Action;
use crate::clock::Clock;
use crate::cloth::Cloth;
use crate::cpu::body::Body;
use crate::cpu::real::Real;
use crate::cpu::rows::Threads;
use crate::cpu::solid::Solid;
use crate::error::{Error, Result};
use crate::options::Options;
use crate::passes::{Kinds, Schedule, schedule};
use crate::scene::Scene;
use crate::sleep::Calm;
use crate::step::{Step, StepInput};

/// A scene, what is to be run for it, and when.
pub struct World {
    pub scene: Scene,
    pub options: Options,
    pub clock: Clock,
    pub schedules: Vec<Schedule>,
    pub asleep: Vec<bool>,
    /// How long each cloth has been calm.
    pub calm: Vec<Calm>,
    /// What users have done since the last frame.
    pub actions: Vec<Action>,
}

impl World {
    pub fn new(scene: Scene, options: Options) -> Result<Self> {
        options.check()?;
        scene.check()?;
        let clock = Clock::new(&options);
        let asleep = vec![false; scene.cloths.len()];
        let (calm, actions) = (vec![Calm::default(); scene.cloths.len()], Vec::new());
        let mut world = World { scene, options, clock, schedules: Vec::new(), asleep, calm, actions };
        world.reschedule();
        Ok(world)
    }

    /// Works out which passes run; to be called when colliders, wind, rest lengths or seams have changed.
    pub fn reschedule(&mut self) {
        let kinds = Kinds::of(&self.scene.colliders);
        let wind = self.scene.wind.as_ref();
        self.schedules = self.scene.cloths.iter().map(|c| schedule(c, kinds, wind, &self.options)).collect();
        self.watch();
    }

    /// The numbers of the next step of a cloth.
    pub fn step(&self, cloth: &Cloth, first: bool) -> Step<f64> {
        let (dt, dt_old) = (self.clock.dt, if first { self.clock.dt_old } else { self.clock.dt });
        Step::new(&StepInput {
            gravity: self.scene.gravity,
            wind: self.scene.wind.as_ref(),
            damping: cloth.damping,
            speed_limit: cloth.speed_limit,
            dt,
            dt_old,
            // The noise stands still within a frame, so that its steps share their numbers.
            time: self.clock.time,
        })
    }

    /// Time \[s\] from the end of step `n` of `steps` to the end of the frame, where colliders move; else 0.
    pub fn left(&self, n: u32, steps: u32) -> f64 {
        let moves = |c: &crate::collider::Collider| [c.velocity, c.spin].as_flattened().iter().any(|x| *x != 0.0);
        let swept = self.options.solver == crate::options::Solver::Xpbd;
        if swept && self.scene.colliders.iter().any(moves) { f64::from(steps - 1 - n) * self.clock.dt } else { 0.0 }
    }

    pub fn cloth(&self, index: usize) -> Result<&Cloth> {
        let count = self.scene.cloths.len();
        self.scene.cloths.get(index).ok_or(Error::NoSuch { what: "cloth", index, count })
    }

    /// Bodies of all cloths at the start.
    pub fn bodies<T: Real>(&self) -> Vec<Body<T>> {
        self.scene.cloths.iter().map(|c| Body::new(c, &self.options)).collect()
    }

    /// Runs a frame of `steps` steps on the CPU.
    pub fn run<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let solids: Vec<Solid<T>> = self.scene.colliders.iter().map(Solid::new).collect();
        for (index, body) in bodies.iter_mut().enumerate() {
            if self.asleep[index] {
                continue;
            }
            let (cloth, plan) = (&self.scene.cloths[index], &self.schedules[index]);
            let numbers = [self.step(cloth, true).cast::<T>(), self.step(cloth, false).cast()];
            body.begin();
            for n in 0..steps {
                let left = T::of(self.left(n, steps));
                let step = &Step { left, ..numbers[usize::from(n > 0)] };
                let relax = (0..self.options.iterations).flat_map(|_| &plan.relax);
                body.step(plan.step.iter().chain(relax), threads, step, &solids);
            }
            body.end();
            let last = &numbers[usize::from(steps > 1)];
            plan.frame.iter().for_each(|pass| body.run(*pass, threads, last, &solids));
            if let Some(limit) = self.calm_below() {
                let seconds = f64::from(steps) * self.clock.dt;
                self.note(index, body.fastest.get() <= limit, seconds);
            }
        }
        (0..steps).for_each(|_| self.clock.tick());
    }
}
