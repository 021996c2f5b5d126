//! Twin of shaders/touch.wgsl: how far contact moves each particle. All read the same positions, so their order does not matter.
//!
//! Both particles of a pair are pushed apart by their masses. Contact is inelastic: previous positions follow, so that a push ends
//! an approach but starts no flight. Friction takes from the motion along the surface.

use super::meeting::Meeting;
use super::meeting::others::OtherList;
use super::meeting::tiles::{LANES_OF_TILE, Tiles};
use super::partners::TileList;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::number::aligned::Aligned;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::Real;

/// Share of what two particles are too near by which a step takes away: a particle may have several partners.
pub const TOUCH_SHARE: f64 = 0.5;
/// The longest push in a step, as a share of the contact distance.
pub const MAX_PUSH: f64 = 0.25;

/// Finds the pushes on all particles with partners.
pub fn run<T: Real>(meeting: &mut Meeting<T>, sheets: &[Sheet<T>], threads: &Threads, dt: T) {
    let Meeting { tiles, active, lists, distance, friction, others, other_of, elapsed, .. } = meeting;
    active.iter().for_each(|tile| tiles.load(sheets, *tile as usize));
    let tiles = &*tiles;
    threads.chunks(lists, 16, |chunk, lists| {
        let others = |n: usize| others.get(*other_of.get(16 * chunk + n)? as usize);
        let others: Vec<_> = (0..lists.len()).map(others).collect();
        let [distance, friction, elapsed] = [*distance, *friction, *elapsed];
        widest(Push { lists, first: 16 * chunk, tiles, others: &others, distance, friction, elapsed, dt });
    });
}

struct Push<'a, 'b, T: Real> {
    lists: &'b mut [TileList<T>],
    first: usize,
    tiles: &'a Tiles<T>,
    /// One a list.
    others: &'a [Option<&'a OtherList<T>>],
    distance: T,
    friction: T,
    /// Since the beginning of the frame \[s\].
    elapsed: T,
    dt: T,
}

/// Numbers of some places.
#[inline(always)]
fn gather<T: Real, K: Machine<T>>(k: K, list: &[T], places: &[u32]) -> K::V {
    let mut each = [T::of(0.0); LANES];
    for (each, place) in each.iter_mut().zip(places) {
        *each = list[*place as usize];
    }
    k.load(&each, 0)
}

/// Vectors of some places.
#[inline(always)]
fn gather3<T: Real, K: Machine<T>>(k: K, [x, y, z]: &[Aligned<T>; 3], places: &[u32]) -> [K::V; 3] {
    [gather(k, x, places), gather(k, y, places), gather(k, z, places)]
}

/// The sum of what pairs ask of a vector of particles.
struct Sum<V> {
    push: [V; 3],
    back: [V; 3],
    rubs: [V; 3],
    /// The largest of one pair: the length of a push, of what ends an approach, and of friction.
    long_push: V,
    long_stop: V,
    long_rub: V,
}

/// One pair of each particle of a vector.
struct Pair<V> {
    /// From the other particle to this one.
    way: [V; 3],
    far2: V,
    /// Motion in the step, beside that of the other particle.
    slide: [V; 3],
    least: V,
    /// This particle's share of a push, and of the end of an approach.
    own: V,
    own_stop: V,
    friction: V,
}

impl<V: Copy> Sum<V> {
    /// Nothing yet.
    #[inline(always)]
    fn new(zero: V) -> Self {
        Sum { push: [zero; 3], back: [zero; 3], rubs: [zero; 3], long_push: zero, long_stop: zero, long_rub: zero }
    }

    /// Adds the pairs that are near.
    #[inline(always)]
    fn add<T: Real, K: Machine<T, V = V>>(&mut self, k: K, near: K::M, pair: Pair<V>) {
        let (zero, tiny) = (k.splat(T::of(0.0)), k.splat(T::of(1e-12)));
        let share = k.splat(T::of(TOUCH_SHARE));
        let far = k.sqrt(k.most(pair.far2, tiny));
        let normal = k.times(pair.way, k.div(k.splat(T::of(1.0)), far));
        let apart = k.choose(near, k.mul(k.sub(pair.least, far), share), zero);
        let away = k.dot(pair.slide, normal);
        // Of the push what ends an approach: previous positions follow the rest.
        let stop = k.mul(k.most(k.sub(apart, k.least(k.most(k.add(away, apart), zero), apart)), zero), pair.own_stop);
        let along = k.minus(pair.slide, k.times(normal, away));
        let long = k.sqrt(k.squares(along));
        let rub = k.mul(k.least(k.mul(pair.friction, apart), k.mul(share, long)), pair.own);
        let apart = k.mul(apart, pair.own);
        self.push = k.plus(self.push, k.times(normal, apart));
        self.back = k.plus(self.back, k.times(normal, stop));
        self.rubs = k.plus(self.rubs, k.times(along, k.div(rub, k.most(long, tiny))));
        self.long_push = k.most(self.long_push, apart);
        self.long_stop = k.most(self.long_stop, stop);
        self.long_rub = k.most(self.long_rub, rub);
    }

