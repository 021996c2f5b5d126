//! The particles of all sheets in tiles of 4 x 4: the lowest level of boxes that has more than one particle.
//!
//! A tile has one vector of numbers per coordinate. Its order follows the sheets: per row two even columns, then two odd ones.

use crate::cloth::{Cloth, Kin};
use crate::cpu::sheet::Sheet;
use crate::memory::Tally;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, V3};

/// Columns, and rows, of a tile.
pub const SIDE: usize = 4;
/// Particles of a tile.
pub const LANES_OF_TILE: usize = SIDE * SIDE;

/// The tiles of one sheet.
#[derive(Clone, Debug)]
pub struct TileGrid {
    /// The first of them.
    pub first: usize,
    pub columns: usize,
    pub rows: usize,
}

/// Where a tile lies.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub sheet: u32,
    /// Its column and row among tiles.
    pub column: u32,
    pub row: u32,
}

/// All tiles of a cloth. Lists have a place for each of [`LANES_OF_TILE`] particles of each tile.
pub struct Tiles<T: Real> {
    pub grids: Vec<TileGrid>,
    pub spots: Vec<Spot>,
    /// Positions, and previous ones, as they were loaded last.
    pub now: [Aligned<T>; 3],
    pub was: [Aligned<T>; 3],
    /// Inverse masses; 0 for texels without a particle.
    pub w: Aligned<T>,
    /// Positions at rest.
    pub rest: [Aligned<T>; 3],
    /// The particle of each place, `u32::MAX` for none.
    pub texel: Vec<u32>,
    /// 0 for particles that others meet, else more than any distance squared.
    pub out: Aligned<T>,
}

/// The place of a column and a row in a tile.
#[inline(always)]
pub fn lane(i: usize, j: usize) -> usize {
    (j % SIDE) * SIDE + (i % 2) * 2 + (i / 2) % 2
}

/// The column and the row of a place in a tile.
#[inline(always)]
pub fn corner(lane: usize) -> [usize; 2] {
    [(lane / 2) % 2 + 2 * (lane % 2), lane / SIDE]
}

impl<T: Real> Tiles<T> {
    /// Those of a cloth; [`Tiles::load`] fills in where particles are.
    pub fn new(cloth: &Cloth, sheets: &[Sheet<T>]) -> Self {
        let (mut grids, mut spots) = (Vec::new(), Vec::new());
        for (g, sheet) in sheets.iter().enumerate() {
            let (columns, rows) = (sheet.width.div_ceil(SIDE), sheet.height.div_ceil(SIDE));
            grids.push(TileGrid { first: spots.len(), columns, rows });
            let each = (0..rows).flat_map(|row| (0..columns).map(move |column| (column as u32, row as u32)));
            spots.extend(each.map(|(column, row)| Spot { sheet: g as u32, column, row }));
        }
        let places = spots.len() * LANES_OF_TILE;
        let mut rest: [Aligned<T>; 3] = std::array::from_fn(|_| Aligned::zeros(places));
        let mut texel = vec![u32::MAX; places];
        for ((sheet, grid), tiles) in sheets.iter().zip(cloth.grids()).zip(&grids) {
            for k in 0..grid.texels() {
                let (i, j, n) = (k % sheet.width, k / sheet.width, grid.first as usize + k);
                let place = (tiles.first + j / SIDE * tiles.columns + i / SIDE) * LANES_OF_TILE + lane(i, j);
                if cloth.particles()[n].exists() {
                    texel[place] = n as u32;
                    (0..3).for_each(|c| rest[c][place] = T::of(cloth.positions()[n][c].into()));
                }
            }
        }
        let list = || std::array::from_fn(|_| Aligned::zeros(places));
        let (now, was, w, out) = (list(), list(), Aligned::zeros(places), Aligned::zeros(places));
        Tiles { grids, spots, now, was, w, rest, texel, out }
    }

    /// [`Tiles::out`]: gaps, and all duplicates of a point but the first.
    pub fn outsiders(&self, kin: &Kin) -> Aligned<T> {
        let mut out = Aligned::zeros(self.texel.len());
        for (out, k) in out.iter_mut().zip(&self.texel) {
            let meets = kin.first.get(*k as usize) == Some(k);
            *out = T::of(if meets { 0.0 } else { 1e30 });
        }
        out
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.spots.len()
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        let lists = self.now.iter().chain(&self.was).chain(&self.rest).chain([&self.w, &self.out]);
        lists.for_each(|list| tally.state(list));
        tally.state(&self.texel);
    }

    /// Positions and inverse masses of all particles.
    pub fn load_all(&mut self, sheets: &[Sheet<T>]) {
        for tile in 0..self.count() {
            self.load(sheets, tile);
            let spot = self.spots[tile];
            let sheet = &sheets[spot.sheet as usize];
            let w = &mut self.w[tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE];
            for (w, row) in w.chunks_exact_mut(SIDE).zip(rows(sheet, spot)) {
                let at = row * 2 * sheet.half + 2 * spot.column as usize;
                w[..2].copy_from_slice(&sheet.w[at..at + 2]);
                w[2..].copy_from_slice(&sheet.w[at + sheet.half..at + sheet.half + 2]);
            }
        }
    }

    /// Positions of the particles of a tile, and previous ones.
    #[inline]
    pub fn load(&mut self, sheets: &[Sheet<T>], tile: usize) {
        let spot = self.spots[tile];
        let sheet = &sheets[spot.sheet as usize];
        let places = tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE;
        for (from, to) in [(&sheet.now, &mut self.now), (&sheet.before, &mut self.was)] {
            for (c, to) in to.iter_mut().enumerate() {
                for (to, row) in to[places.clone()].chunks_exact_mut(SIDE).zip(rows(sheet, spot)) {
                    let at = row * sheet.row() + 2 * c * sheet.half + 2 * spot.column as usize;
                    to[..2].copy_from_slice(&from[at..at + 2]);
                    to[2..].copy_from_slice(&from[at + sheet.half..at + sheet.half + 2]);
                }
            }
        }
    }

    /// A position.
    #[inline(always)]
    pub fn at(list: &[Aligned<T>; 3], place: usize) -> V3<T> {
        [list[0][place], list[1][place], list[2][place]]
    }
}

/// The rows of a sheet that a tile has.
#[inline(always)]
pub fn rows<T: Real>(sheet: &Sheet<T>, spot: Spot) -> std::ops::Range<usize> {
    let first = SIDE * spot.row as usize;
    first..(first + SIDE).min(sheet.height)
}
