//! Cloths that go on with a coarser image, or with the finer one again.

use std::sync::Arc;

use super::follow::Joints;
use super::images::Images;
use super::{Action, ClothRun, Left, World};
use crate::cloth::Cloth;
use crate::coarser::{Beside, Coarser, Motion, settle};
use crate::error::Result;
use crate::fused::{Roster, arenas};
use crate::limits::Warning;

/// The finer image that a cloth goes back to.
#[derive(Clone)]
pub struct Finer {
    cloth: Cloth,
    images: Arc<Images>,
    warnings: Vec<Warning>,
    coarser: Coarser,
    beside: Beside,
}

/// A cloth that changes its level.
pub struct Switch {
    pub index: usize,
    cloth: Cloth,
    run: ClothRun,
    motion: Motion,
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

    /// A cloth on another level, from its motion on the present one. Changes nothing.
    pub fn switch(&self, index: usize, level: u32, motion: Motion) -> Result<Switch> {
        let (cloth, now) = (self.scene.cloths[index].clone(), &self.runs[index]);
        cloth.refuse_cut()?;
        let mut run = now.images.clone().map_or_else(ClothRun::default, ClothRun::new);
        (run.finer, run.warnings) = (now.finer.clone(), now.warnings.clone());
        let mut switch = Switch { index, cloth, run, motion };
        while (switch.run.finer.len() as u32) < level {
            self.coarsen(&mut switch)?;
        }
        while switch.run.finer.len() as u32 > level {
            switch.refine();
        }
        let run = &mut switch.run;
        (run.coat, run.home, run.calm) = (now.coat, now.home, now.calm);
        run.joints = Joints::of(&switch.cloth);
        if let (Some(joints), Some(before)) = (&mut run.joints, &now.joints) {
            joints.go_on(before);
        }
        Ok(switch)
    }

    fn coarsen(&self, switch: &mut Switch) -> Result<()> {
        let Some(images) = switch.run.images.clone() else { return Ok(()) };
        let coarser = images.coarser()?;
        let beside = coarser.beside(&switch.cloth, &switch.motion);
        let mut cloth = coarser.instance(&switch.cloth);
        let slack = self.control.options.slack.get(switch.index).copied().unwrap_or(1.0);
        let known = images.below().into_iter().chain(self.runs.iter().filter_map(|run| run.images.as_ref()));
        let mut run =
            super::members::prepare(&mut cloth, &self.control.options, slack, (&self.scene.colliders, known))?;
        images.keep_below(run.images.as_ref());
        switch.motion = coarser.restrict(&cloth, &switch.motion);
        settle(&cloth, &mut switch.motion);
        let cloth = std::mem::replace(&mut switch.cloth, cloth);
        run.finer = std::mem::take(&mut switch.run.finer);
        let warnings = std::mem::take(&mut switch.run.warnings);
        run.finer.push(Finer { cloth, images, warnings, coarser, beside });
        switch.run = run;
        Ok(())
    }

    /// Puts cloths on their new levels. `left` has what each has left behind for the device. The other cloths stay as they are.
    pub fn replace(&mut self, switches: Vec<Switch>) -> (Vec<Left>, Vec<(usize, Motion)>) {
        let (mut left, mut motions) = (Vec::new(), Vec::new());
        for Switch { index, cloth, run, motion } in switches {
            let place = self.leave_arena(index);
            let cloth = std::mem::replace(&mut self.scene.cloths[index], cloth);
            self.runs[index] = run;
            self.host.forget(index);
            self.host.touched = true;
            self.wake(index);
            left.push(Left { index, cloth, place, recoated: false });
            if self.runs[index].joints.is_some() {
                self.host.actions.push(Action::Aim { cloth: index });
            }
            motions.push((index, motion));
        }
        if let Some(room) = &self.room {
            let cloths: Vec<Cloth> = motions.iter().map(|(index, _)| self.scene.cloths[*index].clone()).collect();
            let held = |n: usize| self.runs[motions[n].0].instance();
            let found = arenas(&cloths, held, &self.control.options, room);
            let places = found.into_iter().map(|list| {
                let cloths = list.cloths.into_iter().map(|n| motions[n].0).collect();
                Roster { cloths, sides: list.sides }
            });
            self.arenas.extend(places.collect::<Vec<_>>());
        }
        for (index, _) in &motions {
            self.runs[*index].schedule = self.schedule(*index, &self.control.options);
        }
        self.control.round = self.cost_of_round();
        self.fuse();
        (left, motions)
    }
}

impl Switch {
    fn refine(&mut self) {
        let Some(Finer { mut cloth, images, warnings, coarser, beside }) = self.run.finer.pop() else { return };
        let mut motion = coarser.prolong(&self.motion);
        coarser.put_beside(&beside, &self.motion, &mut motion);
        coarser.carry_pins(&mut cloth, &self.cloth);
        cloth.take_settings(&self.cloth);
        self.motion = motion;
        self.cloth = cloth;
        let finer = std::mem::take(&mut self.run.finer);
        self.run = ClothRun::new(images);
        (self.run.finer, self.run.warnings) = (finer, warnings);
    }
}
