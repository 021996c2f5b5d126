//! Twin of shaders/others.wgsl: particles of other cloths that those of a cloth may meet in some steps. They go on as they moved when the
//! search began: each cloth steps by itself, and both sides of a pair take their share.

mod nearest;
mod search;
#[cfg(test)]
mod tests;

use self::nearest::Nearest;
use self::search::Search;
use super::Meeting;
use super::shadow::Shadow;
use super::tiles::{LANES_OF_TILE, Tiles};
use crate::cpu::fabric::partners::REST_SHARE;
use crate::cpu::fabric::tile_pairs::between;
use crate::number::lanes::widest;
use crate::number::real::{Real, V3, add, dot, scale, sub, xyz};

/// Particles of other cloths for each particle: the nearest ones.
pub const MAX_OTHERS: usize = 4;

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
    for pairs in pairs_of(shadow, shadows, own).chunk_by(|a, b| a.tile == b.tile) {
        let tile = pairs[0].tile as usize;
        let mut best = [Nearest::none(); LANES_OF_TILE];
        let patrol = meeting.patrol.as_mut().filter(|patrol| patrol.has(tile));
        widest(Search { best: &mut best, struck: &mut struck, patrol, shadow, tile, pairs, shadows });
        if let Some(list) = listed(&best, (shadow, tile), shadows) {
            meeting.other_of[tile] = meeting.others.len() as u32;
            meeting.others.push(list);
        }
    }
    (0..struck.len()).filter(|n| struck[*n]).collect()
}

/// A tile of a cloth, and a tile of another one that it may meet: in the order in which they are compared.
#[derive(Clone, Copy)]
struct Pair {
    tile: u32,
    /// The shadow among all, and its tile.
    cloth: u32,
    other: u32,
}

/// All of them for the cloth whose shadow, at `own`, is this.
fn pairs_of<T: Real>(shadow: &Shadow<T>, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for (n, other) in shadows.iter().enumerate().filter(|(n, _)| *n != own) {
        let Some(other) = other else { continue };
        let each = between(&shadow.tree, &other.tree).into_iter();
        pairs.extend(each.map(|[tile, other]| Pair { tile, cloth: n as u32, other }));
    }
    // As one number, which is compared at once.
    let key = |p: &Pair| u128::from(p.tile) << 64 | u128::from(p.cloth) << 32 | u128::from(p.other);
    pairs.sort_unstable_by_key(key);
    pairs
}

/// Takes in where those that were found are now, and how they move.
pub fn follow<T: Real>(meeting: &mut Meeting<T>, shadows: &[Option<Shadow<T>>], own: usize) {
    let Some(Some(shadow)) = shadows.get(own) else { return };
    for (tile, index) in meeting.other_of.iter().enumerate().filter(|(_, index)| **index != u32::MAX) {
        let list = &mut meeting.others[*index as usize];
        for slot in 0..list.count {
            for lane in 0..LANES_OF_TILE {
                list.follow(slot, lane, (shadow, tile * LANES_OF_TILE + lane), shadows);
            }
        }
    }
}

impl<T: Real> OtherList<T> {
    fn none(count: usize) -> Self {
        let zeros = [T::of(0.0); LANES_OF_TILE];
        let (vectors, numbers) = ([[zeros; 3]; MAX_OTHERS], [zeros; MAX_OTHERS]);
        OtherList {
            count,
            from: [[[u32::MAX; 2]; LANES_OF_TILE]; MAX_OTHERS],
            at: vectors,
            velocity: vectors,
            mean: vectors,
            least: numbers,
            w: numbers,
            friction: numbers,
        }
    }

    /// Takes in where the particle of a slot is, and how it moves, for the particle at a place of `shadow`.
    #[inline(always)]
    fn follow(
        &mut self,
        slot: usize,
        lane: usize,
        (shadow, place): (&Shadow<T>, usize),
        shadows: &[Option<Shadow<T>>],
    ) {
        let [n, from] = self.from[slot][lane];
        let Some(Some(other)) = shadows.get(n as usize) else { return };
        let (from, [own, moves]) = (from as usize, shadow.each[place]);
        let [at, velocity] = other.each[from];
        let mean = mean([own[3], at[3]], [xyz(moves), xyz(velocity)]);
        for c in 0..3 {
            self.at[slot][c][lane] = at[c];
            self.velocity[slot][c][lane] = velocity[c];
            self.mean[slot][c][lane] = mean[c];
        }
    }
}

/// The velocity \[m/s\] that two particles of these inverse masses and velocities have after an inelastic impact.
#[inline(always)]
fn mean<T: Real>([w, w_other]: [T; 2], [own, velocity]: [V3<T>; 2]) -> V3<T> {
    scale(add(scale(own, w_other), scale(velocity, w)), T::of(1.0) / (w + w_other))
}

/// The vectors of the particles that were found for a tile of `shadow`, if any.
fn listed<T: Real>(
    best: &[Nearest<T>; LANES_OF_TILE],
    (shadow, tile): (&Shadow<T>, usize),
    shadows: &[Option<Shadow<T>>],
) -> Option<OtherList<T>> {
    let count = best.iter().map(|b| b.count).max().filter(|count| *count > 0)?;
    let mut list = OtherList::none(count);
    for (lane, best) in best.iter().enumerate() {
        let own = (shadow, tile * LANES_OF_TILE + lane);
        for (slot, [n, from]) in best.from[..best.count].iter().enumerate() {
            let Some(Some(other)) = shadows.get(*n as usize) else { continue };
            list.from[slot][lane] = [*n, *from];
            list.follow(slot, lane, own, shadows);
            list.least[slot][lane] = least(own, (other, *from as usize));
            list.w[slot][lane] = other.w[*from as usize];
            list.friction[slot][lane] = (shadow.friction + other.friction) * T::of(0.5);
        }
    }
    Some(list)
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
