//! The last state of a cloth in the host's memory, from which it continues if the device is lost.

use super::World;
use super::levels::at_start;
use crate::coarser::Motion;
use crate::cpu::start::inverse_masses;
use crate::cpu::{prolong, restrict};
use crate::scene::Pose;
use crate::state::{ClothState, Head, Layout};

impl World {
    /// That state on the level that the cloth has now; none where the host has seen none. A state of another level is carried over as
    /// a device carries motion. Pins are then those that the cloth has now; pins between coarse texels lie beside the nearest as at the
    /// start.
    pub fn kept_state(&self, index: usize) -> Option<ClothState> {
        let (kept, now) = (self.runs[index].kept.as_ref()?, self.level(index));
        let state = &kept.state;
        if kept.level == now {
            return Some(state.clone());
        }
        if state.head.layout.cut {
            return None;
        }
        let motion = Motion { now: state.positions().to_vec(), before: state.previous().to_vec() };
        let motion = match kept.level < now {
            true => self.kept_down(index, kept.level as usize, motion),
            false => self.kept_up(index, kept.level - now, motion, &state.head.home)?,
        };
        let cloth = &self.scene.cloths[index];
        let head = Head {
            grids: cloth.grids().iter().map(|g| [g.width, g.height]).collect(),
            asleep: false,
            calm: 0.0,
            layout: Layout { particles: cloth.len(), ..Layout::default() },
            ..state.head.clone()
        };
        let words = [&motion.now, &motion.before].into_iter().flatten().flatten();
        Some(ClothState::new(head, words.map(|x| x.to_bits()).collect()))
    }

    /// From a finer level to the present one.
    fn kept_down(&self, index: usize, level: usize, mut motion: Motion) -> Motion {
        let (finer, solver) = (&self.runs[index].finer, self.control.options.solver);
        for (n, fine) in finer.iter().enumerate().skip(level) {
            let coarse = finer.get(n + 1).map_or(&self.scene.cloths[index], |f| &f.cloth);
            let table = fine.images.table(|| fine.coarser.table(&fine.cloth, coarse, solver));
            let mut next = Motion::room(inverse_masses(coarse, solver));
            restrict::run(&table, &motion, &mut next);
            motion = next;
        }
        motion
    }

    /// From a level that is coarser by a number of images to the present one.
    fn kept_up(&self, index: usize, levels: u32, mut motion: Motion, home: &Pose) -> Option<Motion> {
        let (run, solver) = (&self.runs[index], self.control.options.solver);
        let (mut images, mut cloth) = (run.images.clone()?, self.scene.cloths[index].clone());
        let mut passed = Vec::new();
        for _ in 0..levels {
            let coarser = images.coarser().ok()?;
            let coarse = coarser.instance(&cloth);
            let table = images.table(|| coarser.table(&cloth, &coarse, solver));
            let below = images.below()?.clone();
            passed.push((table, coarser, std::mem::replace(&mut cloth, coarse)));
            images = below;
        }
        for (table, coarser, fine) in passed.iter().rev() {
            let mut next = Motion::room(inverse_masses(fine, solver));
            prolong::run(table, &motion, &coarser.beside(fine, &at_start(fine, home)), &mut next);
            motion = next;
        }
        Some(motion)
    }
}
