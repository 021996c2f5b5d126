//! What the host asks for, and what it is told.

use super::World;
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::limits::Warning;
use crate::number::real::{Real, cast};

/// What is to be done before the next step, in the order of the calls.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// A cut by the triangle with these corners.
    Cut([[f32; 3]; 3]),
    /// Particles of a cloth, all duplicates among them, are moved by the matrix with these columns.
    Transform { cloth: usize, chosen: Vec<u32>, matrix: [[f32; 4]; 4] },
}

/// A frame that was taken back: particles were NaN, or more than 1e8 m away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Index of the cloth.
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

/// What waits for the next frame, or for the host to ask.
#[derive(Default)]
pub struct Host {
    /// What users have done since the last frame.
    pub actions: Vec<Action>,
    /// What was changed because the solver cannot do it.
    pub warnings: Vec<Warning>,
    /// The same of steps that were too long.
    pub raised: Option<Warning>,
    /// What has been contained since anybody asked.
    pub faults: Vec<Fault>,
}

impl Host {
    /// Keeps a fault until the host asks.
    pub fn report(&mut self, fault: Fault) {
        self.faults.push(fault);
        let excess = self.faults.len().saturating_sub(MOST_FAULTS);
        self.faults.drain(..excess);
    }
}

impl World {
    /// Does on the CPU what is to be done, and says whether that was anything.
    pub fn act<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads) -> bool {
        let actions = std::mem::take(&mut self.host.actions);
        for action in &actions {
            match action {
                Action::Cut(corners) => bodies.iter_mut().for_each(|b| b.cut(threads, corners.map(cast))),
                Action::Transform { cloth, chosen, matrix } => bodies[*cloth].transform(chosen, matrix.map(cast)),
            }
        }
        !actions.is_empty()
    }
}
