//! Requests of the host, and reports to it.

use std::sync::Arc;

use super::World;
use crate::cloth::Rows;
use crate::cpu::body::Body;
use crate::cpu::place::Placed;
use crate::cpu::rows::Threads;
use crate::handle::follow;
use crate::limits::Warning;
use crate::number::real::{Real, cast};
use crate::state::Layout;

/// An action before the next step; actions run in the order of the calls.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// A cut by the triangle with these corners, through all cloths but some: those whose state was set since.
    Cut { corners: [[f32; 3]; 3], spared: Vec<usize> },
    /// Particles of a cloth, all duplicates among them, are moved by the matrix with these columns.
    Transform { cloth: usize, chosen: Vec<u32>, matrix: [[f32; 4]; 4] },
    /// Particles of a cloth, all duplicates among them, are put in their places, pinned or freed.
    Place { cloth: usize, rows: Vec<Placed> },
    /// The targets of a cloth's limits follow its start, which a teleport has moved; not of cloth that follows joints.
    Aim { cloth: usize },
    /// The joints of a cloth move from where the frame begins, if that is given, to where it ends; `rate` \[1/s\] is one over its length,
    /// or 0.
    Skin { cloth: usize, from: Option<Arc<[Rows]>>, to: Arc<[Rows]>, rate: f32 },
    /// The frame of reference of a cloth has moved: the numbers of [`crate::moving_frame::Impulse`].
    Inertia { cloth: usize, numbers: [[f32; 4]; 7] },
    /// The lists of a state take the place of those on the device.
    Load { cloth: usize, layout: Layout, words: Vec<u32> },
}

impl Action {
    /// The cloth, if it is one alone.
    fn cloth(&self) -> Option<usize> {
        match self {
            Action::Cut { .. } => None,
            Action::Transform { cloth, .. }
            | Action::Place { cloth, .. }
            | Action::Aim { cloth }
            | Action::Skin { cloth, .. }
            | Action::Inertia { cloth, .. }
            | Action::Load { cloth, .. } => Some(*cloth),
        }
    }
}

/// A frame that was taken back: particles were NaN, or more than 1e8 m away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Index of the cloth when the host asks. Faults of a removed cloth are dropped.
    pub cloth: usize,
    /// The last of the particles at fault.
    pub particle: usize,
    /// How many there were.
    pub particles: usize,
    /// End of the frame \[s\], in the time of the scene.
    pub time: f64,
}

/// Most faults kept; older ones are dropped.
const MOST_FAULTS: usize = 64;

/// Actions that wait for the next frame, and reports that wait for the host to ask.
#[derive(Default)]
pub struct Host {
    /// Actions of users since the last frame.
    pub actions: Vec<Action>,
    /// Whether cloths have changed since the last frame although no action waits: they were saved or loaded.
    pub touched: bool,
    /// Whether free particles were put elsewhere since the last frame: transformed, loaded, or back where they began.
    pub put: bool,
    /// A warning about the device, to be reported.
    pub adapter: Option<Warning>,
    /// The same of cloth that crossed at the start.
    pub start: Option<Warning>,
    /// The same of steps that were too long.
    pub raised: Option<Warning>,
    /// Faults contained since anybody asked.
    pub faults: Vec<Fault>,
}

impl Host {
    /// Whether an action that waits may change a cloth.
    pub fn awaits(&self, cloth: usize) -> bool {
        self.actions.iter().any(|action| action.cloth().is_none_or(|c| c == cloth))
    }

    /// Whether the next frame has anything to do even without a step.
    pub fn is_pending(&self) -> bool {
        self.touched || !self.actions.is_empty()
    }

    /// Puts particles in their places, with those of the last call where that was for the same cloth.
    pub fn place(&mut self, cloth: usize, more: impl IntoIterator<Item = Placed>) {
        if let Some(Action::Place { cloth: last, rows }) = self.actions.last_mut()
            && *last == cloth
        {
            rows.extend(more);
            return;
        }
        let rows: Vec<_> = more.into_iter().collect();
        if !rows.is_empty() {
            self.actions.push(Action::Place { cloth, rows });
        }
    }

    /// Takes a cloth out of what waits, as it gets another state.
    pub fn forget(&mut self, cloth: usize) {
        self.actions.retain(|action| action.cloth() != Some(cloth));
        for action in &mut self.actions {
            if let Action::Cut { spared, .. } = action {
                spared.push(cloth);
            }
        }
    }

