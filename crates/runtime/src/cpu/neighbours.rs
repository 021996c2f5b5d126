//! The triangles around a particle. Twin of shaders/part/neighbours.wgsl.

use crate::number::real::{Real, V3, xyz};

/// Columns of the grid that is looked at, its particles, and which of its triangles are cut away: none if empty.
#[derive(Clone, Copy)]
pub struct View<'a, T> {
    pub now: &'a [[T; 4]],
    pub width: usize,
    pub holes: &'a [u32],
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
    /// the front. A quad of four particles is split along (i, j)-(i+1, j+1); one of three is a triangle. Triangles that
    /// are cut away are left out.
    // As a guard, a triangle that is cut away would go on to the arm of two.
    #[allow(clippy::collapsible_match)]
    #[inline]
    pub fn triangles(&self, i: usize, j: usize, mut triangle: impl FnMut(usize, usize)) {
        let around = AROUND.map(|step| self.neighbour(i, j, step));
        for quadrant in 0..4 {
            let (p, q, r) = (around[2 * quadrant], around[2 * quadrant + 1], around[(2 * quadrant + 2) % 8]);
            let full = p.is_some() && q.is_some() && r.is_some();
            let bits = self.removed_around(i, j, quadrant);
            let there = |of: usize| bits >> u32::from(full && quadrant == of) & 1 == 0;
            match (p, q, r) {
                (Some(p), _, Some(r)) if quadrant % 2 == 1 || q.is_none() => {
                    if there(1) {
                        triangle(p, r);
                    }
                }
                (p, Some(q), r) => {
                    if let Some(p) = p.filter(|_| there(0)) {
                        triangle(p, q);
                    }
                    if let Some(r) = r.filter(|_| there(2)) {
                        triangle(q, r);
                    }
                }
                _ => {}
            }
        }
    }

    /// Triangles that are cut away of the quad in a quadrant of a particle.
    #[inline]
    fn removed_around(&self, i: usize, j: usize, quadrant: usize) -> u32 {
        if self.holes.is_empty() {
            return 0;
        }
        let (left, up) = (usize::from(quadrant == 1 || quadrant == 2), usize::from(quadrant > 1));
        // Outside of the grid only where there is no triangle.
        if i < left || j < up { 0 } else { self.removed((j - up) * self.width + i - left) }
    }

    /// Triangles that are cut away of the quad with its upper left particle at a texel.
    #[inline]
    pub fn removed(&self, k: usize) -> u32 {
        self.holes.get(k).copied().unwrap_or(0)
    }

    /// The triangles of a quad that are left and that are cut away, as shaders/part/sides.wgsl has them. There is none outside.
    #[inline]
    pub fn sides(&self, i: Option<usize>, j: Option<usize>) -> [u32; 2] {
        let (Some(i), Some(j)) = (i, j) else { return [0; 2] };
        let away = match (self.quad(i, j).0, self.removed(j * self.width + i)) {
            (0, _) => return [0; 2],
            (1, bits) if bits != 0 => 3,
            (_, bits) => bits,
        };
        [3 & !away, away]
    }

    /// Position of a particle.
    #[inline]
    pub fn at(&self, k: usize) -> V3<T> {
        xyz(self.now[k])
    }

    /// The triangles of the quad with its upper left particle at (i, j), as shaders/part/quad.wgsl has them.
    #[inline]
    pub fn quad(&self, i: usize, j: usize) -> (u32, [[usize; 3]; 2]) {
        let (k, w) = (j * self.width + i, self.width);
        if i + 1 >= w || k + w >= self.now.len() {
            return (0, [[0; 3]; 2]);
        }
        let at = [k, k + w, k + w + 1, k + 1];
        let there = at.map(|k| self.now[k][3] >= T::of(0.0));
        match there {
            [true, true, true, true] => (2, [[at[0], at[1], at[2]], [at[0], at[2], at[3]]]),
            [_, true, true, true] => (1, [[at[1], at[2], at[3]], [0; 3]]),
            [true, _, true, true] => (1, [[at[0], at[2], at[3]], [0; 3]]),
            [true, true, _, true] => (1, [[at[0], at[1], at[3]], [0; 3]]),
            [true, true, true, _] => (1, [[at[0], at[1], at[2]], [0; 3]]),
            _ => (0, [[0; 3]; 2]),
        }
    }
}
