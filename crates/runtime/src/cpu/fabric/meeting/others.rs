//! Twin of shaders/others.wgsl: particles of other cloths that those of a cloth may meet in some steps. They go on as they moved when the
//! search began: each cloth steps by itself, and both sides of a pair take their share.

use super::Meeting;
use super::extents::WIDTH;
use super::loose::is_loose;
use super::patrol::{Patrol, Suspect, crossing2};
use super::shadow::Shadow;
use super::tiles::{LANES_OF_TILE, Tiles};
use crate::cpu::fabric::partners::{REST_SHARE, between};
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, add, dot, scale, sub};

/// Particles of other cloths for each particle: the nearest ones.
pub const MAX_OTHERS: usize = 4;

/// The numbers of a particle of another cloth.
#[derive(Clone, Copy)]
struct Other<T> {
    /// Its shadow among all, and its place there.
    from: [u32; 2],
    /// Square of the smallest distance \[m^2\] in the frame.
    near: T,
    at: V3<T>,
    velocity: V3<T>,
    /// The velocity \[m/s\] that both have after an inelastic impact.
    mean: V3<T>,
    least: T,
    w: T,
    friction: T,
}

/// Those that the particles of a tile may meet, a vector for each component.
#[derive(Clone)]
pub struct OtherList<T> {
    /// The most of one particle.
    pub count: usize,
    /// For each its shadow among all and its place there, `u32::MAX` for none.
    from: [[[u32; 2]; LANES_OF_TILE]; MAX_OTHERS],
    pub at: [[[T; LANES_OF_TILE]; 3]; MAX_OTHERS],
    pub velocity: [[[T; LANES_OF_TILE]; 3]; MAX_OTHERS],
    pub mean: [[[T; LANES_OF_TILE]; 3]; MAX_OTHERS],
    /// Distances \[m\] to keep, 0 for none.
    pub least: [[T; LANES_OF_TILE]; MAX_OTHERS],
    pub w: [[T; LANES_OF_TILE]; MAX_OTHERS],
    pub friction: [[T; LANES_OF_TILE]; MAX_OTHERS],
}

