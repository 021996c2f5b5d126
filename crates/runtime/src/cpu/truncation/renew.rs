//! Points that cannot go on as a search expects get a new reach, where they are few: a search for what they alone may meet.
//!
//! All that a search has found stays true of the others. A point that is renewed goes on from where it is, as it wants to now, or else stays
//! there, and has a box of its own again; the features that it belongs to are compared with all that their boxes meet. New half-spaces replace
//! those that it has. Those of other points stay: they leave less room, and do no harm.

use super::compare::{Compared, compare};
use super::planes::Points;
use super::surface::Patch;
use super::tiles::SIDE;
use super::{MAX_REACH, MIN_REACH, Truncation, flat};
use crate::number::real::{dot, scale, sub};

/// One in this many points may be renewed in a step; if there are more, a search takes no longer.
const FEW_SHARE: usize = 32;

impl Truncation {
    /// Whether a number of points is so small that they are renewed.
    pub(super) fn are_few(&self, count: usize) -> bool {
        count * FEW_SHARE <= self.last.len() + 8 * FEW_SHARE
    }

    /// Renews points: if they go on, those that fail, from where the step began, or else those that have used up their reach, from where they
    /// are in it.
    pub(super) fn renew(&mut self, goes_on: bool) {
        let points = std::mem::take(if goes_on { &mut self.failing } else { &mut self.short });
        let [least, most] = [MIN_REACH, MAX_REACH].map(|share| share * self.spacing);
        let gone = f64::from(self.age - 1);
        let left = f64::from(self.ahead) - gone;
        for k in points.iter().map(|k| *k as usize) {
            let step = sub(self.want[k], self.last[k]);
            let goes = goes_on && !self.stuck[k] && step.iter().all(|x| x.is_finite());
            self.drift[k] = if goes { step } else { [0.0; 3] };
            self.at[k] = sub(self.last[k], scale(self.drift[k], gone));
            let way = sub(step, self.pace[k]);
            self.reach[k] = (left * dot(way, way).sqrt()).clamp(least, most);
            self.fresh[k] = true;
            self.since[k] = self.age;
        }
        let mut cells: Vec<u32> = points.iter().flat_map(|k| self.surface.cells_of(*k as usize)).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        self.planes.forget(&self.fresh);
        self.bound_again(&cells);
        self.compare_again(&cells);
        points.iter().for_each(|k| self.fresh[*k as usize] = false);
        *(if goes_on { &mut self.failing } else { &mut self.short }) = points;
    }

    /// Makes the boxes of cells whose corners are renewed, and of all that depends on them.
    fn bound_again(&mut self, cells: &[u32]) {
        let tile = |cell: &u32| {
            let patch = self.surface.patch_of(*cell as usize);
            let [i, j] = patch.spot(*cell as usize);
            [patch.index, j / SIDE, i / SIDE]
        };
        let mut tiles: Vec<[usize; 3]> = cells.iter().map(tile).collect();
        tiles.sort_unstable();
        tiles.dedup();
        for [patch, j, i] in tiles {
            let patch = self.surface.patches[patch];
            // The blocks that have a corner of a cell of the tile, and all texels of these.
            let part = |at: usize, count: usize| (SIDE * at).saturating_sub(2)..(SIDE * at + SIDE + 3).min(count);
            self.find_even(&patch, part(i, patch.width), part(j, patch.height));
        }
        let changed = self.beside(cells, [2, 2]);
        for (patch, at) in &changed {
            self.bound_cell(patch, *at);
        }
        let mut rows: Vec<[usize; 3]> = changed.iter().map(|(patch, [i, j])| [patch.index, *j, *i]).collect();
        self.boxes.refit_above(&mut rows);
    }

    /// The texels from some columns and rows before some cells to some after them, each once.
    fn beside(&self, cells: &[u32], [before, after]: [usize; 2]) -> Vec<(Patch, [usize; 2])> {
        let mut found = Vec::with_capacity(cells.len() * (before + after + 1).pow(2));
        for cell in cells.iter().map(|cell| *cell as usize) {
            let patch = self.surface.patch_of(cell);
            let [i, j] = patch.spot(cell);
            let rows = j.saturating_sub(before)..(j + after + 1).min(patch.height);
            let columns = i.saturating_sub(before)..(i + after + 1).min(patch.width);
            found.extend(rows.flat_map(|j| columns.clone().map(move |i| (patch.first + j * patch.width + i) as u32)));
        }
        found.sort_unstable();
        found.dedup();
        let spot = |cell: u32| {
            let patch = self.surface.patch_of(cell as usize);
            (patch, patch.spot(cell as usize))
        };
        found.into_iter().map(spot).collect()
    }

    /// Compares the features of points that are renewed with all that they may meet.
    fn compare_again(&mut self, cells: &[u32]) {
        cells.iter().for_each(|cell| self.around[*cell as usize] = true);
        let Truncation { surface, boxes, planes, last, want, free, loose, drift, drifts, reach, even, .. } = self;
        let (fresh, around) = (&self.fresh, &self.around);
        let gone = f64::from(self.age - 1);
        let ahead = f64::from(self.ahead) - gone;
        let points = Points { at: last, want, free, loose, drift, reach, fresh: Some(fresh), floor: self.floor, ahead };
        for cell in cells.iter().map(|cell| *cell as usize) {
            boxes.pairs_of(&surface.patch_of(cell), cell, |pair| {
                let [a, b] = pair.cells;
                // A pair of two such cells is found twice.
                if (around[b] && b < a) || flat::is_apart(surface, even, &pair) {
                    return;
                }
                // Points that are not renewed may be off where they are expected by all of their reach.
                let near = points.floor + drifts[a].near(&drifts[b], ahead) + drifts[a].reach + drifts[b].reach;
                if let Some(axis) = drifts[a].way(&drifts[b], gone, near) {
                    compare(surface, planes, &points, &Compared { cells: [a, b], near, axis });
                }
            });
        }
        planes.arrange(last.len());
        cells.iter().for_each(|cell| self.around[*cell as usize] = false);
    }
}
