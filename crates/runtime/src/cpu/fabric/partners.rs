//! Twin of shaders/partners.wgsl: for each particle the nearest others that it may meet before the next search.
//!
//! Here pairs of tiles are found first ([`Beside`]). Then one vector of particles at a time is compared with each particle
//! of the other tile.

use super::meeting::Meeting;
use super::meeting::loose::is_loose;
use super::meeting::tiles::{Block, LANES_OF_TILE, Tiles};
use super::tile_pairs::Beside;
use super::tree::Node;
use crate::cpu::rows::Threads;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, dot, sub};

/// Partners of a particle: the nearest ones.
pub const MAX_PARTNERS: usize = 8;

/// Share of their distance at rest that particles keep at least: cloth that is near itself at rest can be pressed a little.
pub const REST_SHARE: f64 = 0.9;

/// Farther \[m\] than anything.
const FARTHEST: f64 = 1e15;

/// The partners of the particles of a tile, and where these go.
#[derive(Clone, Copy)]
pub struct TileList<T> {
    /// The most partners of one of its particles.
    pub count: u32,
    /// Whether a particle of it is moved in this step.
    pub moves: bool,
    /// Rows of partners ([`Tiles::row`]), one vector after the other, the nearest first, each at the row of its particle; one without a
    /// partner has itself.
    pub partner: [u32; LANES_OF_TILE * MAX_PARTNERS],
    /// Distances \[m\] that they keep, likewise; 0 without a partner.
    pub least: [T; LANES_OF_TILE * MAX_PARTNERS],
    /// The particle's share of a push, likewise.
    pub own: [T; LANES_OF_TILE * MAX_PARTNERS],
    /// A bit for each vector that had a particle near its partner when it was last looked at.
    pub near: u32,
    /// For each vector how much farther \[m\] than that all of its particles were from their partners in the search.
    pub spare: [T; MAX_PARTNERS],
    /// How positions change, and previous ones: three vectors each.
    pub change: [[T; LANES_OF_TILE]; 6],
}

impl<T: Real> TileList<T> {
    fn none() -> Self {
        let (partner, least) = ([0; LANES_OF_TILE * MAX_PARTNERS], [T::of(0.0); LANES_OF_TILE * MAX_PARTNERS]);
        let (spare, change) = ([T::of(0.0); MAX_PARTNERS], [[T::of(0.0); LANES_OF_TILE]; 6]);
        TileList { count: 0, moves: false, partner, least, own: least, near: 0, spare, change }
    }
}

/// Searches the partners of all particles.
pub fn run<T: Real>(meeting: &mut Meeting<T>, threads: &Threads) {
    let count = meeting.tiles.count();
    let mut lists = std::mem::take(&mut meeting.lists);
    lists.resize_with(count, TileList::none);
    meeting.beside = Beside::new(&meeting.tree, count);
    let near: &Meeting<T> = meeting;
    threads.chunks(&mut lists, 16, |chunk, lists| {
        widest(Search { lists, first: 16 * chunk, meeting: near });
    });
    meeting.lists = lists;
    meeting.find_active();
}

/// The search for the particles of some tiles.
struct Search<'a, 'b, T: Real> {
    lists: &'b mut [TileList<T>],
    first: usize,
    meeting: &'a Meeting<T>,
}

impl<T: Real> Work<T> for Search<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Search { lists, first, meeting: Meeting { tiles, tree, distance, beside, .. } } = self;
        let wide = *distance * T::of(0.5);
        for (n, list) in lists.iter_mut().enumerate() {
            let tile = first + n;
            let mut best = [Best::none(); LANES_OF_TILE];
            for other in beside.of(tile) {
                let from = *other as usize * LANES_OF_TILE;
                let reach = tree.reach[tile] + tree.reach[*other as usize];
                let far = (*distance + reach) * (*distance + reach);
                let far_all = k.splat(far);
                let close = tiles.close(tile, *other as usize);
                let block = &tiles.blocks[*other as usize];
                let inside = inside(k, &tiles.blocks[tile], &tree.nodes[*other as usize], wide + tree.reach[tile]);
                for (lane, best) in best.iter_mut().enumerate().filter(|(lane, _)| inside[*lane] > T::of(0.0)) {
                    let place = tile * LANES_OF_TILE + lane;
                    let own = k.splats(tiles.now(place));
                    for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
                        let [x, y, z] = &block.now;
                        let there = [k.load(x, at), k.load(y, at), k.load(z, at)];
                        let apart = k.squares(k.minus(there, own));
                        let mut apart = k.add(apart, k.load(&tiles.out, from + at));
                        if let Some(close) = close {
                            apart = k.add(apart, k.load(&close[lane], at));
                        }
                        if !k.any(k.above(far_all, apart)) {
                            continue;
                        }
                        let mut each = [T::of(0.0); LANES];
                        k.store(&mut each, 0, apart);
                        for (n, apart) in each[..K::WIDE].iter().enumerate() {
                            if *apart < far {
                                best.consider(self.meeting, (place, from + at + n), (*apart, reach));
                            }
                        }
                    }
                }
            }
            write(list, &best, (tile, tiles));
        }
    }
}

