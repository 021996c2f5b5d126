//! What users do to cloths, queued for the next frame.

use super::World;
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::number::real::{Real, cast};

/// What is to be done before the next step, in the order of the calls.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// A cut by the triangle with these corners.
    Cut([[f32; 3]; 3]),
    /// Particles of a cloth, all duplicates among them, are moved by the matrix with these columns.
    Transform { cloth: usize, chosen: Vec<u32>, matrix: [[f32; 4]; 4] },
}

impl World {
    /// Does on the CPU what is to be done, and says whether that was anything.
    pub fn act<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads) -> bool {
        let actions = std::mem::take(&mut self.actions);
        for action in &actions {
            match action {
                Action::Cut(corners) => bodies.iter_mut().for_each(|b| b.cut(threads, corners.map(cast))),
                Action::Transform { cloth, chosen, matrix } => bodies[*cloth].transform(chosen, matrix.map(cast)),
            }
        }
        !actions.is_empty()
    }
}
