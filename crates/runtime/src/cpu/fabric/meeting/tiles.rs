//! The particles of all sheets in tiles of 4 x 4: the lowest level of boxes that has more than one particle.
//!
//! A tile has one vector of numbers per coordinate. Its order follows the sheets: per row two even columns, then two odd ones.

use std::sync::Arc;

use crate::cloth::{Cloth, Kin, Rest, SKIPPED_CELLS};
use crate::cpu::sheet::Sheet;
use crate::memory::Tally;
use crate::number::aligned::Aligned;
use crate::number::lanes::{Machine, Work, lane_rows, widest};
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

/// The particles of a tile, as they were loaded last.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Block<T> {
    /// Positions, and previous ones.
    pub now: [[T; LANES_OF_TILE]; 3],
    pub was: [[T; LANES_OF_TILE]; 3],
    /// Inverse masses; 0 for texels without a particle.
    pub w: [T; LANES_OF_TILE],
}

/// All tiles of a cloth. Lists have a place for each of [`LANES_OF_TILE`] particles of each tile.
pub struct Tiles<T: Real> {
    pub grids: Vec<TileGrid>,
    pub spots: Vec<Spot>,
    /// One a tile.
    pub blocks: Vec<Block<T>>,
    /// Positions and previous ones once more, a row each, as partners are read one by one: x, y, z and a zero. Those of a tile are in the
    /// order of [`Tiles::lane_rows`].
    pub rows: [Vec<[T; 4]>; 2],
    /// For each lane of a tile its row there.
    pub lane_rows: [usize; LANES_OF_TILE],
    /// Positions at rest.
    pub rest: [Aligned<T>; 3],
    /// For each tile half the square of its longest spring \[m^2\]: triangles there cross only if particles are nearer.
    pub crossing2: Arc<Vec<T>>,
    /// Whether the particle of a place is near a line along which cloths cross at rest; empty if there is none.
    pub crossed: Vec<bool>,
    /// The particle of each place, `u32::MAX` for none.
    pub texel: Vec<u32>,
    /// 1 for particles, 0 for places without one.
    pub there: Aligned<T>,
    /// 0 for particles that others meet, else [`FAR`].
    pub out: Aligned<T>,
    /// For each direction to a neighbouring tile, or to itself, and each particle, those of the other: [`FAR`] where they are close.
    close: Vec<[[T; LANES_OF_TILE]; LANES_OF_TILE]>,
}