/// For each particle of a tile its inverse mass, or 0 where it is farther than `wide` from a box. A particle that cannot move needs no
/// partner; gaps cannot.
#[inline(always)]
fn inside<T: Real, K: Machine<T>>(k: K, block: &Block<T>, node: &Node<T>, wide: T) -> [T; LANES_OF_TILE] {
    let (mut inside, wide) = (block.w, k.splat(wide));
    for at in (0..LANES_OF_TILE).step_by(K::WIDE) {
        for c in 0..3 {
            let p = k.load(&block.now[c], at);
            let (low, high) = (k.splat(node.low[c]), k.splat(node.high[c]));
            let within = k.both(k.at_least(k.add(p, wide), low), k.at_least(high, k.sub(p, wide)));
            let kept = k.choose(within, k.load(&inside, at), k.splat(T::of(0.0)));
            k.store(&mut inside, at, kept);
        }
    }
    inside
}

/// Partners of a particle so far, the nearest first; of those equally far the one with the lower place.
#[derive(Clone, Copy)]
struct Best<T> {
    count: usize,
    /// Square of the distance \[m^2\], place, and distance \[m\] to keep.
    list: [(T, u32, T); MAX_PARTNERS],
}

impl<T: Real> Best<T> {
    fn none() -> Self {
        Best { count: 0, list: [(T::of(0.0), 0, T::of(0.0)); MAX_PARTNERS] }
    }

    /// Takes in a particle if it is among the nearest.
    #[inline(never)]
    fn consider(&mut self, meeting: &Meeting<T>, (place, other): (usize, usize), (apart2, reach): (T, T)) {
        let new = (apart2, other as u32);
        let later = |(apart, place, _): &(T, u32, T)| (*apart, *place) > new;
        if self.count == MAX_PARTNERS && !later(&self.list[MAX_PARTNERS - 1]) {
            return;
        }
        let Some(least) = kept(meeting, place, other) else { return };
        if apart2.sqrt() >= least + reach {
            return;
        }
        let at = self.list[..self.count].iter().position(later).unwrap_or(self.count);
        self.count = (self.count + 1).min(MAX_PARTNERS);
        self.list.copy_within(at..self.count - 1, at + 1);
        self.list[at] = (apart2, other as u32, least);
    }
}

/// The distance that two particles keep; none if they are near on the surface, across a seam, or may pass one another.
fn kept<T: Real>(meeting: &Meeting<T>, place: usize, other: usize) -> Option<T> {
    let tiles = &meeting.tiles;
    if is_loose(&meeting.loose.own, place) && is_loose(&meeting.loose.own, other) {
        return None;
    }
    let kin = meeting.kin.of_particle(tiles.texel[place] as usize);
    if kin.binary_search(&tiles.texel[other]).is_ok() {
        return None;
    }
    let way = sub(Tiles::at(&tiles.rest, place), Tiles::at(&tiles.rest, other));
    Some(meeting.distance.min(dot(way, way).sqrt() * T::of(REST_SHARE)))
}

/// Partners in the order of their distances, so that the first ones of all particles are those that touch.
fn write<T: Real>(list: &mut TileList<T>, best: &[Best<T>; LANES_OF_TILE], (tile, tiles): (usize, &Tiles<T>)) {
    let w = |place: u32| tiles.blocks[place as usize / LANES_OF_TILE].w[place as usize % LANES_OF_TILE];
    let count = best.iter().map(|b| b.count).max().unwrap_or(0);
    (list.count, list.moves, list.near) = (count as u32, false, 0);
    list.spare = [T::of(FARTHEST); MAX_PARTNERS];
    for (lane, best) in best.iter().enumerate() {
        for n in 0..count {
            let (apart2, place, least) = best.list[n];
            let own = (tile * LANES_OF_TILE + lane) as u32;
            let there = n < best.count;
            let (place, least) = if there { (place, least) } else { (own, T::of(0.0)) };
            if there {
                list.spare[n] = list.spare[n].min(apart2.sqrt() - least * T::of(1.0 + 1e-5));
            }
            let at = n * LANES_OF_TILE + lane;
            list.partner[n * LANES_OF_TILE + tiles.lane_rows[lane]] = tiles.row(place);
            list.least[at] = least;
            list.own[at] = w(own) / (w(own) + w(place)).max(T::of(1e-12));
        }
    }
}
