//! Where cloth is so even that no two of its features that are near on the surface can come into contact.
//!
//! The four cells around a texel, a block, are seen along their normal. Two coordinates in the plane of the block are 1 longer per column, and
//! per row. As functions of column and row they have a derivative in each triangle, whose columns are those of an edge along a row and of one
//! along a column. Where the symmetric part of all of them is positive, two places that differ in column and row differ in their coordinates,
//! by at least the least eigenvalue times as much: the block does not cross itself. That holds at all times between two at which it does, as
//! edges change evenly.

use std::ops::Range;

use super::drift::Way;
use super::pairs::CellPair;
use super::surface::{Patch, Surface};
use crate::memory::Tally;
use crate::number::lanes::{LANES, Machine, Work, widest};

/// Least square of the area of a cell, over the product of those of its edges: slivers are not even.
const MIN_AREA2: f32 = 1e-3;
/// By how much both columns of a derivative change, over the change of a point: an edge has two of these.
const CHANGE: f32 = 2.0 * 1.4143;
/// Least distance of features without a common point in columns and rows.
const APART: f32 = 0.7;
/// Room for rounding of derivatives.
const ROUNDING: f32 = 1e-3;

/// A part of a patch.
pub struct Part {
    pub patch: Patch,
    pub columns: Range<usize>,
    pub rows: Range<usize>,
}

/// The ways of the points of texels: where they begin, how they go on, and their reach, each \[m\]; NaN for gaps.
#[derive(Default)]
pub struct Ways {
    lists: [Vec<f32>; 7],
}

impl Ways {
    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        self.lists.iter().for_each(|list| tally.state(list));
    }

    /// Those of texels, row by row.
    pub fn fill(&mut self, ways: impl Iterator<Item = Way>) {
        self.lists.iter_mut().for_each(Vec::clear);
        for way in ways {
            for c in 0..3 {
                self.lists[c].push(way.from[c] as f32);
                self.lists[3 + c].push((way.to[c] - way.from[c]) as f32);
            }
            self.lists[6].push(way.reach as f32);
        }
        // Vectors are read past the last texel.
        self.lists.iter_mut().for_each(|list| list.extend([f32::NAN; LANES]));
    }

    /// Finds the even blocks around the inner texels of a part, whose ways these are, and a least gap \[m\].
    pub fn find_even(&self, part: &Part, floor: f32, even: &mut [bool]) {
        let (width, height) = (part.columns.len(), part.rows.len());
        for j in 1..height.saturating_sub(1) {
            for i in (1..width.saturating_sub(1)).step_by(LANES) {
                let count = LANES.min(width - 1 - i);
                let mut found = [0.0; LANES];
                widest(Blocks { ways: self, first: (j - 1) * width + i - 1, width, floor, found: &mut found });
                let row = part.patch.first + (part.rows.start + j) * part.patch.width;
                let even = &mut even[row + part.columns.start + i..][..count];
                even.iter_mut().zip(&found).for_each(|(even, found)| *even = *found > 0.0);
            }
        }
    }
}

/// A vector of blocks, from that whose upper left texel is `first` on.
struct Blocks<'a> {
    ways: &'a Ways,
    first: usize,
    width: usize,
    floor: f32,
    /// 1 for even ones.
    found: &'a mut [f32; LANES],
}

