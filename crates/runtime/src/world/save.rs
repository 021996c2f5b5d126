//! The states of cloths and of the clock, out and in.

use super::World;
use crate::cloth::Cloth;
use crate::state::{ControlState, Head, Layout};

impl World {
    /// What the state of a cloth has beside its lists.
    pub fn head(&self, cloth: usize) -> Head {
        let (of, run) = (&self.scene.cloths[cloth], &self.runs[cloth]);
        Head {
            grids: of.grids().iter().map(|g| [g.width, g.height]).collect(),
            step: self.control.clock.dt_old,
            asleep: run.asleep,
            calm: run.calm.seconds(),
            home: run.home,
            layout: Layout::of(of, &run.tethers, self.control.options.solver),
        }
    }

    /// Takes over what a state has beside its lists, and its pins in ascending order. What waits for the next frame spares the
    /// cloth.
    pub fn take(&mut self, cloth: usize, head: &Head, pinned: &[u32]) {
        let of = &mut self.scene.cloths[cloth];
        let held = |c: &Cloth| c.particles().iter().any(|p| p.is_pinned());
        let was_held = held(of);
        let mut list = pinned.iter().peekable();
        let differ: Vec<(u32, bool)> = (0..of.len() as u32)
            .filter_map(|k| {
                let pin = list.next_if(|p| **p == k).is_some();
                let particle = of.particles()[k as usize];
                (particle.exists() && particle.is_pinned() != pin).then_some((k, pin))
            })
            .collect();
        differ.into_iter().for_each(|(k, pin)| of.hold_all([k].into_iter(), pin));
        if head.layout.cut {
            of.open();
        } else {
            of.close();
        }
        let is_held = held(of);
        self.host.forget(cloth);
        self.host.touched = true;
        self.runs[cloth].home = head.home;
        self.resume_sleep(cloth, head.asleep, head.calm);
        if was_held != is_held {
            self.decide();
        }
    }

    /// The state of the clock, and of what chooses substeps.
    pub fn save_control(&self) -> ControlState {
        self.control.save(self.watchdog.due)
    }

    /// Goes on from there.
    pub fn resume_control(&mut self, state: &ControlState) {
        self.control.resume(state, &self.scene);
        self.watchdog.due = state.due;
        self.host.raised = None;
        self.raise();
        self.reschedule();
    }
}
