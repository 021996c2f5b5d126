//! How far particles have moved since the last search, beside the motion that they have in common: it brings no particle nearer to another.

use super::meeting::tiles::{Block, LANES_OF_TILE, Tiles};
use super::tree::Tree;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, add, sub};
use crate::passes::SEARCH_STEPS;

/// Rounding of differences of positions, as a share of the common motion.
const ROUNDING: f64 = 1e-6;

/// The motion of particles since the last search.
pub struct Drift<T> {
    /// For each tile the farthest \[m\] that one of its particles has moved beside `common`, and the farthest of all.
    way: Vec<T>,
    longest: T,
    /// The motion \[m\] that is taken off.
    common: V3<T>,
    /// The middle of the motions of all particles in the last step in which they were measured.
    middle: V3<T>,
}

impl<T: Real> Drift<T> {
    /// That of tiles of which none has moved.
    pub fn new(tiles: usize) -> Self {
        let zero = T::of(0.0);
        Drift { way: vec![zero; tiles], longest: zero, common: [zero; 3], middle: [zero; 3] }
    }

    /// Begins again after a search.
    pub fn begin(&mut self) {
        (self.common, self.middle) = ([T::of(0.0); 3], [T::of(0.0); 3]);
    }

    /// One number a tile.
    pub fn list(&self) -> &Vec<T> {
        &self.way
    }

    /// By how much \[m\] a particle of a tile can have come nearer to another since the last search, at most; with room for rounding.
    #[inline(always)]
    pub fn moved(&self, tile: usize) -> T {
        let [x, y, z] = self.common.map(T::abs);
        (self.way[tile] + self.longest) * T::of(1.001) + (x + y + z) * T::of(ROUNDING)
    }

    /// Measures the particles of some tiles, which are all that touch others or are touched, from where they were in the search.
    pub fn measure(&mut self, tiles: &Tiles<T>, at: &[Places<T>], active: &[u32]) {
        widest(Measure { drift: self, tiles, at, active });
    }
}

/// Positions of the particles of a tile.
pub type Places<T> = [[T; LANES_OF_TILE]; 3];

/// Whether no particle leaves its reach in the next [`SEARCH_STEPS`] steps, if it goes on as in the last one.
pub fn holds<T: Real>(tree: &Tree<T>, tiles: &Tiles<T>) -> bool {
    let mut holds = true;
    widest(Holds { tree, tiles, holds: &mut holds });
    holds
}

/// Bounds of vectors.
#[derive(Clone, Copy)]
struct Span<V> {
    low: [V; 3],
    high: [V; 3],
}

impl<V: Copy> Span<V> {
    #[inline(always)]
    fn none<T: Real, K: Machine<T, V = V>>(k: K) -> Self {
        let far = f64::from(f32::MAX);
        Span { low: [k.splat(T::of(far)); 3], high: [k.splat(T::of(-far)); 3] }
    }

    /// Takes in the vectors where `there` is set.
    #[inline(always)]
    fn take<T: Real, K: Machine<T, V = V>>(&mut self, k: K, there: K::M, v: [V; 3]) {
        for ((low, high), x) in self.low.iter_mut().zip(&mut self.high).zip(v) {
            *low = k.choose(there, k.least(x, *low), *low);
            *high = k.choose(there, k.most(x, *high), *high);
        }
    }

    /// The middle; 0 of no vectors.
    #[inline(always)]
    fn middle<T: Real, K: Machine<T, V = V>>(&self, k: K) -> V3<T> {
        let mut middle = [T::of(0.0); 3];
        for (c, middle) in middle.iter_mut().enumerate() {
            let [mut low, mut high] = [[T::of(0.0); LANES]; 2];
            k.store(&mut low, 0, self.low[c]);
            k.store(&mut high, 0, self.high[c]);
            let least = low[..K::WIDE].iter().fold(low[0], |a, b| a.min(*b));
            let most = high[..K::WIDE].iter().fold(high[0], |a, b| a.max(*b));
            if least <= most {
                *middle = least * T::of(0.5) + most * T::of(0.5);
            }
        }
        middle
    }
}

