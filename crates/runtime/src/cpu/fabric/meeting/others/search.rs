//! The comparison of a tile of particles with tiles of other cloths: a vector of the other tile at a time.

use super::nearest::Nearest;
use super::{Pair, least};
use crate::cpu::fabric::meeting::extents::WIDTH;
use crate::cpu::fabric::meeting::loose::is_loose;
use crate::cpu::fabric::meeting::patrol::{Patrol, Suspect, crossing2};
use crate::cpu::fabric::meeting::shadow::Shadow;
use crate::cpu::fabric::meeting::tiles::LANES_OF_TILE;
use crate::cpu::fabric::tree::Node;
use crate::number::aligned::Aligned;
use crate::number::lanes::{LANES, Machine, Work};
use crate::number::real::{Real, dot};

/// A little more than 1, for bounds of squares of distances that are rounded.
const ROUNDING: f64 = 1.001;
/// The same for coordinates, as a share of the largest one: boxes and ways are sums of them.
const COORDINATES: f64 = 1e-6;
/// (a + b)^2 is at most `APART` a^2 + `MOVED` b^2.
const APART: f64 = 1.1;
const MOVED: f64 = 11.0;

/// The comparison of a tile with those of other cloths.
pub struct Search<'a, 'b, T: Real> {
    pub best: &'b mut [Nearest<T>; LANES_OF_TILE],
    /// Whether each cloth that is asleep is woken.
    pub struck: &'b mut [bool],
    /// Of tiles at which cloth is looked for that crosses.
    pub patrol: Option<&'b mut Patrol>,
    pub shadow: &'a Shadow<T>,
    pub tile: usize,
    pub pairs: &'b [Pair],
    pub shadows: &'a [Option<Shadow<T>>],
}

/// Vectors of the particles of a tile.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(k: K, list: &[Aligned<T>; 3], at: usize) -> [K::V; 3] {
    [k.load(&list[0], at), k.load(&list[1], at), k.load(&list[2], at)]
}

/// Squares of distances \[m^2\] up to which a pair of tiles is compared.
struct Bounds<T> {
    /// Within which particles may meet, and within which cloth may cross.
    far: T,
    crossing: T,
    /// [`Nearest::last`] of each particle, infinite where the other cloth is asleep and may wake.
    last: [T; LANES_OF_TILE],
}

/// For each particle of a tile up to which distance it is compared with those of a box, as its square \[m^2\]; 0 where its way passes the box by.
/// A particle that cannot move meets none.
#[inline(always)]
fn bounds_of<T: Real, K: Machine<T>>(
    k: K,
    (shadow, tile): (&Shadow<T>, usize),
    (other, node): (&Shadow<T>, &Node<T>),
    bounds: &Bounds<T>,
) -> [T; LANES_OF_TILE] {
    let mut each = [T::of(0.0); LANES_OF_TILE];
    let (zero, length) = (k.splat(T::of(0.0)), k.splat(shadow.length));
    let (wide, wide_other) = (k.splat(shadow.distance * T::of(WIDTH)), k.splat(other.distance * T::of(WIDTH)));
    let largest = node.low.iter().chain(&node.high).fold(T::of(0.0), |most, x| most.max(x.abs()));
    let rounds = k.splat(largest * T::of(COORDINATES));
    for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
        let place = tile * LANES_OF_TILE + at;
        let (now, velocity) = (row(k, &shadow.now, place), row(k, &shadow.velocity, place));
        let end = k.plus(now, k.times(velocity, length));
        let bound = k.most(k.least(k.load(&bounds.last, at), k.splat(bounds.far)), k.splat(bounds.crossing));
        let mut kept = k.choose(k.above(k.load(&shadow.w, place), zero), bound, zero);
        let mut gap2 = zero;
        for c in 0..3 {
            let (low, high) = (k.splat(node.low[c]), k.splat(node.high[c]));
            let (least, most) = (k.least(now[c], end[c]), k.most(now[c], end[c]));
            let within = k.both(k.at_least(k.add(most, wide), low), k.at_least(high, k.sub(least, wide)));
            kept = k.choose(within, kept, zero);
            // Boxes of tiles are larger than what their particles pass.
            let gap = k.most(k.sub(k.add(low, wide_other), most), k.sub(least, k.sub(high, wide_other)));
            let gap = k.most(k.sub(gap, rounds), zero);
            gap2 = k.add(gap2, k.mul(gap, gap));
        }
        let near = k.at_least(k.mul(bound, k.splat(T::of(ROUNDING))), gap2);
        k.store(&mut each, at, k.choose(near, kept, zero));
    }
    each
}

