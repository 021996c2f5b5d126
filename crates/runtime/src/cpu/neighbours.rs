//! The triangles around a particle. Twin of shaders/part/neighbours.wgsl.

use super::real::{Real, V3, xyz};

/// Columns and rows of the grid that is looked at, and its particles.
#[derive(Clone, Copy)]
pub struct View<'a, T> {
    pub now: &'a [[T; 4]],
    pub width: usize,
}

/// Steps to the eight neighbours in cyclic order from the right by way of down.
const AROUND: [(isize, isize); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

impl<T: Real> View<'_, T> {
    /// Index of the neighbour if it is a particle.
    fn neighbour(&self, i: usize, j: usize, step: (isize, isize)) -> Option<usize> {
        let (i, j) = (i.checked_add_signed(step.0)?, j.checked_add_signed(step.1)?);
        let k = j * self.width + i;
        (i < self.width && k < self.now.len() && self.now[k][3] >= T::of(0.0)).then_some(k)
    }

    /// Calls `triangle` with the other two corners of every triangle of the particle (i, j), counter-clockwise seen from
    /// the front. A quad of four particles is split along (i, j)-(i+1, j+1); one of three is a triangle.
    #[inline]
    pub fn triangles(&self, i: usize, j: usize, mut triangle: impl FnMut(usize, usize)) {
        let around = AROUND.map(|step| self.neighbour(i, j, step));
        for quadrant in 0..4 {
            let (p, q, r) = (around[2 * quadrant], around[2 * quadrant + 1], around[(2 * quadrant + 2) % 8]);
            match (p, q, r) {
                (Some(p), _, Some(r)) if quadrant % 2 == 1 || q.is_none() => triangle(p, r),
                (p, Some(q), r) => {
                    if let Some(p) = p {
                        triangle(p, q);
                    }
                    if let Some(r) = r {
                        triangle(q, r);
                    }
                }
                _ => {}
            }
        }
    }

    /// Position of a particle.
    #[inline]
    pub fn at(&self, k: usize) -> V3<T> {
        xyz(self.now[k])
    }
}