/// Searches the shadows of other cloths for what the particles of a cloth, whose own shadow is at `own`, may meet. Returns the cloths that
/// are asleep and wake.
pub fn run<T: Real>(meeting: &mut Meeting<T>, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<usize> {
    meeting.others.clear();
    meeting.other_of.clear();
    meeting.other_of.resize(meeting.tiles.count(), u32::MAX);
    let Some(Some(shadow)) = shadows.get(own) else { return Vec::new() };
    let mut struck = vec![false; shadows.len()];
    let mut pairs: Vec<[u32; 3]> = Vec::new();
    for (n, other) in shadows.iter().enumerate().filter(|(n, _)| *n != own) {
        let Some(other) = other else { continue };
        pairs.extend(between(&shadow.tree, &other.tree).into_iter().map(|[a, b]| [a, n as u32, b]));
    }
    pairs.sort_unstable();
    for pairs in pairs.chunk_by(|a, b| a[0] == b[0]) {
        let tile = pairs[0][0] as usize;
        let mut best = [(0, [None; MAX_OTHERS]); LANES_OF_TILE];
        for [_, n, b] in pairs {
            if let Some(other) = &shadows[*n as usize] {
                let (from, struck) = (*b as usize * LANES_OF_TILE, &mut struck[*n as usize]);
                let patrol = meeting.patrol.as_mut().filter(|patrol| patrol.has(tile));
                widest(Search { best: &mut best, struck, patrol, shadow, tile, other: (*n, other), from });
            }
        }
        if let Some(list) = listed(&best) {
            meeting.other_of[tile] = meeting.others.len() as u32;
            meeting.others.push(list);
        }
    }
    (0..struck.len()).filter(|n| struck[*n]).collect()
}

/// Takes in where those that were found are now, and how they move.
pub fn follow<T: Real>(meeting: &mut Meeting<T>, shadows: &[Option<Shadow<T>>], own: usize) {
    let Some(Some(shadow)) = shadows.get(own) else { return };
    for (tile, index) in meeting.other_of.iter().enumerate().filter(|(_, index)| **index != u32::MAX) {
        let list = &mut meeting.others[*index as usize];
        for slot in 0..list.count {
            for lane in 0..LANES_OF_TILE {
                let [n, from] = list.from[slot][lane];
                let Some(Some(other)) = shadows.get(n as usize) else { continue };
                let (place, from) = (tile * LANES_OF_TILE + lane, from as usize);
                let (at, velocity) = (Tiles::at(&other.now, from), other.velocity_at(from));
                let mean = mean((shadow, place), (other, from));
                for c in 0..3 {
                    list.at[slot][c][lane] = at[c];
                    list.velocity[slot][c][lane] = velocity[c];
                    list.mean[slot][c][lane] = mean[c];
                }
            }
        }
    }
}

/// The velocity \[m/s\] that two particles have after an inelastic impact.
fn mean<T: Real>((shadow, place): (&Shadow<T>, usize), (other, from): (&Shadow<T>, usize)) -> V3<T> {
    let (own, velocity) = (shadow.velocity_at(place), other.velocity_at(from));
    let (w, w_other) = (shadow.w[place], other.w[from]);
    scale(add(scale(own, w_other), scale(velocity, w)), T::of(1.0) / (w + w_other))
}

type Best<T> = [(usize, [Option<Other<T>>; MAX_OTHERS]); LANES_OF_TILE];

/// The vectors of the particles that were found, if any.
fn listed<T: Real>(best: &Best<T>) -> Option<OtherList<T>> {
    let count = best.iter().map(|b| b.0).max().filter(|count| *count > 0)?;
    let (vectors, numbers) =
        ([[[T::of(0.0); LANES_OF_TILE]; 3]; MAX_OTHERS], [[T::of(0.0); LANES_OF_TILE]; MAX_OTHERS]);
    let mut list = OtherList {
        count,
        from: [[[u32::MAX; 2]; LANES_OF_TILE]; MAX_OTHERS],
        at: vectors,
        velocity: vectors,
        mean: vectors,
        least: numbers,
        w: numbers,
        friction: numbers,
    };
    for (lane, (_, others)) in best.iter().enumerate() {
        for (slot, other) in others.iter().enumerate() {
            let Some(other) = other else { continue };
            for c in 0..3 {
                list.at[slot][c][lane] = other.at[c];
                list.velocity[slot][c][lane] = other.velocity[c];
                list.mean[slot][c][lane] = other.mean[c];
            }
            list.from[slot][lane] = other.from;
            list.least[slot][lane] = other.least;
            list.w[slot][lane] = other.w;
            list.friction[slot][lane] = other.friction;
        }
    }
    Some(list)
}

/// The comparison of two tiles.
struct Search<'a, 'b, T: Real> {
    best: &'b mut Best<T>,
    /// Whether the other cloth, which is asleep, is woken.
    struck: &'b mut bool,
    /// Of tiles at which cloth is looked for that crosses.
    patrol: Option<&'b mut Patrol>,
    shadow: &'a Shadow<T>,
    tile: usize,
    /// Its number among all, and the other shadow.
    other: (u32, &'a Shadow<T>),
    from: usize,
}

impl<T: Real> Work<T> for Search<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Search { best, struck, mut patrol, shadow, tile, other: (number, other), from } = self;
        let zero = k.splat(T::of(0.0));
        let (length, tiny) = (k.splat(shadow.length), k.splat(T::of(1e-20)));
        let reach = (shadow.distance + other.distance) * T::of(WIDTH);
        let far = reach * reach;
        let longest = |of: &Shadow<T>, tile: usize| {
            let first = tile * LANES_OF_TILE;
            crossing2(of.crossing2[tile], &of.out[first..first + LANES_OF_TILE], |lane| {
                Tiles::at(&of.now, first + lane)
            })
        };
        let crossing =
            if patrol.is_some() { longest(shadow, tile).max(longest(other, from / LANES_OF_TILE)) } else { T::of(0.0) };
        for (lane, best) in best.iter_mut().enumerate() {
            let mine = tile * LANES_OF_TILE + lane;
            if shadow.w[mine] <= T::of(0.0) {
                continue;
            }
            let (at, way) = (Tiles::at(&shadow.now, mine), scale(shadow.velocity_at(mine), shadow.length));
            let (end, wide, node) =
                (add(at, way), shadow.distance * T::of(WIDTH), &other.tree.nodes[from / LANES_OF_TILE]);
            let misses = |c: usize| at[c].max(end[c]) + wide < node.low[c] || at[c].min(end[c]) - wide > node.high[c];
            if (0..3).any(misses) {
                continue;
            }
            let own = k.splats(at);
            let moves = k.splats(shadow.velocity_at(mine));
            for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
                let (at, velocity, place) = (&other.now, &other.velocity, from + at);
                let way = k.minus([k.load(&at[0], place), k.load(&at[1], place), k.load(&at[2], place)], own);
                let [x, y, z] = velocity;
                let speed = k.minus([k.load(x, place), k.load(y, place), k.load(z, place)], moves);
                // When they are nearest, if they go on as they do.
                let time = k.div(k.sub(zero, k.dot(way, speed)), k.most(k.squares(speed), tiny));
                let time = k.least(k.most(time, zero), length);
                let near = k.squares(k.plus(way, k.times(speed, time)));
                let near = k.add(near, k.load(&other.out, place));
                if !k.any(k.above(k.splat(far), near)) {
                    continue;
                }
                let mut each = [T::of(0.0); LANES];
                k.store(&mut each, 0, near);
                for (n, near) in each[..K::WIDE].iter().enumerate() {
                    if let Some(patrol) = patrol.as_mut().filter(|_| *near < crossing) {
                        let (place, there) = (mine as u32, (place + n) as u32);
                        patrol.suspect(Suspect { place, cloth: Some(number), other: there });
                    }
                    let passes = is_loose(&shadow.loose, mine) && is_loose(&other.loose, place + n);
                    if *near < far && !passes {
                        *struck |= wakes((shadow, mine), (other, place + n), *near);
                        take(best, (shadow, mine), (number, other, place + n), *near);
                    }
                }
            }
        }
    }
}