impl<T: Real> Work<T> for Search<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(mut self, k: K) {
        for n in 0..self.pairs.len() {
            let pair = self.pairs[n];
            if let Some(other) = &self.shadows[pair.cloth as usize] {
                self.tile(k, other, pair);
            }
        }
    }
}

impl<T: Real> Search<'_, '_, T> {
    /// Compares the particles of two tiles.
    #[inline(always)]
    fn tile<K: Machine<T>>(&mut self, k: K, other: &Shadow<T>, pair: Pair) {
        let (shadow, from) = (self.shadow, pair.other as usize * LANES_OF_TILE);
        let zero = k.splat(T::of(0.0));
        let (length, tiny) = (k.splat(shadow.length), k.splat(T::of(1e-20)));
        let reach = (shadow.distance + other.distance) * T::of(WIDTH);
        let far = reach * reach;
        let longest = |of: &Shadow<T>, tile: usize| {
            let first = tile * LANES_OF_TILE;
            crossing2(of.crossing2[tile], &of.out[first..first + LANES_OF_TILE], |lane| of.at(first + lane))
        };
        let crossing = match &self.patrol {
            Some(_) => longest(shadow, self.tile).max(longest(other, pair.other as usize)),
            None => T::of(0.0),
        };
        let sleeps = other.wakes_at < T::of(f64::INFINITY);
        let mut bounds = Bounds { far, crossing, last: [T::of(f64::INFINITY); LANES_OF_TILE] };
        if !sleeps {
            bounds.last.iter_mut().zip(&*self.best).for_each(|(last, best)| *last = best.last());
        }
        let node = &other.tree.nodes[pair.other as usize];
        let each = bounds_of(k, (shadow, self.tile), (other, node), &bounds);
        let moved2 = k.splat(shadow.length * shadow.length * T::of(MOVED * ROUNDING));
        for (lane, bound) in each.into_iter().enumerate().filter(|(_, bound)| *bound > T::of(0.0)) {
            let mine = self.tile * LANES_OF_TILE + lane;
            let own = k.splats(shadow.at(mine));
            let moves = k.splats(shadow.velocity_at(mine));
            for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let place = from + at;
                let way = k.minus(row(k, &other.now, place), own);
                let speed = k.minus(row(k, &other.velocity, place), moves);
                let speed2 = k.squares(speed);
                // They are too far apart however they move.
                let reached = k.add(k.splat(bound * T::of(APART * ROUNDING)), k.mul(moved2, speed2));
                if !k.any(k.at_least(reached, k.squares(way))) {
                    continue;
                }
                // When they are nearest, if they go on as they do.
                let time = k.div(k.sub(zero, k.dot(way, speed)), k.most(speed2, tiny));
                let time = k.least(k.most(time, zero), length);
                let near = k.squares(k.plus(way, k.times(speed, time)));
                let near = k.add(near, k.load(&other.out, place));
                if !k.any(k.above(k.splat(bound), near)) {
                    continue;
                }
                let mut each = [T::of(0.0); LANES];
                k.store(&mut each, 0, near);
                let mut bits = bits_below(&each, bound) & (u32::MAX >> (u32::BITS - K::WIDE as u32));
                while bits != 0 {
                    let n = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    self.take((mine, place + n), (other, pair.cloth), (each[n], &bounds));
                }
            }
        }
    }

    /// Takes in two particles, the second of another cloth, that come as near as this.
    #[inline(always)]
    fn take(
        &mut self,
        (mine, place): (usize, usize),
        (other, cloth): (&Shadow<T>, u32),
        (near, bounds): (T, &Bounds<T>),
    ) {
        if let Some(patrol) = self.patrol.as_mut().filter(|_| near < bounds.crossing) {
            patrol.suspect(Suspect { place: mine as u32, cloth: Some(cloth), other: place as u32 });
        }
        let passes = is_loose(&self.shadow.loose, mine) && is_loose(&other.loose, place);
        if near < bounds.far && !passes {
            if other.wakes_at < T::of(f64::INFINITY) {
                self.struck[cloth as usize] |= wakes((self.shadow, mine), (other, place), near);
            }
            self.best[mine % LANES_OF_TILE].take(near, [cloth, place as u32]);
        }
    }
}

/// A bit for each number below a bound.
#[inline(always)]
fn bits_below<T: Real>(each: &[T; LANES], bound: T) -> u32 {
    each.iter().enumerate().fold(0, |bits, (n, x)| bits | u32::from(*x < bound) << n)
}

/// Whether a particle touches cloth that is asleep, and moves so fast that this wakes.
fn wakes<T: Real>(own: (&Shadow<T>, usize), (other, from): (&Shadow<T>, usize), near: T) -> bool {
    let (velocity, least) = (own.0.velocity_at(own.1), least(own, (other, from)));
    dot(velocity, velocity) > other.wakes_at * other.wakes_at && near < least * least
}
