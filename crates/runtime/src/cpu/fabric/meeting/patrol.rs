//! Looks for particles that are so near that triangles around them may cross, a part of the tiles per frame.
//!
//! Two triangles whose edges are at most L long cross only if corners of both are nearer than L / sqrt 2, with L as it is where cloth is stretched. Contact keeps particles farther
//! apart where it succeeds, so that few pairs are suspects. The triangles around these are compared in `world/patrol.rs`.

use super::tiles::{LANES_OF_TILE, SIDE, Tiles, lane};
use crate::cpu::fabric::tile_pairs::Beside;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, dot, sub};

/// Frames in which each tile is looked at once.
pub const ROUND: usize = 16;
/// Pairs of particles that a frame finds, at most: further ones wait for the next round.
pub const MAX_SUSPECTS: usize = 64;
/// Tiles of a frame by which the start of a round is shifted.
const START_STRIDE: usize = 5;

/// Two particles that are too near for their triangles not to cross.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Suspect {
    /// Place of a particle of the cloth.
    pub place: u32,
    /// Index of the other one's cloth, none for the same cloth, and its place there.
    pub cloth: Option<u32>,
    pub other: u32,
}

/// The looks at a cloth.
#[derive(Default)]
pub struct Patrol {
    /// Frames so far.
    frames: usize,
    /// Whether this frame has its look still ahead.
    due: bool,
    /// Found in this frame.
    pub suspects: Vec<Suspect>,
}

impl Patrol {
    /// Has the next search look at the tiles of a frame.
    pub fn begin(&mut self) {
        (self.frames, self.due) = (self.frames + 1, true);
        self.suspects.clear();
    }

    /// Begins a round.
    pub fn forget(&mut self) {
        *self = Patrol::default();
    }

    /// Whether a tile is looked at in this frame.
    pub fn has(&self, tile: usize) -> bool {
        tile % ROUND == self.frames % ROUND
    }

    /// Takes in a pair, if there is room.
    pub fn suspect(&mut self, suspect: Suspect) {
        if !self.is_full() {
            self.suspects.push(suspect);
        }
    }

    fn is_full(&self) -> bool {
        self.suspects.len() >= MAX_SUSPECTS
    }

    /// Looks at the tiles of a frame, once.
    pub fn look<T: Real>(&mut self, tiles: &Tiles<T>, beside: &Beside) {
        if std::mem::take(&mut self.due) {
            widest(Look { patrol: self, tiles, beside });
        }
    }
}

/// Half the square of the longest diagonal in a tile \[m^2\] as it is now, and at least `rest`; `at` has the position of a place, and `out` is above 0 for
/// places without a particle.
pub fn crossing2<T: Real>(rest: T, out: &[T], at: impl Fn(usize) -> V3<T>) -> T {
    let mut most = rest;
    for (i, j) in (0..SIDE - 1).flat_map(|j| (0..SIDE - 1).map(move |i| (i, j))) {
        for (a, b) in [(lane(i, j), lane(i + 1, j + 1)), (lane(i + 1, j), lane(i, j + 1))] {
            if out[a] <= T::of(0.0) && out[b] <= T::of(0.0) {
                let way = sub(at(a), at(b));
                most = most.max(T::of(0.5) * dot(way, way));
            }
        }
    }
    most
}

/// [`crossing2`] of a tile.
fn longest<T: Real>(tiles: &Tiles<T>, tile: usize) -> T {
    let first = tile * LANES_OF_TILE;
    crossing2(tiles.crossing2[tile], &tiles.out[first..first + LANES_OF_TILE], |lane| tiles.now(first + lane))
}

struct Look<'a, T: Real> {
    patrol: &'a mut Patrol,
    tiles: &'a Tiles<T>,
    beside: &'a Beside,
}

impl<T: Real> Work<T> for Look<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Look { patrol, tiles, beside } = self;
        let turn = patrol.frames % ROUND;
        let count = (tiles.count() + ROUND - 1 - turn) / ROUND;
        // Each round begins elsewhere: a frame does not find all pairs of a heap.
        let round = patrol.frames / ROUND;
        for tile in (0..count).map(|n| (round * START_STRIDE + n) % count * ROUND + turn) {
            let own_most = longest(tiles, tile);
            let others = beside.of(tile);
            for other in (0..others.len()).map(|n| others[(round + n) % others.len()] as usize) {
                if patrol.is_full() {
                    return;
                }
                if other < tile {
                    continue;
                }
                let most = own_most.max(longest(tiles, other));
                let far = k.splat(most);
                let (close, block) = (tiles.close(tile, other), &tiles.blocks[other]);
                for lane in (0..LANES_OF_TILE).map(|n| (round + n) % LANES_OF_TILE) {
                    let place = tile * LANES_OF_TILE + lane;
                    if tiles.out[place] > T::of(0.0) {
                        continue;
                    }
                    let own = k.splats(tiles.now(place));
                    for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
                        let [x, y, z] = &block.now;
                        let there = [k.load(x, at), k.load(y, at), k.load(z, at)];
                        let apart = k.squares(k.minus(there, own));
                        let mut apart = k.add(apart, k.load(&tiles.out, other * LANES_OF_TILE + at));
                        if let Some(close) = close {
                            apart = k.add(apart, k.load(&close[lane], at));
                        }
                        if !k.any(k.above(far, apart)) {
                            continue;
                        }
                        let mut each = [T::of(0.0); LANES];
                        k.store(&mut each, 0, apart);
                        for (n, apart) in each[..K::WIDE].iter().enumerate() {
                            let there = other * LANES_OF_TILE + at + n;
                            if *apart < most && (tile != other || there > place) {
                                patrol.suspect(Suspect { place: place as u32, cloth: None, other: there as u32 });
                            }
                        }
                    }
                }
            }
        }
    }
}
