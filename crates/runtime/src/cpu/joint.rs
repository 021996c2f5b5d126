//! Twins of the shaders by which no triangle of cloth crosses another one on the GPU; tests compare them. The CPU backend has a rule of its own
//! ([`super::truncation`]).
//!
//! All cloths lie one after the other ([`crate::levels::joint`]). A step goes in rounds: [`paths`] finds how far each particle wants to go and boxes around
//! all places where it may be then, and [`truncate`] puts it as near to there as half-spaces let it ([`planes`]), which keep it apart from all features
//! whose boxes meet its own. No list lasts from step to step. Cloth that is even ([`even`]) meets no part of itself nearby.

pub mod even;
pub mod faces;
pub mod gather;
pub mod hold_back;
pub mod paths;
pub mod planes;
#[cfg(test)]
pub mod tests;
pub mod truncate;

use crate::number::real::{Real, V3, add, scale, with_w, xyz};

/// Marks a texel without a particle.
pub const NOBODY: u32 = u32::MAX;
/// Particles of a tile.
pub const TILE: usize = 16;

/// The lists of all cloths as shaders have them.
#[derive(Clone, Debug)]
pub struct Lists<T: Real> {
    /// As [`crate::levels::joint::Joint`] has it.
    pub table: Vec<u32>,
    /// Where the step takes particles \[m\]; w is 1 for those that may be held back, 0 for pins and cloth that is asleep, -1 for none.
    pub goals: Vec<[T; 4]>,
    /// Where they may go.
    pub places: Vec<[T; 4]>,
    /// Where they are as a round begins; w is the radius of the ball around the middle of its way in which each stays \[m\].
    pub bases: Vec<[T; 4]>,
    /// How far they want to go in it; w as in goals.
    pub ways: Vec<[T; 4]>,
    /// The features of each cell, by its upper left texel ([`faces`]).
    pub faces: Vec<u32>,
    /// Two vectors per box: those of the table, then one per texel of each tile. Then four per tile, how its edges spread.
    pub boxes: Vec<[T; 4]>,
}

/// A grid of the table.
#[derive(Clone, Copy, Debug)]
pub struct Patch<T> {
    pub number: usize,
    /// Distance of neighbours of its cloth \[m\], 0 for cloth that is not safe.
    pub spacing: T,
    pub first: usize,
    pub width: usize,
    pub height: usize,
    /// Its first tile.
    pub tile: usize,
}

impl<T: Real> Patch<T> {
    /// The particle of a texel.
    pub fn at(&self, [i, j]: [usize; 2]) -> usize {
        self.first + j * self.width + i
    }

    /// The place of a texel among those of tiles.
    pub fn place(&self, [i, j]: [usize; 2]) -> usize {
        (self.tile + j / 4 * self.width.div_ceil(4) + i / 4) * TILE + j % 4 * 4 + i % 4
    }

    /// Particles at the corners of a cell, around it from the upper left one downwards.
    pub fn corners(&self, [i, j]: [usize; 2]) -> [usize; 4] {
        let k = self.at([i, j]);
        [k, k + self.width, k + self.width + 1, k + 1]
    }
}

/// A particle and the ball in which it stays in a round.
#[derive(Clone, Copy, Debug)]
pub struct Ball<T> {
    pub center: V3<T>,
    pub radius: T,
}

impl<T: Real> Lists<T> {
    /// Those of a table for a number of particles, all at 0.
    pub fn new(table: Vec<u32>, particles: usize) -> Self {
        let [tiles, boxes] = [4, 8].map(|n| table[n] as usize);
        let none = vec![[T::of(0.0); 4]; particles];
        Lists {
            table,
            goals: none.clone(),
            places: none.clone(),
            bases: none.clone(),
            ways: none,
            faces: vec![0; particles],
            boxes: vec![[T::of(0.0); 4]; 2 * (boxes + TILE * tiles) + 4 * tiles],
        }
    }

    pub fn grids(&self) -> usize {
        self.table[0] as usize
    }

    pub fn tiles(&self) -> usize {
        self.table[4] as usize
    }

    pub fn patch(&self, g: usize) -> Patch<T> {
        let row = &self.table[self.table[7] as usize + 8 * g..][..8];
        let spacing = T::of(f64::from(f32::from_bits(row[3])));
        let [first, width, height, tile] = [4, 5, 6, 7].map(|n| row[n] as usize);
        Patch { number: g, spacing, first, width, height, tile }
    }

    /// The grid of a tile, and its first texel.
    pub fn spot(&self, tile: usize) -> (Patch<T>, [usize; 2]) {
        let at = self.table[6] as usize + 2 * tile;
        let [g, corner] = [self.table[at], self.table[at + 1]];
        (self.patch(g as usize), [4 * (corner & 0xffff) as usize, 4 * (corner >> 16) as usize])
    }

    /// The first duplicate of a particle, [`NOBODY`] for none.
    pub fn point(&self, k: usize) -> u32 {
        self.table[self.table[3] as usize + k]
    }

    /// The next duplicate of a particle, itself if there is no other.
    pub fn mate(&self, k: usize) -> usize {
        self.table[self.table[5] as usize + k] as usize
    }

    /// Where the box of a texel's cell lies.
    pub fn cell(&self, place: usize) -> usize {
        2 * (self.table[8] as usize + place)
    }

    /// Where the spread of a tile lies.
    pub fn spread(&self, tile: usize) -> usize {
        2 * (self.table[8] as usize + TILE * self.tiles()) + 4 * tile
    }

    /// Makes all boxes above those of tiles, as shaders/tree.wgsl does.
    pub fn refit(&mut self) {
        for g in 0..self.grids() {
            let at = self.table[2] as usize + 2 * g;
            let [rows, count] = [self.table[at] as usize, self.table[at + 1] as usize];
            for level in 1..count {
                let row = |n: usize| [0, 1, 2].map(|c| self.table[rows + 3 * n + c] as usize);
                let ([below, columns, lines], [first, wide, high]) = (row(level - 1), row(level));
                for n in 0..wide * high {
                    let far = T::of(f64::from(f32::MAX));
                    let mut node = [[far; 3], [-far; 3]];
                    for c in 0..4 {
                        let [i, j] = [2 * (n % wide) + c % 2, 2 * (n / wide) + c / 2];
                        if i < columns && j < lines {
                            let at = 2 * (below + j * columns + i);
                            let (low, high) = (self.boxes[at], self.boxes[at + 1]);
                            let lower = [0, 1, 2].map(|n| node[0][n].min(low[n]));
                            node = [lower, [0, 1, 2].map(|n| node[1][n].max(high[n]))];
                        }
                    }
                    let at = 2 * (first + n);
                    (self.boxes[at], self.boxes[at + 1]) = (with_w(node[0], T::of(0.0)), with_w(node[1], T::of(0.0)));
                }
            }
        }
    }

    /// The ball in which a particle stays in the round.
    pub fn ball(&self, k: usize) -> Ball<T> {
        Ball { center: add(xyz(self.bases[k]), scale(xyz(self.ways[k]), T::of(0.5))), radius: self.bases[k][3] }
    }
}
