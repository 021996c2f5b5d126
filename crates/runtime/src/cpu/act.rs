//! What users do to a cloth on the CPU.

use super::body::{Body, view};
use super::real::{Real, V3};
use super::rows::Threads;
use super::{cut, cut_springs, transform};

impl<T: Real> Body<T> {
    /// Cuts by a triangle; room must have been made by [`Body::open`].
    pub fn cut(&mut self, threads: &Threads, corners: [V3<T>; 3]) {
        (self.edited, self.cut) = (true, true);
        for g in &self.grids {
            cut::run(threads, view(&self.now, &[], g), corners, &mut self.holes[g.range()]);
            if !self.image.is_empty() {
                cut_springs::run(threads, view(&self.now, &self.holes, g), &mut self.image[g.range()]);
            }
        }
    }

    /// Moves particles by the matrix with these columns.
    pub fn transform(&mut self, chosen: &[u32], matrix: [[T; 4]; 4]) {
        self.edited = true;
        transform::run(&mut self.now, &mut self.before, chosen, matrix);
    }
}