impl Work<f32> for Blocks<'_> {
    #[inline(always)]
    fn run<K: Machine<f32>>(self, k: K) {
        let lists = &self.ways.lists;
        let (zero, half, quarter) = (k.splat(0.0), k.splat(0.5), k.splat(0.25));
        // Lanes past the last inner column are not used, whatever is read for them.
        for lane in (0..LANES).step_by(K::WIDE) {
            let (mut from, mut way, mut reach) = ([[zero; 3]; 9], [[zero; 3]; 9], zero);
            for n in 0..9 {
                let at = (self.first + lane + n / 3 * self.width + n % 3).min(lists[0].len() - LANES);
                from[n] = [k.load(&lists[0], at), k.load(&lists[1], at), k.load(&lists[2], at)];
                way[n] = [k.load(&lists[3], at), k.load(&lists[4], at), k.load(&lists[5], at)];
                reach = k.most(reach, k.load(&lists[6], at));
            }
            let (center, drift) = (from[4], way[4]);
            for n in 0..9 {
                (from[n], way[n]) = (k.minus(from[n], center), k.minus(way[n], drift));
            }
            // The plane is that of the middle of the way, so that a block that turns looks alike at both ends.
            let across = k.plus(k.minus(from[5], from[3]), k.times(k.minus(way[5], way[3]), half));
            let along = k.plus(k.minus(from[7], from[1]), k.times(k.minus(way[7], way[1]), half));
            let (right, down) = (k.times(across, half), k.times(along, half));
            let (rr, rd, dd) = (k.squares(right), k.dot(right, down), k.squares(down));
            let (edges2, area2) = (k.mul(rr, dd), k.sub(k.mul(rr, dd), k.mul(rd, rd)));
            let mut even = k.above(area2, k.mul(edges2, k.splat(MIN_AREA2)));
            let u = k.minus(k.times(right, k.div(dd, area2)), k.times(down, k.div(rd, area2)));
            let v = k.minus(k.times(down, k.div(rr, area2)), k.times(right, k.div(rd, area2)));
            let (uu, uv, vv) = (k.squares(u), k.dot(u, v), k.squares(v));
            // The most that both coordinates together differ by, per distance.
            let apart = k.sub(uu, vv);
            let root = k.sqrt(k.add(k.mul(quarter, k.mul(apart, apart)), k.mul(uv, uv)));
            let most = k.sqrt(k.add(k.mul(half, k.add(uu, vv)), root));
            let off = k.add(k.mul(k.splat(CHANGE), reach), k.splat(self.floor / APART));
            let need = k.add(k.mul(most, off), k.splat(ROUNDING));
            for _ in 0..2 {
                let mut at = [[zero; 2]; 9];
                for n in 0..9 {
                    at[n] = [k.dot(u, from[n]), k.dot(v, from[n])];
                }
                for n in [0, 1, 3, 4] {
                    let rights = [[n, n + 1], [n + 3, n + 4]];
                    let downs = [[n, n + 3], [n + 1, n + 4]];
                    // Whichever way the diagonal of the cell goes.
                    for [p, q] in rights {
                        for [r, s] in downs {
                            let (a, b) = (k.sub(at[q][0], at[p][0]), k.sub(at[q][1], at[p][1]));
                            let (c, d) = (k.sub(at[s][0], at[r][0]), k.sub(at[s][1], at[r][1]));
                            let mean = k.sub(k.mul(half, k.add(a, d)), need);
                            let (wide, skew) = (k.sub(a, d), k.add(b, c));
                            let rest = k.mul(quarter, k.add(k.mul(wide, wide), k.mul(skew, skew)));
                            let stays = k.both(k.above(mean, zero), k.above(k.mul(mean, mean), rest));
                            even = k.both(even, stays);
                        }
                    }
                }
                for n in 0..9 {
                    from[n] = k.plus(from[n], way[n]);
                }
            }
            k.store(self.found, lane, k.choose(even, k.splat(1.0), zero));
        }
    }
}

/// Whether two cells lie in an even block.
pub fn is_apart(surface: &Surface, even: &[bool], pair: &CellPair) -> bool {
    let patch = &surface.patches[pair.patch];
    let near = pair.apart.and_then(|apart| shared(patch, pair.spot, apart));
    near.is_some_and(|[i, j]| even[patch.first + j * patch.width + i])
}

/// The texel in whose block two cells lie that are at most one column and one row apart; none in grids of less than three rows or columns.
fn shared(patch: &Patch, [i, j]: [usize; 2], [right, down]: [isize; 2]) -> Option<[usize; 2]> {
    let along = |at: usize, step: isize, count: usize| {
        // The line of texels between both, or one beside a single one.
        let line = if step < 0 { at } else { at + 1 };
        let line = if step == 0 { line.min(count.saturating_sub(2)) } else { line };
        (count > 2 && (1..count - 1).contains(&line)).then_some(line)
    };
    (right.abs() <= 1 && down.abs() <= 1).then_some(())?;
    Some([along(i, right, patch.width)?, along(j, down, patch.height)?])
}
