//! Actions of users on a cloth on the CPU.

use std::sync::Arc;

use super::body::{Body, view};
use super::place::{self, Placed};
use super::route::far;
use super::rows::Threads;
use super::{cut, cut_springs, cut_tethers, inertia, transform};
use crate::number::real::{Real, V3};

impl<T: Real> Body<T> {
    /// Cuts by a triangle; room must have been made by [`Body::open`].
    pub fn cut(&mut self, threads: &Threads, corners: [V3<T>; 3]) {
        (self.edited, self.cut) = (true, true);
        let old = self.held.as_ref().map(|_| self.image.clone());
        for g in &self.grids {
            cut::run(threads, view(&self.now, &[], g), corners, &mut self.holes[g.range()]);
            if !self.image.is_empty() {
                cut_springs::run(
                    threads,
                    view(&self.now, &self.holes, g),
                    &mut Arc::make_mut(&mut self.image)[g.range()],
                );
            }
        }
        if let (Some(held), Some(old)) = (&mut self.held, old) {
            let changed = cut_tethers::run(held, &old, &self.image);
            if let Some(fabric) = self.fabric.as_mut().filter(|_| changed) {
                fabric.hold(held.slots, |t| (held.most[t] < far()).then_some((held.anchors[t], held.most[t])));
            }
        }
    }

    /// Puts particles in their places; previous positions too, so that they are at rest.
    pub fn place(&mut self, rows: &[Placed]) {
        self.edited = true;
        self.forget_surface();
        place::run(&mut self.now, &mut self.before, rows);
    }

    /// The frame of reference has moved: the numbers of an impulse.
    pub fn push(&mut self, numbers: &[[T; 4]; 7]) {
        self.edited = true;
        inertia::run(&self.now, &mut self.before, numbers);
    }

    /// Moves particles by the matrix with these columns.
    pub fn transform(&mut self, chosen: &[u32], matrix: [[T; 4]; 4]) {
        self.edited = true;
        self.forget_surface();
        transform::run(&mut self.now, &mut self.before, chosen, matrix);
    }
}