    /// Takes in that a cloth comes: what waits is not for it.
    pub fn join(&mut self, index: usize) {
        for action in &mut self.actions {
            if let Action::Cut { spared, .. } = action {
                spared.push(index);
            }
        }
    }

    /// Takes a cloth out of what waits, as it leaves; the indices of those after it fall.
    pub fn leave(&mut self, index: usize) {
        self.actions.retain_mut(|action| match action {
            Action::Cut { spared, .. } => {
                spared.retain_mut(|cloth| follow(cloth, index));
                true
            }
            Action::Transform { cloth, .. }
            | Action::Place { cloth, .. }
            | Action::Aim { cloth }
            | Action::Skin { cloth, .. }
            | Action::Inertia { cloth, .. }
            | Action::Load { cloth, .. } => follow(cloth, index),
        });
        self.faults.retain_mut(|fault| follow(&mut fault.cloth, index));
    }

    /// Keeps a fault until the host asks.
    pub fn report(&mut self, fault: Fault) {
        self.faults.push(fault);
        let excess = self.faults.len().saturating_sub(MOST_FAULTS);
        self.faults.drain(..excess);
    }
}

impl World {
    /// Does on the CPU what is to be done, and says whether cloths have changed since the last frame.
    pub fn act<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads) -> bool {
        let actions = std::mem::take(&mut self.host.actions);
        for action in &actions {
            match action {
                Action::Cut { corners, spared } => {
                    let cut = bodies.iter_mut().enumerate().filter(|(cloth, _)| !spared.contains(cloth));
                    cut.for_each(|(_, body)| body.cut(threads, corners.map(cast)));
                }
                Action::Transform { cloth, chosen, matrix } => bodies[*cloth].transform(chosen, matrix.map(cast)),
                Action::Place { cloth, rows } => bodies[*cloth].place(rows),
                Action::Aim { cloth } => {
                    let (run, of) = (&self.runs[*cloth], &self.scene.cloths[*cloth]);
                    bodies[*cloth].aim(&run.targets(of), &run.spheres(of));
                }
                Action::Skin { cloth, to, rate, .. } => {
                    let Some(joints) = &self.runs[*cloth].joints else { continue };
                    bodies[*cloth].lead(&self.scene.cloths[*cloth], &joints.joined, to, T::of(f64::from(*rate)));
                }
                Action::Inertia { cloth, numbers } => bodies[*cloth].push(&numbers.map(cast)),
                // The CPU takes states at once.
                Action::Load { .. } => {}
            }
        }
        self.host.touched |= !actions.is_empty();
        self.host.touched
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(particle: u32) -> Placed {
        Placed { particle, at: Some([0.0; 3]), inverse_mass: None }
    }

    #[test]
    fn calls_for_one_cloth_are_one_action_and_its_state_ends_them() {
        let mut host = Host::default();
        (0..1402).for_each(|k| host.place(0, [row(k)]));
        host.place(1, [row(0)]);
        host.place(0, []);
        assert_eq!(host.actions.len(), 2, "an upload each");
        host.actions.push(Action::Cut { corners: [[0.0; 3]; 3], spared: Vec::new() });
        host.place(0, [row(3)]);
        host.forget(0);
        assert!(
            matches!(&host.actions[..], [Action::Place { cloth: 1, .. }, Action::Cut { spared, .. }] if spared == &[0])
        );
        assert!(host.is_pending());
    }

    #[test]
    fn what_waits_follows_cloths_that_come_and_go() {
        let mut host = Host::default();
        (0..4).for_each(|cloth| host.place(cloth, [row(cloth as u32)]));
        host.actions.push(Action::Cut { corners: [[0.0; 3]; 3], spared: vec![1, 3] });
        let fault = |cloth| Fault { cloth, particle: 0, particles: 1, time: 0.0 };
        (0..4).for_each(|cloth| host.report(fault(cloth)));
        host.join(4);
        host.leave(1);
        let places = host.actions[..3].iter().map(|a| match a {
            Action::Place { cloth, rows } => (*cloth, rows[0].particle),
            other => panic!("{other:?}"),
        });
        assert_eq!(places.collect::<Vec<_>>(), [(0, 0), (1, 2), (2, 3)]);
        assert!(matches!(&host.actions[3..], [Action::Cut { spared, .. }] if spared == &[2, 3]));
        assert_eq!(host.faults, [0, 1, 2].map(fault));
    }
}
