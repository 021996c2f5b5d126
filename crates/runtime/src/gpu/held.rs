//! Cloths whose contact is safe: after each step of all of them particles are held back, so that no triangle crosses another one.

use std::mem::take;

use bytemuck::cast_slice;

use super::joint::Joint;
use super::recording::Recording;
use super::{Gpu, Offsets};
use crate::passes::Pass;
use crate::shaders::list;
use crate::world::World;

impl Gpu {
    /// Records, as a frame begins, where the cloths are. Those that are asleep are shown once, and again where anything was done to cloths.
    pub(super) fn begin_safe(&mut self, world: &World, passes: &mut Recording) {
        let Some(mut joint) = self.joint.take() else { return };
        let (put, touched) = (take(&mut joint.put), take(&mut joint.touched));
        for member in (0..joint.cloths.len()).filter(|member| joint.safe[*member]) {
            let cloth = joint.cloths[member];
            let sleeps = world.runs[cloth].asleep;
            let holes = world.scene.cloths[cloth].is_cut();
            if put || touched && holes {
                self.cloths[cloth].separate(&self.device, world, cloth);
                self.run_safe(world, passes, cloth, Pass::Faces { holes });
            }
            if put || touched || !sleeps || !joint.shown[member] {
                self.run_safe(world, passes, cloth, Pass::Gather { begins: true, put, sleeps });
            }
            joint.shown[member] = sleeps;
        }
        if joint.safe.contains(&true) {
            joint.rounds = std::array::from_fn(|n| self.frames.ring.place(cast_slice(&[n as f32, 0.0, 0.0, 0.0])));
        }
        self.joint = Some(joint);
    }

    /// Records that particles are held back at the end of a step.
    pub(super) fn hold_back(&mut self, world: &World, passes: &mut Recording) {
        let Some(mut joint) = self.joint.take() else { return };
        let moves = |(cloth, safe): &(&usize, &bool)| **safe && !world.runs[**cloth].asleep;
        let cloths: Vec<usize> = joint.cloths.iter().zip(&joint.safe).filter(moves).map(|(cloth, _)| *cloth).collect();
        if !cloths.is_empty() {
            let gather = Pass::Gather { begins: false, put: false, sleeps: false };
            cloths.iter().for_each(|cloth| self.run_safe(world, passes, *cloth, gather));
            joint.rounds.into_iter().for_each(|part| self.truncate(passes, &mut joint, part));
            for cloth in cloths {
                let exact = world.scene.cloths[cloth].is_exact();
                self.run_safe(world, passes, cloth, Pass::HoldBack { exact });
            }
        }
        self.joint = Some(joint);
    }

    /// Records a round, whose number lies at `part`.
    fn truncate(&mut self, passes: &mut Recording, joint: &mut Joint, part: u32) {
        let texels = list(16 * joint.layout.tiles);
        for (what, groups) in [(Pass::Paths, texels), (Pass::Tree, [1; 3]), (Pass::Truncate, texels)] {
            self.run_joint(passes, joint, (what, part), groups);
        }
    }

    fn run_safe(&mut self, world: &World, passes: &mut Recording, cloth: usize, what: Pass) {
        self.run_in(&world.scene.cloths[cloth], passes, cloth, (&what.into(), Offsets::default()));
    }
}
