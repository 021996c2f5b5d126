//! Twin of shaders/paths.wgsl: how far particles want to go in a round, and boxes around the cells wherever their particles may be then.

use super::even::{Spread, is_even};
use super::{Ball, Lists, NOBODY, Patch, TILE};
use crate::levels::safe::{ASIDE, FLOOR_SHARE, MAX_WAY, ROUNDING};
use crate::number::real::{Real, V3, add, dot, scale, sub, with_w, xyz};

/// Begins a round.
pub fn run<T: Real>(lists: &mut Lists<T>) {
    for g in 0..lists.grids() {
        let patch = lists.patch(g);
        for k in patch.first..patch.first + patch.width * patch.height {
            if lists.point(k) == NOBODY {
                continue;
            }
            let (place, goal) = (xyz(lists.places[k]), lists.goals[k]);
            let (way, free) = (sub(xyz(goal), place), goal[3] > T::of(0.0));
            let (far, most) = (dot(way, way).sqrt(), patch.spacing * T::of(MAX_WAY));
            let share = if far > most && free { most / far } else { T::of(1.0) };
            let rounding = largest(place).max(largest(way)) * T::of(ROUNDING);
            let aside = if free { patch.spacing * T::of(ASIDE) } else { T::of(0.0) };
            lists.bases[k] = with_w(place, T::of(0.500005) * share * far + aside + rounding);
            lists.ways[k] = with_w(scale(way, share), goal[3]);
        }
    }
    for tile in 0..lists.tiles() {
        bound(lists, tile);
    }
}

/// Makes the box of a tile, of its cells, and its spread.
fn bound<T: Real>(lists: &mut Lists<T>, tile: usize) {
    let (patch, [left, top]) = lists.spot(tile);
    let far = T::of(f64::from(f32::MAX));
    let mut all = [[far; 3], [-far; 3]];
    let mut spread = Spread::none();
    for lane in 0..TILE {
        let at = [left + lane % 4, top + lane / 4];
        let there = patch.spacing > T::of(0.0) && at[0] < patch.width && at[1] < patch.height;
        let (mut low, mut high, mut bits) = ([far; 3], [-far; 3], 0u32);
        if there {
            let k = patch.at(at);
            let floor = floor_of(lists, &patch, k);
            let inner = at[0] > 0 && at[1] > 0 && at[0] + 1 < patch.width && at[1] + 1 < patch.height;
            let whole =
                inner && (0..9).all(|n| lists.point(k + n / 3 * patch.width + n % 3 - patch.width - 1) != NOBODY);
            let ball = |n: usize| lists.ball(k + n / 3 * patch.width + n % 3 - patch.width - 1);
            let even = whole && is_even(&std::array::from_fn(ball), floor);
            bits = lists.faces[k] | u32::from(even) << 20;
            spread.even &= even || !inner;
            if at[0] + 1 < patch.width && at[1] + 1 < patch.height {
                let corners = patch.corners(at);
                for k in corners.into_iter().filter(|k| bits & 3 > 0 && lists.point(*k) != NOBODY) {
                    let Ball { center, radius } = lists.ball(k);
                    for c in 0..3 {
                        low[c] = low[c].min(center[c] - radius - floor);
                        high[c] = high[c].max(center[c] + radius + floor);
                    }
                }
                if bits & 3 == 3 {
                    spread = spread.with(&Spread::of(&corners.map(|k| lists.ball(k))));
                } else {
                    spread.even = false;
                }
            }
        }
        let cell = lists.cell(tile * TILE + lane);
        // The bits of features lie where shaders have them.
        lists.boxes[cell] = with_w(low, T::of(f64::from(bits)));
        lists.boxes[cell + 1] = with_w(high, T::of(0.0));
        for c in 0..3 {
            (all[0][c], all[1][c]) = (all[0][c].min(low[c]), all[1][c].max(high[c]));
        }
    }
    let at = lists.spread(tile);
    let even = T::of(f64::from(u8::from(spread.even)));
    let rows = [with_w(spread.right[0], spread.reach), with_w(spread.right[1], even)];
    lists.boxes[at..at + 2].copy_from_slice(&rows);
    let rows = [with_w(spread.down[0], T::of(0.0)), with_w(spread.down[1], T::of(0.0))];
    lists.boxes[at + 2..at + 4].copy_from_slice(&rows);
    lists.boxes[2 * tile] = with_w(all[0], T::of(0.0));
    lists.boxes[2 * tile + 1] = with_w(all[1], T::of(0.0));
}

/// The largest coordinate.
pub fn largest<T: Real>(v: V3<T>) -> T {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// The least gap \[m\] of features at a particle, with room for the rounding of positions.
pub fn floor_of<T: Real>(lists: &Lists<T>, patch: &Patch<T>, k: usize) -> T {
    (patch.spacing * T::of(FLOOR_SHARE)).max(largest(xyz(lists.bases[k])) * T::of(8.0 * ROUNDING))
}

/// Where a particle wants to be at the end of a round, and whether the step takes it farther.
pub fn end_of<T: Real>(lists: &Lists<T>, k: usize) -> ([T; 3], bool) {
    let (base, way, goal) = (xyz(lists.bases[k]), xyz(lists.ways[k]), xyz(lists.goals[k]));
    let all = sub(goal, base);
    let clamped = dot(all, all) > dot(way, way) * T::of(1.0001);
    if clamped { (add(base, way), true) } else { (goal, false) }
}