/// More than any distance squared.
const FAR: f64 = 1e30;

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
    pub fn new(cloth: &Cloth, sheets: &[Sheet<T>], kin: &Kin) -> Self {
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
        let mut there = Aligned::zeros(places);
        for ((sheet, grid), tiles) in sheets.iter().zip(cloth.grids()).zip(&grids) {
            for k in 0..grid.texels() {
                let (i, j, n) = (k % sheet.width, k / sheet.width, grid.first as usize + k);
                let place = (tiles.first + j / SIDE * tiles.columns + i / SIDE) * LANES_OF_TILE + lane(i, j);
                if cloth.particles()[n].exists() {
                    (texel[place], there[place]) = (n as u32, T::of(1.0));
                    (0..3).for_each(|c| rest[c][place] = T::of(cloth.positions()[n][c].into()));
                }
            }
        }
        let zeros = [T::of(0.0); LANES_OF_TILE];
        let blocks = vec![Block { now: [zeros; 3], was: [zeros; 3], w: zeros }; spots.len()];
        // Gaps, and all duplicates of a point but the first.
        let mut out = Aligned::zeros(places);
        for (out, k) in out.iter_mut().zip(&texel) {
            let meets = kin.first.get(*k as usize) == Some(k);
            *out = T::of(if meets { 0.0 } else { FAR });
        }
        let crossing2 = Arc::new(crossing2(cloth, &texel));
        let rows = [0, 1].map(|_| vec![[T::of(0.0); 4]; places]);
        let lane_rows = lane_rows::<T>();
        Tiles {
            grids,
            spots,
            blocks,
            rows,
            lane_rows,
            rest,
            crossing2,
            crossed: Vec::new(),
            texel,
            there,
            out,
            close: close(),
        }
    }

    /// For each particle of a tile those of another that are within [`SKIPPED_CELLS`] cells; none where no two are.
    #[inline(always)]
    pub fn close(&self, tile: usize, other: usize) -> Option<&[[T; LANES_OF_TILE]; LANES_OF_TILE]> {
        let (a, b) = (self.spots[tile], self.spots[other]);
        let [right, down] = [(b.column + 1).wrapping_sub(a.column), (b.row + 1).wrapping_sub(a.row)];
        (a.sheet == b.sheet && right < 3 && down < 3).then(|| &self.close[(3 * down + right) as usize])
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.spots.len()
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.blocks);
        self.rows.iter().for_each(|list| tally.state(list));
        self.rest.iter().chain([&self.there, &self.out]).for_each(|list| tally.state(list));
        tally.state(&self.texel);
        tally.state(&self.crossing2);
    }

    /// Positions and inverse masses of all particles; whether an inverse mass has changed.
    pub fn load_all(&mut self, sheets: &[Sheet<T>]) -> bool {
        let mut changed = false;
        let all: Vec<u32> = (0..self.count() as u32).collect();
        self.load(sheets, &all);
        for (spot, block) in self.spots.iter().zip(&mut self.blocks) {
            let sheet = &sheets[spot.sheet as usize];
            for (w, row) in block.w.chunks_exact_mut(SIDE).zip(rows(sheet, *spot)) {
                let at = row * 2 * sheet.half + 2 * spot.column as usize;
                let (even, odd) = (&sheet.w[at..at + 2], &sheet.w[at + sheet.half..at + sheet.half + 2]);
                changed |= w[..2] != *even || w[2..] != *odd;
                w[..2].copy_from_slice(even);
                w[2..].copy_from_slice(odd);
            }
        }
        changed
    }

    /// Positions of the particles of some tiles in ascending order, and previous ones.
    pub fn load(&mut self, sheets: &[Sheet<T>], tiles: &[u32]) {
        for run in self.runs(tiles) {
            let spot = self.spots[run.start];
            let sheet = &sheets[spot.sheet as usize];
            let blocks = &mut self.blocks[run];
            for (n, row) in rows(sheet, spot).enumerate() {
                for c in 0..3 {
                    let at = row * sheet.row() + 2 * c * sheet.half + 2 * spot.column as usize;
                    let [now, was] = [&sheet.now, &sheet.before].map(|list| {
                        let even = list[at..at + 2 * blocks.len()].as_chunks::<2>().0;
                        let odd = list[at + sheet.half..at + sheet.half + 2 * blocks.len()].as_chunks::<2>().0;
                        even.iter().zip(odd)
                    });
                    for ((block, (a, b)), (d, e)) in blocks.iter_mut().zip(now).zip(was) {
                        block.now[c][n * SIDE..][..SIDE].copy_from_slice(&[a[0], a[1], b[0], b[1]]);
                        block.was[c][n * SIDE..][..SIDE].copy_from_slice(&[d[0], d[1], e[0], e[1]]);
                    }
                }
            }
        }
    }

    /// Writes the rows of some tiles.
    pub fn arrange(&mut self, tiles: &[u32]) {
        widest(Arrange { tiles, blocks: &self.blocks, rows: &mut self.rows });
    }

    /// The row of the particle of a place.
    #[inline(always)]
    pub fn row(&self, place: u32) -> u32 {
        let lane = place as usize % LANES_OF_TILE;
        (place as usize - lane + self.lane_rows[lane]) as u32
    }

    /// Tiles in ascending order as runs of neighbours in a row.
    pub fn runs(&self, tiles: &[u32]) -> Vec<std::ops::Range<usize>> {
        let row = |tile: u32| (self.spots[tile as usize].sheet, self.spots[tile as usize].row);
        let runs = tiles.chunk_by(|a, b| a + 1 == *b && row(*a) == row(*b));
        runs.map(|run| run[0] as usize..run[0] as usize + run.len()).collect()
    }

    /// The position of a place.
    #[inline(always)]
    pub fn now(&self, place: usize) -> V3<T> {
        let (block, lane) = (&self.blocks[place / LANES_OF_TILE], place % LANES_OF_TILE);
        [block.now[0][lane], block.now[1][lane], block.now[2][lane]]
    }

    /// Its previous position.
    #[inline(always)]
    pub fn was(&self, place: usize) -> V3<T> {
        let (block, lane) = (&self.blocks[place / LANES_OF_TILE], place % LANES_OF_TILE);
        [block.was[0][lane], block.was[1][lane], block.was[2][lane]]
    }

    /// A position.
    #[inline(always)]
    pub fn at(list: &[Aligned<T>; 3], place: usize) -> V3<T> {
        [list[0][place], list[1][place], list[2][place]]
    }
}

