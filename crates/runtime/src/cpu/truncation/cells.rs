//! The boxes of cells on their ways, and where cloth is even.

use std::ops::Range;

use super::Truncation;
use super::boxes::Bound;
use super::drift::{Drift, Way, around};
use super::flat::Part;
use super::spread::{self, Spread};
use super::surface::Patch;
use crate::number::real::{add, scale};

impl Truncation {
    /// Makes the boxes of all cells, and finds where cloth is even.
    pub(super) fn bound(&mut self) {
        self.drifts.resize(self.surface.corners.len(), Drift::default());
        self.boxes.floor = self.floor as f32;
        for n in 0..self.surface.patches.len() {
            let patch = self.surface.patches[n];
            self.find_even(&patch, 0..patch.width, 0..patch.height);
            for j in 0..patch.height {
                (0..patch.width).for_each(|i| self.bound_cell(&patch, [i, j]));
            }
        }
        self.boxes.refit();
    }

    /// Finds the even blocks around the inner texels of a part of a patch.
    pub(super) fn find_even(&mut self, patch: &Patch, columns: Range<usize>, rows: Range<usize>) {
        let mut ways = std::mem::take(&mut self.ways);
        let texels = rows.clone().flat_map(|j| columns.clone().map(move |i| patch.first + j * patch.width + i));
        ways.fill(texels.map(|cell| self.way(cell)));
        let part = Part { patch: *patch, columns, rows };
        ways.find_even(&part, self.floor as f32, &mut self.even);
        self.ways = ways;
    }

    /// The way of a texel's point from now on, NaN for gaps.
    #[inline]
    fn way(&self, cell: usize) -> Way {
        let point = self.surface.corners[cell] as usize;
        // Comparisons with NaN are false: nothing is even beside a gap.
        let gap = Way { from: [f64::NAN; 3], to: [f64::NAN; 3], reach: 0.0 };
        if point < self.at.len() { self.way_of(point) } else { gap }
    }

    /// The way of a point from now on.
    #[inline]
    fn way_of(&self, point: usize) -> Way {
        let (at, drift) = (self.at[point], self.drift[point]);
        let (begin, end) = (f64::from(self.age - 1), f64::from(self.ahead));
        Way { from: add(at, scale(drift, begin)), to: add(at, scale(drift, end)), reach: self.reach[point] }
    }

    /// Makes the box of a cell, once it is known where cloth is even.
    pub(super) fn bound_cell(&mut self, patch: &Patch, [i, j]: [usize; 2]) {
        let cell = patch.first + j * patch.width + i;
        // A cell without a triangle meets nothing.
        (self.boxes.bounds[cell], self.boxes.spreads[cell]) = (Bound::NONE, Spread::NONE);
        if i + 1 == patch.width || j + 1 == patch.height {
            return;
        }
        let corners = [cell, cell + 1, cell + patch.width, cell + patch.width + 1].map(|cell| self.way(cell));
        let triangles = self.surface.triangles(cell).len();
        let whole = triangles == 2 && spread::is_even(patch, &self.even, i, j);
        // A way along edges must not cross a gap.
        self.boxes.spreads[cell] = if whole { Spread::of(corners) } else { Spread::WIDE };
        if triangles == 0 {
            return;
        }
        let (mut there, mut count) = (corners, corners.len());
        if triangles < 2 {
            count = 0;
            for way in corners.iter().filter(|way| way.from[0].is_finite()) {
                there[count] = *way;
                count += 1;
            }
        }
        self.boxes.bounds[cell] = around(&there[..count], self.floor);
        self.drifts[cell] = Drift::of(&there[..count], [f64::from(self.age - 1), f64::from(self.ahead)]);
    }
}
