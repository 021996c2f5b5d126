//! Twin of shaders/touch.wgsl: how far contact moves each particle. All read the same positions, so their order does not matter.
//!
//! Both particles of a pair are pushed apart by their masses. Contact is inelastic: previous positions follow, so that a push ends
//! an approach but starts no flight. Friction takes from the motion along the surface.

use super::meeting::Meeting;
use super::meeting::others::OtherList;
use super::meeting::tiles::{LANES_OF_TILE, Tiles};
use super::partners::{MAX_PARTNERS, TileList};
use super::tree::Tree;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;

/// Share of what two particles are too near by which a step takes away: a particle may have several partners.
pub const TOUCH_SHARE: f64 = 0.5;
/// The longest push in a step, as a share of the contact distance.
pub const MAX_PUSH: f64 = 0.25;

/// Finds the pushes on all particles with partners.
pub fn run<T: Real>(meeting: &mut Meeting<T>, sheets: &[Sheet<T>], threads: &Threads, dt: T) {
    let Meeting { tiles, tree, active, lists, distance, friction, others, other_of, elapsed, .. } = meeting;
    tiles.load(sheets, active);
    tiles.arrange(active);
    tree.drift.measure(tiles, &tree.at, active);
    let (tiles, tree) = (&*tiles, &*tree);
    threads.chunks(lists, 16, |chunk, lists| {
        let others = |n: usize| others.get(*other_of.get(16 * chunk + n)? as usize);
        let others: Vec<_> = (0..lists.len()).map(others).collect();
        let [distance, friction, elapsed] = [*distance, *friction, *elapsed];
        widest(Push { lists, first: 16 * chunk, tiles, tree, others: &others, distance, friction, elapsed, dt });
    });
}

struct Push<'a, 'b, T: Real> {
    lists: &'b mut [TileList<T>],
    first: usize,
    tiles: &'a Tiles<T>,
    tree: &'a Tree<T>,
    /// One a list.
    others: &'a [Option<&'a OtherList<T>>],
    distance: T,
    friction: T,
    /// Since the beginning of the frame \[s\].
    elapsed: T,
    dt: T,
}

/// The rows of the partners of a tile.
type Gathered<T> = [[T; 4]; LANES_OF_TILE];

/// Rows of partners. They are gathered for all partners of a tile before they are read: a processor waits where a vector is read that less
/// than that has just been written to.
#[inline(always)]
fn gather<T: Real>(rows: &[[T; 4]], partners: &[u32], to: &mut Gathered<T>) {
    for (to, partner) in to.iter_mut().zip(&partners[..LANES_OF_TILE]) {
        *to = rows[*partner as usize];
    }
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

/// Three columns of a table.
#[inline(always)]
fn columns<T: Real, K: Machine<T>>(k: K, table: &Gathered<T>, at: usize) -> [K::V; 3] {
    let [x, y, z, _] = k.columns(&table[at..]);
    [x, y, z]
}

/// Three vectors of a tile.
#[inline(always)]
fn row<T: Real, K: Machine<T>>(k: K, list: &[[T; LANES_OF_TILE]; 3], at: usize) -> [K::V; 3] {
    [k.load(&list[0], at), k.load(&list[1], at), k.load(&list[2], at)]
}

impl<T: Real> Work<T> for Push<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(mut self, k: K) {
        let zeros = [T::of(0.0); 4];
        let mut there = [[[zeros; LANES_OF_TILE]; 2]; MAX_PARTNERS];
        for n in 0..self.lists.len() {
            self.lists[n].moves = false;
            if self.lists[n].count > 0 || self.others[n].is_some() {
                self.tile(k, n, &mut there);
            }
        }
    }
}

impl<T: Real> Push<'_, '_, T> {
    /// The pushes on the particles of one tile.
    #[inline(always)]
    fn tile<K: Machine<T>>(&mut self, k: K, n: usize, there: &mut [[Gathered<T>; 2]; MAX_PARTNERS]) {
        let (zero, tiny) = (k.splat(T::of(0.0)), k.splat(T::of(1e-12)));
        let (friction, elapsed, dt) = (k.splat(self.friction), k.splat(self.elapsed), k.splat(self.dt));
        let (list, other) = (&mut self.lists[n], self.others[n]);
        let Some(own_block) = self.tiles.blocks.get(self.first + n) else { return };
        let [now_rows, was_rows] = &self.tiles.rows;
        let count = (list.count as usize).min(MAX_PARTNERS);
        // Vectors of particles whose partners are all out of reach still.
        let moved = self.tree.drift.moved(self.first + n);
        let count = list.spare[..count].iter().rposition(|spare| *spare <= moved).map_or(0, |last| last + 1);
        // Particles that were near their partners are likely to be so again: their previous positions are gathered at once.
        let (mut known, mut touches) = (list.near, 0);
        for (slot, there) in there[..count].iter_mut().enumerate() {
            let partners = &list.partner[slot * LANES_OF_TILE..];
            gather(now_rows, partners, &mut there[0]);
            if known >> slot & 1 == 1 {
                gather(was_rows, partners, &mut there[1]);
            }
        }
        for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
            let (now, was) = (row(k, &own_block.now, at), row(k, &own_block.was, at));
            let (w, step) = (k.load(&own_block.w, at), k.minus(now, was));
            let (mut sum, mut moves) = (Sum::new(zero), false);
            for (slot, there) in there[..count].iter_mut().enumerate() {
                let from = slot * LANES_OF_TILE;
                let at_partner = columns(k, &there[0], at);
                let way = k.minus(now, at_partner);
                let (least, far2) = (k.load(&list.least, from + at), k.squares(way));
                let near = k.both(k.above(k.mul(least, least), far2), k.above(far2, tiny));
                if !k.any(near) {
                    continue;
                }
                moves = true;
                touches |= 1 << slot;
                if known >> slot & 1 == 0 {
                    known |= 1 << slot;
                    gather(was_rows, &list.partner[from..], &mut there[1]);
                }
                let own = k.load(&list.own, from + at);
                let slide = k.minus(step, k.minus(at_partner, columns(k, &there[1], at)));
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
            let [now, was] =
                if moves { sum.changes(k, k.splat(self.distance * T::of(MAX_PUSH))) } else { [[zero; 3]; 2] };
            for c in 0..3 {
                k.store(&mut list.change[c], at, now[c]);
                k.store(&mut list.change[3 + c], at, was[c]);
            }
        }
        list.near = touches;
    }
}
