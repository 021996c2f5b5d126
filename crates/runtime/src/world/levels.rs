//! Cloths that go on with a coarser image, or with the finer one again.

use std::sync::Arc;

use super::images::Images;
use super::{ClothRun, Left, World};
use crate::cloth::Cloth;
use crate::coarser::{Beside, Coarser, Motion, Table};
use crate::cpu::start::inverse_masses;
use crate::cpu::{prolong, restrict};
use crate::error::Result;
use crate::fused::{Roster, arenas};
use crate::limits::Warning;
use crate::number::real::with_w;
use crate::options::Solver;
use crate::scene::Pose;

/// The finer image that a cloth goes back to.
#[derive(Clone)]
pub struct Finer {
    pub(super) cloth: Cloth,
    pub(super) images: Arc<Images>,
    warnings: Vec<Warning>,
    pub(super) coarser: Coarser,
    beside: Beside,
    /// As [`Joints::joined`], of this image.
    joined: Arc<[u32]>,
}

/// A cloth that changes its level.
pub struct Switch {
    pub index: usize,
    cloth: Cloth,
    run: ClothRun,
    /// As [`Joints::joined`], of the level that it is on.
    joined: Arc<[u32]>,
    /// Its motion on the new level, where the host has it.
    pub motion: Option<Motion>,
    /// How a device carries its motion; empty where the host has it.
    pub legs: Vec<Leg>,
}

/// The way of a cloth's motion to the next level.
pub struct Leg {
    /// Whether that is a coarser one.
    pub down: bool,
    pub table: Arc<Table>,
    /// Of the particles on that level.
    pub inverse_masses: Vec<f32>,
    /// Pins between coarse texels, with ways as they were at the start.
    pub beside: Beside,
}

impl World {
    /// How many times the image of a cloth has been made coarser.
    pub fn level(&self, cloth: usize) -> u32 {
        self.runs[cloth].finer.len() as u32
    }

    /// The particle of the finest image that each particle of a cloth is.
    pub fn samples(&self, cloth: usize) -> Vec<u32> {
        let all = (0..self.scene.cloths[cloth].len() as u32).collect();
        let finer = self.runs[cloth].finer.iter().rev();
        finer.fold(all, |samples: Vec<u32>, f| samples.iter().map(|k| f.coarser.samples()[*k as usize]).collect())
    }

    /// A cloth on another level, from its motion on the present one, or with legs where none is given. Changes nothing.
    pub fn switch(&self, index: usize, level: u32, motion: Option<Motion>) -> Result<Switch> {
        let (cloth, now) = (self.scene.cloths[index].clone(), &self.runs[index]);
        cloth.refuse_cut()?;
        let mut run = now.images.clone().map_or_else(ClothRun::default, ClothRun::new);
        (run.finer, run.warnings) = (now.finer.clone(), now.warnings.clone());
        run.home = now.home;
        let joined = now.joints.as_ref().map_or_else(Arc::default, |joints| joints.joined.clone());
        let mut switch = Switch { index, cloth, run, joined, motion, legs: Vec::new() };
        while (switch.run.finer.len() as u32) < level {
            self.coarsen(&mut switch)?;
        }
        while switch.run.finer.len() as u32 > level {
            switch.refine(self.control.options.solver);
        }
        let run = &mut switch.run;
        (run.coat, run.calm, run.moving) = (now.coat, now.calm, now.moving);
        run.joints = now.joints.as_ref().map(|joints| joints.on_level(switch.joined.clone()));
        Ok(switch)
    }

