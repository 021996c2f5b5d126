//! Fabric of one layer in a shell: parts that no sheet faces, far from the sheet that stays.
//!
//! They are neither an inner sheet nor a rim, and would be lost with these.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::DisjointSets;

use super::sides::Sides;
use super::zone::Zone;
use crate::base::closest::Closest;
use crate::base::stray::{diagonal, widen};
use crate::stage::component::ALWAYS_PIECE;

/// A part has at least this share of the area of the sheet that stays, so that wide rims are none, as [`ALWAYS_PIECE`] has it.
const LARGE: f64 = ALWAYS_PIECE;
/// It reaches farther from that sheet than this share of the diagonal of the box around it.
const FAR: f64 = 0.05;
/// It begins where triangles reach farther than this multiple of the thickness, which rims do not.
const BESIDE: f64 = 2.0;

/// Those of the triangles `dropped` that stay as they are, ascending. `kept` are the triangles of the sheet that stays, `thickness` is the
/// distance \[m\] of the sheets that 95 % of the area lie below. O(n log n).
pub(super) fn alone(
    zone: &Zone,
    sides: &Sides,
    positions: &[[f64; 3]],
    kept: &[u32],
    dropped: &[u32],
    thickness: f64,
) -> Vec<u32> {
    let corners = |list: &[u32]| list.iter().map(|&t| zone.triangles[t as usize]).collect::<Vec<_>>();
    let of_kept = corners(kept);
    let used: BTreeSet<u32> = corners(dropped).into_iter().flatten().collect();
    let used: Vec<u32> = used.into_iter().collect();
    let points: Vec<[f64; 3]> = used.iter().map(|&v| positions[v as usize]).collect();
    let near = Closest::new(positions, &of_kept).project_all(&points);
    let away = |v: u32| {
        let found = used.binary_search(&v).ok().and_then(|k| near[k]);
        found.map_or(0.0, |near| near.distance)
    };
    let reach = |t: u32| zone.triangles[t as usize].map(away).into_iter().fold(0.0, f64::max);
    let mut bounds = None;
    of_kept.iter().flatten().for_each(|&v| widen(&mut bounds, positions[v as usize]));
    let far = (FAR * bounds.map_or(0.0, diagonal)).max(BESIDE * thickness);
    let mut reaches = vec![0.0; zone.triangles.len()];
    dropped.iter().for_each(|&t| reaches[t as usize] = reach(t));
    let is_beside = |t: u32| reaches[t as usize] > BESIDE * thickness && zone.gap[t as usize].is_infinite();
    let mut parts = DisjointSets::new(zone.triangles.len());
    for [a, b] in sides.edges.iter().map(|e| e.triangles) {
        if is_beside(a) && is_beside(b) {
            parts.union(a, b);
        }
    }
    let mut sizes: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for &t in dropped.iter().filter(|t| is_beside(**t)) {
        let (area, farthest) = sizes.entry(parts.find(t)).or_default();
        (*area, *farthest) = (*area + zone.area[t as usize], farthest.max(reaches[t as usize]));
    }
    let least = LARGE * kept.iter().map(|&t| zone.area[t as usize]).sum::<f64>();
    sizes.retain(|_, (area, farthest)| *area >= least && *farthest > far);
    dropped.iter().copied().filter(|&t| is_beside(t) && sizes.contains_key(&parts.find(t))).collect()
}
