//! Parts of the sheet that stays: those that would fall apart without rims, and doubled fabric, which lies over another part.
//!
//! A hem that is turned over, a facing or a binding has sheets of its own behind those of the garment. They count as one of both sheets where the
//! fabric turns, and hang on the rest by the rim alone.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::DisjointSets;

use super::sides::Sides;
use super::zone::Zone;
use crate::base::closest::Closest;
use crate::base::vec3::{add, scale};

/// Share of the area that stays from which a part of it is large.
const LARGE: f64 = 0.05;
/// A part is doubled if this share of its area is near another one, within this multiple of the thickness that most of the fabric has: the fabric
/// of both, and a layer between.
const DOUBLED: f64 = 0.9;
const NEAR: f64 = 6.0;

/// The triangles of doubled fabric, ascending, so that not more large parts are left of `stay` than it had components; none if more are. Triangles
/// that stay are joined across edges. `thickness` is the distance \[m\] of the sheets that 95 % of the area lie below. O(n log n).
pub(super) fn doubled(
    zone: &Zone,
    sides: &Sides,
    positions: &[[f64; 3]],
    stay: &BTreeSet<u32>,
    thickness: f64,
) -> Option<Vec<u32>> {
    let mut joined = DisjointSets::new(zone.triangles.len());
    for [a, b] in sides.edges.iter().map(|e| e.triangles).filter(|e| e.iter().all(|t| stay.contains(t))) {
        joined.union(a, b);
    }
    let mut parts: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    stay.iter().for_each(|&t| parts.entry(joined.find(t)).or_default().push(t));
    let area = |part: &[u32]| part.iter().map(|&t| zone.area[t as usize]).sum::<f64>();
    let least = LARGE * stay.iter().map(|&t| zone.area[t as usize]).sum::<f64>();
    let mut large: Vec<(f64, Vec<u32>)> = parts.into_values().map(|part| (area(&part), part)).collect();
    large.retain(|(area, _)| *area > least);
    // Of equally large ones the one with the lowest triangle is first.
    large.sort_by(|a, b| b.0.total_cmp(&a.0));
    let components = stay.iter().map(|&t| zone.component[t as usize]).collect::<BTreeSet<u32>>().len();
    let mut over = Vec::new();
    let mut left: Vec<[u32; 3]> = Vec::new();
    let mut count = 0;
    for (all, part) in large {
        if count >= components {
            let near = near(zone, positions, &part, &Closest::new(positions, &left), NEAR * thickness);
            if area(&near) < DOUBLED * all {
                return None;
            }
            over.extend(part);
        } else {
            left.extend(part.iter().map(|&t| zone.triangles[t as usize]));
            count += 1;
        }
    }
    over.sort_unstable();
    Some(over)
}

/// The triangles whose middles are within `reach` \[m\] of a surface.
fn near(zone: &Zone, positions: &[[f64; 3]], part: &[u32], surface: &Closest, reach: f64) -> Vec<u32> {
    let middle = |t: &u32| {
        let [a, b, c] = zone.triangles[*t as usize].map(|v| positions[v as usize]);
        scale(add(a, add(b, c)), 1.0 / 3.0)
    };
    let middles: Vec<[f64; 3]> = part.iter().map(middle).collect();
    let found = surface.project_all(&middles).into_iter().zip(part);
    found.filter_map(|(near, t)| near.filter(|near| near.distance <= reach).map(|_| *t)).collect()
}