    fn coarsen(&self, switch: &mut Switch) -> Result<()> {
        let Some(images) = switch.run.images.clone() else { return Ok(()) };
        let coarser = images.coarser()?;
        let home = switch.run.home;
        let beside = match &switch.motion {
            Some(motion) => coarser.beside(&switch.cloth, motion),
            None => coarser.beside(&switch.cloth, &at_start(&switch.cloth, &home)),
        };
        let mut cloth = coarser.instance(&switch.cloth);
        let hold = self.control.hold(switch.index);
        let known = images.below().into_iter().chain(self.runs.iter().filter_map(|run| run.images.as_ref()));
        let mut run = super::members::prepare(&mut cloth, &self.control.options, hold, (&self.scene.colliders, known))?;
        images.keep_below(run.images.as_ref());
        let solver = self.control.options.solver;
        let table = images.table(|| coarser.table(&switch.cloth, &cloth, solver));
        match &mut switch.motion {
            Some(motion) => {
                let mut coarse = Motion::room(inverse_masses(&cloth, solver));
                restrict::run(&table, motion, &mut coarse);
                *motion = coarse;
            }
            None => {
                let (inverse_masses, beside) = (inverse_masses(&cloth, solver), beside.clone());
                switch.legs.push(Leg { down: true, table, inverse_masses, beside });
            }
        }
        run.home = home;
        let cloth = std::mem::replace(&mut switch.cloth, cloth);
        run.finer = std::mem::take(&mut switch.run.finer);
        let warnings = std::mem::take(&mut switch.run.warnings);
        let below = coarser.pinned_by(&switch.joined);
        let joined = std::mem::replace(&mut switch.joined, below);
        run.finer.push(Finer { cloth, images, warnings, coarser, beside, joined });
        switch.run = run;
        Ok(())
    }

    /// Puts cloths on their new levels. Returns what each has left behind for the device. The other cloths stay as they are.
    pub fn replace(&mut self, switches: Vec<Switch>) -> Vec<Left> {
        let (mut left, mut indices) = (Vec::new(), Vec::new());
        for Switch { index, cloth, run, .. } in switches {
            let place = self.leave_arena(index);
            let cloth = std::mem::replace(&mut self.scene.cloths[index], cloth);
            let kept = self.runs[index].kept.take();
            self.runs[index] = run;
            self.runs[index].kept = kept;
            self.host.forget(index);
            (self.host.touched, self.host.put) = (true, true);
            self.wake(index);
            left.push(Left { index, cloth, place, recoated: false });
            if self.runs[index].joints.is_some() {
                let aim = self.aim(index);
                self.host.actions.push(aim);
            }
            indices.push(index);
        }
        if let Some(room) = &self.room {
            let cloths: Vec<Cloth> = indices.iter().map(|index| self.scene.cloths[*index].clone()).collect();
            let held = |n: usize| self.runs[indices[n]].instance();
            let found = arenas(&cloths, held, &self.control.options, room);
            let places = found
                .into_iter()
                .map(|list| Roster::new(list.cloths.into_iter().map(|n| indices[n]).collect(), list.sides));
            self.arenas.extend(places.collect::<Vec<_>>());
        }
        for index in &indices {
            self.runs[*index].schedule = self.schedule(*index, &self.control.options);
        }
        self.control.round = self.cost_of_round();
        self.fuse();
        left
    }
}

impl Switch {
    fn refine(&mut self, solver: Solver) {
        let Some(Finer { mut cloth, images, warnings, coarser, beside, joined }) = self.run.finer.pop() else { return };
        coarser.carry_pins(&mut cloth, &self.cloth);
        cloth.take_settings(&self.cloth);
        let table = images.table(|| coarser.table(&cloth, &self.cloth, solver));
        match &mut self.motion {
            Some(motion) => {
                let mut fine = Motion::room(inverse_masses(&cloth, solver));
                prolong::run(&table, motion, &beside, &mut fine);
                *motion = fine;
            }
            None => {
                let inverse_masses = inverse_masses(&cloth, solver);
                self.legs.push(Leg { down: false, table, inverse_masses, beside });
            }
        }
        (self.cloth, self.joined) = (cloth, joined);
        let (finer, home) = (std::mem::take(&mut self.run.finer), self.run.home);
        self.run = ClothRun::new(images);
        (self.run.finer, self.run.warnings, self.run.home) = (finer, warnings, home);
    }
}

/// Where a cloth is at its start, moved by teleports.
pub(super) fn at_start(cloth: &Cloth, home: &Pose) -> Motion {
    let now: Vec<_> = cloth.positions().iter().map(|p| with_w(home.apply(*p), 0.0)).collect();
    Motion { before: now.clone(), now }
}