/// The distance \[m\] that two particles keep.
fn least<T: Real>((shadow, place): (&Shadow<T>, usize), (other, from): (&Shadow<T>, usize)) -> T {
    let whole = (shadow.distance + other.distance) * T::of(0.5);
    // Where cloths cross at rest, their distance there says nothing about the one to keep.
    let crossed = |shadow: &Shadow<T>, place: usize| shadow.crossed.get(place).is_some_and(|crossed| *crossed);
    if crossed(shadow, place) && crossed(other, from) {
        return whole;
    }
    let way = sub(Tiles::at(&other.rest, from), Tiles::at(&shadow.rest, place));
    whole.min(dot(way, way).sqrt() * T::of(REST_SHARE))
}

/// Whether a particle touches cloth that is asleep, and moves so fast that this wakes.
fn wakes<T: Real>(own: (&Shadow<T>, usize), (other, from): (&Shadow<T>, usize), near: T) -> bool {
    let (velocity, least) = (own.0.velocity_at(own.1), least(own, (other, from)));
    dot(velocity, velocity) > other.wakes_at * other.wakes_at && near < least * least
}

/// Takes in a particle if it is among the nearest; of those equally near the one that comes first.
fn take<T: Real>(
    (count, best): &mut (usize, [Option<Other<T>>; MAX_OTHERS]),
    (shadow, place): (&Shadow<T>, usize),
    (number, other, from): (u32, &Shadow<T>, usize),
    near: T,
) {
    let later = |o: &Option<Other<T>>| o.is_none_or(|o| o.near > near);
    let Some(at) = best.iter().position(later) else { return };
    best.copy_within(at..MAX_OTHERS - 1, at + 1);
    best[at] = Some(Other {
        near,
        from: [number, from as u32],
        at: Tiles::at(&other.now, from),
        velocity: other.velocity_at(from),
        mean: mean((shadow, place), (other, from)),
        least: least((shadow, place), (other, from)),
        w: other.w[from],
        friction: (shadow.friction + other.friction) * T::of(0.5),
    });
    *count = (*count + 1).min(MAX_OTHERS);
}