    /// The changes of positions and of previous ones. Several partners ask for the same motion: together they get what one of them
    /// asks for, or a little more.
    #[inline(always)]
    fn changes<T: Real, K: Machine<T, V = V>>(self, k: K, longest: V) -> [[V; 3]; 2] {
        let stop = within(k, self.back, self.long_stop);
        let whole = k.div(self.long_push, k.splat(T::of(TOUCH_SHARE)));
        let push = within(k, self.push, k.least(whole, longest));
        let rubs = within(k, self.rubs, k.add(self.long_rub, self.long_rub));
        [k.minus(push, rubs), k.minus(push, stop)]
    }
}

/// A vector that is shortened to a length.
#[inline(always)]
fn within<T: Real, K: Machine<T>>(k: K, v: [K::V; 3], most: K::V) -> [K::V; 3] {
    let long = k.most(k.sqrt(k.squares(v)), k.splat(T::of(1e-12)));
    k.times(v, k.least(k.div(most, long), k.splat(T::of(1.0))))
}

/// Three vectors of a tile.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(k: K, list: &[[T; LANES_OF_TILE]; 3], at: usize) -> [K::V; 3] {
    [k.load(&list[0], at), k.load(&list[1], at), k.load(&list[2], at)]
}

impl<T: Real> Work<T> for Push<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Push { lists, first, tiles, others, distance, friction, elapsed, dt } = self;
        let (zero, tiny) = (k.splat(T::of(0.0)), k.splat(T::of(1e-12)));
        let (friction, elapsed, dt) = (k.splat(friction), k.splat(elapsed), k.splat(dt));
        let longest = k.splat(distance * T::of(MAX_PUSH));
        for (n, list) in lists.iter_mut().enumerate() {
            list.moves = false;
            let other = others[n];
            let none = list.count == 0 && other.is_none();
            for at in (0..LANES_OF_TILE).step_by(if none { LANES_OF_TILE } else { K::WIDE }) {
                if none {
                    break;
                }
                let place = (first + n) * LANES_OF_TILE + at;
                let now = [k.load(&tiles.now[0], place), k.load(&tiles.now[1], place), k.load(&tiles.now[2], place)];
                let was = [k.load(&tiles.was[0], place), k.load(&tiles.was[1], place), k.load(&tiles.was[2], place)];
                let (w, step) = (k.load(&tiles.w, place), k.minus(now, was));
                let (mut sum, mut moves) = (Sum::new(zero), false);
                for slot in 0..list.count as usize {
                    let from = slot * LANES_OF_TILE + at;
                    let partners = &list.partner[from..from + K::WIDE];
                    let there = gather3(k, &tiles.now, partners);
                    let way = k.minus(now, there);
                    let (least, far2) = (k.load(&list.least, from), k.squares(way));
                    let near = k.both(k.above(k.mul(least, least), far2), k.above(far2, tiny));
                    if !k.any(near) {
                        continue;
                    }
                    moves = true;
                    let own = k.div(w, k.most(k.add(w, gather(k, &tiles.w, partners)), tiny));
                    let slide = k.minus(step, k.minus(there, gather3(k, &tiles.was, partners)));
                    sum.add(k, near, Pair { way, far2, slide, least, own, own_stop: own, friction });
                }
                if let Some(other) = other {
                    for slot in 0..other.count {
                        let gone = k.times(row(k, &other.velocity[slot], at), elapsed);
                        let way = k.minus(now, k.plus(row(k, &other.at[slot], at), gone));
                        let (least, far2) = (k.load(&other.least[slot], at), k.squares(way));
                        let near = k.both(k.above(k.mul(least, least), far2), k.above(far2, tiny));
                        if !k.any(near) {
                            continue;
                        }
                        moves = true;
                        let own = k.div(w, k.most(k.add(w, k.load(&other.w[slot], at)), tiny));
                        // The other cloth ends its part of the approach in its own steps.
                        let slide = k.minus(step, k.times(row(k, &other.mean[slot], at), dt));
                        let own_stop = k.choose(k.above(w, zero), k.splat(T::of(1.0)), zero);
                        let friction = k.load(&other.friction[slot], at);
                        sum.add(k, near, Pair { way, far2, slide, least, own, own_stop, friction });
                    }
                }
                list.moves |= moves;
                let [now, was] = sum.changes(k, longest);
                for c in 0..3 {
                    k.store(&mut list.change[c], at, now[c]);
                    k.store(&mut list.change[3 + c], at, was[c]);
                }
            }
        }
    }
}
