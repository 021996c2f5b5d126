//! The states of cloths and of the clock, out and in.

use super::World;
use crate::cloth::Cloth;
use crate::state::{ControlState, Head, Layout};

impl World {
    /// The head of a cloth's state.
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

    /// Takes over the head of a state, and its pins in ascending order. Actions that wait for the next frame spare the cloth.
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
        (self.host.touched, self.host.put) = (true, true);
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

    /// Continues from there.
    pub fn resume_control(&mut self, state: &ControlState) {
        let changed = self.control.resume(state, &self.scene);
        self.watchdog.due = state.due;
        self.host.raised = None;
        self.raise();
        if changed {
            self.reschedule();
        }
    }
}