struct Arrange<'a, T> {
    tiles: &'a [u32],
    blocks: &'a [Block<T>],
    rows: &'a mut [Vec<[T; 4]>; 2],
}

impl<T: Real> Work<T> for Arrange<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let zero = k.splat(T::of(0.0));
        let [now, was] = self.rows;
        for tile in self.tiles {
            let (block, first) = (&self.blocks[*tile as usize], *tile as usize * LANES_OF_TILE);
            for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let [x, y, z] = [&block.now[0], &block.now[1], &block.now[2]];
                k.table([k.load(x, at), k.load(y, at), k.load(z, at), zero], &mut now[first + at..]);
                let [x, y, z] = [&block.was[0], &block.was[1], &block.was[2]];
                k.table([k.load(x, at), k.load(y, at), k.load(z, at), zero], &mut was[first + at..]);
            }
        }
    }
}

/// [`Tiles::crossing2`]
fn crossing2<T: Real>(cloth: &Cloth, texel: &[u32]) -> Vec<T> {
    let grids = cloth.grids();
    let longest = |k: &u32| match cloth.rest() {
        _ if *k == u32::MAX => 0.0,
        Rest::None => cloth.spacing() * std::f32::consts::SQRT_2,
        Rest::Constant(each) => {
            each[grids.partition_point(|grid| grid.first <= *k) - 1].iter().copied().fold(0.0, f32::max)
        }
        Rest::Image(each) => each[*k as usize].iter().copied().fold(0.0, f32::max),
    };
    let of = |tile: &[u32]| T::of(0.5 * f64::from(tile.iter().map(longest).fold(0.0, f32::max)).powi(2));
    texel.chunks_exact(LANES_OF_TILE).map(of).collect()
}

/// [`Tiles::close`]
fn close<T: Real>() -> Vec<[[T; LANES_OF_TILE]; LANES_OF_TILE]> {
    let number = |right: usize, down: usize, a: usize, b: usize| {
        let ([i, j], [m, n]) = (corner(a), corner(b));
        let apart = (SIDE * right + m).abs_diff(SIDE + i).max((SIDE * down + n).abs_diff(SIDE + j));
        T::of(if apart <= SKIPPED_CELLS { FAR } else { 0.0 })
    };
    let table = |n: usize| std::array::from_fn(|a| std::array::from_fn(|b| number(n % 3, n / 3, a, b)));
    (0..9).map(table).collect()
}

/// The rows of a sheet that a tile has.
#[inline(always)]
pub fn rows<T: Real>(sheet: &Sheet<T>, spot: Spot) -> std::ops::Range<usize> {
    let first = SIDE * spot.row as usize;
    first..(first + SIDE).min(sheet.height)
}