/// The largest number of a vector.
#[inline(always)]
fn largest<T: Real, K: Machine<T>>(k: K, v: K::V) -> T {
    let mut each = [T::of(0.0); LANES];
    k.store(&mut each, 0, v);
    each[..K::WIDE].iter().fold(each[0], |a, b| a.max(*b))
}

/// Vectors of a tile.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(k: K, list: &Places<T>, at: usize) -> [K::V; 3] {
    [k.load(&list[0], at), k.load(&list[1], at), k.load(&list[2], at)]
}

/// Which places of a tile have particles.
#[inline(always)]
fn there<T: Real, K: Machine<T>>(k: K, tiles: &Tiles<T>, tile: usize, at: usize) -> K::M {
    k.above(k.load(&tiles.there, tile * LANES_OF_TILE + at), k.splat(T::of(0.0)))
}

struct Measure<'a, T: Real> {
    drift: &'a mut Drift<T>,
    tiles: &'a Tiles<T>,
    at: &'a [Places<T>],
    active: &'a [u32],
}

impl<T: Real> Work<T> for Measure<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Measure { drift, tiles, at, active } = self;
        let (zero, common) = (k.splat(T::of(0.0)), k.splats(drift.common));
        let (mut span, mut longest) = (Span::none(k), T::of(0.0));
        for tile in active {
            let tile = *tile as usize;
            let mut far = zero;
            for n in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let there = there(k, tiles, tile, n);
                let way = k.minus(row(k, &tiles.blocks[tile].now, n), row(k, &at[tile], n));
                span.take(k, there, way);
                far = k.most(far, k.choose(there, k.squares(k.minus(way, common)), zero));
            }
            let far = largest(k, far).sqrt();
            drift.way[tile] = far;
            longest = longest.max(far);
        }
        drift.longest = longest;
        // Where the middle is expected in the next step: any common motion may be taken off.
        let middle = span.middle(k);
        drift.common = add(middle, sub(middle, drift.middle));
        drift.middle = middle;
    }
}

struct Holds<'a, T: Real> {
    tree: &'a Tree<T>,
    tiles: &'a Tiles<T>,
    holds: &'a mut bool,
}

impl<T: Real> Work<T> for Holds<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Holds { tree, tiles, holds } = self;
        let zero = k.splat(T::of(0.0));
        let mut spans = [Span::none(k); 2];
        for (tile, (block, at)) in tiles.blocks.iter().zip(&tree.at).enumerate() {
            for n in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let there = there(k, tiles, tile, n);
                let [way, step] = ways(k, block, at, n);
                spans[0].take(k, there, way);
                spans[1].take(k, there, step);
            }
        }
        let (common, pace) = (k.splats(spans[0].middle(k)), k.splats(spans[1].middle(k)));
        for (tile, (block, at)) in tiles.blocks.iter().zip(&tree.at).enumerate() {
            let (mut far, mut ahead) = (zero, zero);
            for n in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let there = there(k, tiles, tile, n);
                let [way, step] = ways(k, block, at, n);
                far = k.most(far, k.choose(there, k.squares(k.minus(way, common)), zero));
                ahead = k.most(ahead, k.choose(there, k.squares(k.minus(step, pace)), zero));
            }
            let [far, ahead] = [largest(k, far).sqrt(), largest(k, ahead).sqrt()];
            if far + ahead * T::of(SEARCH_STEPS.into()) > tree.reach[tile] {
                *holds = false;
                return;
            }
        }
    }
}

/// How far particles of a tile have moved since the search, and in the last step.
#[inline(always)]
fn ways<T: Real, K: Machine<T>>(k: K, block: &Block<T>, at: &Places<T>, n: usize) -> [[K::V; 3]; 2] {
    let now = row(k, &block.now, n);
    [k.minus(now, row(k, at, n)), k.minus(now, row(k, &block.was, n))]
}
