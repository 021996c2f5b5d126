//! Garments that lie over others, such as a shirt over a waistband: near the pins of the lower one, and where the body is near, they stay in this order
//! without contact of cloth with cloth. Covered points have a limit, those that cover them a backstop, each of less than half the distance between both.
//!
//! Elsewhere layers are free: the lining of a skirt swings as the skirt does.

use std::ops::Range;

use rayon::prelude::*;

use super::rest::{NEAR, height};
use super::sheet::Sheet;
use super::wearer::Wearer;
use super::{Garment, Rule, spread};
use crate::base::closest::Closest;
use crate::base::vec3::{cross, distance, dot, normalize, scale, sub};

/// Share of the distance of two layers that each of them may go towards the other one: triangles between points need room, too.
const TOWARDS: f64 = 0.35;
/// Share of the area of the lower garment from which it counts as covered: a backstop is a pass of its own.
const WORTH_IT: f64 = 0.005;
/// Rounds in which points most of whose neighbours are layers become layers: creases leave holes.
const CLOSED: usize = 2;
/// Rings of points beyond the border of the lower layer that have a backstop too: it would cut through the triangles there.
const BEYOND: usize = 2;
/// The smallest limit, as a share of the height of the body.
const LEAST: f64 = 1e-4;
/// Smallest cosine of the angle between the normals of layers, and of that between a normal and the way to the other layer: beside a border this way leads
/// along the surface.
const ALIKE: f64 = 0.5;
const ACROSS: f64 = 0.7;

/// Finds the layers of all garments that a ring or shoulders hold: a pocket, which its edge holds, would nail the shirt beneath to the skin. O(n log n) in the points of garments that are near one another.
pub(super) fn run(wearer: &Wearer, garments: &mut [Garment]) {
    let is_worn = |rule: &Rule| matches!(rule, Rule::Ring | Rule::Shoulders);
    let faces = |g: &Garment| g.hold.rules.iter().any(is_worn) && faces_out(&g.sheet);
    let worn: Vec<usize> = (0..garments.len()).filter(|g| faces(&garments[*g])).collect();
    if worn.len() < 2 {
        return;
    }
    let surfaces: Vec<Surface> = worn.par_iter().map(|g| Surface::new(&garments[*g].sheet)).collect();
    for (lower, below) in worn.iter().zip(&surfaces) {
        let tall = height(wearer, garments[*lower].sheet.span());
        let near = NEAR * tall;
        let mut covered = vec![f64::INFINITY; garments[*lower].pinned.len()];
        let mut held: Option<Vec<bool>> = None;
        for (upper, above) in worn.iter().zip(&surfaces).filter(|(upper, _)| *upper != lower) {
            if !below.meets(above, near) {
                continue;
            }
            let held = held.get_or_insert_with(|| held_points(wearer, &garments[*lower], near));
            let gaps = above.gaps(&garments[*lower].sheet, (-1.0, near), |p| held[p], |_| true);
            let is_covered: Vec<bool> = gaps.iter().map(|gap| gap.is_finite()).collect();
            if spread::share(&garments[*lower].sheet, &is_covered) < WORTH_IT {
                continue;
            }
            // Cloth over points that are not held stays free.
            let is_held =
                |t: u32| garments[*lower].sheet.triangles[t as usize].iter().any(|p| gaps[*p as usize].is_finite());
            let mut over = below.gaps(&garments[*upper].sheet, (1.0, near), |_| true, is_held);
            for _ in 0..BEYOND {
                over = beyond(&garments[*upper].sheet, &over);
            }
            covered.iter_mut().zip(&gaps).for_each(|(all, gap)| *all = all.min(*gap));
            let Garment { behind, pinned, hold, .. } = &mut garments[*upper];
            bound(behind, pinned, &over, LEAST * tall);
            let name = hold.name.clone();
            garments[*lower].hold.over.push(name);
        }
        let lower = &mut garments[*lower];
        bound(&mut lower.limits, &lower.pinned, &covered, LEAST * tall);
        let is_covered: Vec<bool> = covered.iter().map(|gap| gap.is_finite()).collect();
        lower.hold.covered = spread::share(&lower.sheet, &is_covered);
    }
}

/// Shortens the ways \[m\] of points that are not pinned to their share of gaps, at least `least` \[m\].
fn bound(ways: &mut [f64], pinned: &[bool], gaps: &[f64], least: f64) {
    for ((way, pinned), gap) in ways.iter_mut().zip(pinned).zip(gaps) {
        if gap.is_finite() && !pinned {
            *way = way.min((TOWARDS * gap).max(least));
        }
    }
}

/// The points of a garment that limits may hold: near its pins, or near the body.
fn held_points(wearer: &Wearer, garment: &Garment, near: f64) -> Vec<bool> {
    let pins = (0..garment.pinned.len() as u32).filter(|p| garment.pinned[*p as usize]);
    let far = garment.sheet.distances(pins, garment.reach);
    let points = far.par_iter().zip(&garment.sheet.positions);
    points.map(|(far, p)| far.is_finite() || wearer.near(*p).0 <= near).collect()
}

/// Whether the normals of a garment point away from its middle, as backstops need them.
fn faces_out(sheet: &Sheet) -> bool {
    let total: f64 = sheet.areas.iter().sum();
    let middle = |c: usize| sheet.positions.iter().zip(&sheet.areas).map(|(p, area)| area * p[c]).sum::<f64>() / total;
    let middle = [0, 1, 2].map(middle);
    let each = sheet.positions.iter().zip(&sheet.normals).zip(&sheet.areas);
    each.map(|((p, n), area)| area * dot(*n, sub(*p, middle))).sum::<f64>() > 0.0
}

/// The surface of a garment, ready for queries.
struct Surface {
    closest: Closest,
    /// Unit normals of its triangles.
    normals: Vec<[f64; 3]>,
    /// The box around it \[m\].
    bounds: [Range<f64>; 3],
}

impl Surface {
    fn new(sheet: &Sheet) -> Self {
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|p| sheet.positions[p as usize]);
            normalize(cross(sub(b, a), sub(c, a)))
        };
        let range = |c: usize| {
            let each = || sheet.positions.iter().map(move |p| p[c]);
            each().fold(f64::INFINITY, f64::min)..each().fold(f64::NEG_INFINITY, f64::max)
        };
        Surface {
            closest: Closest::new(&sheet.positions, &sheet.triangles),
            normals: sheet.triangles.iter().map(normal).collect(),
            bounds: [0, 1, 2].map(range),
        }
    }

    /// Whether boxes around both are at most `near` \[m\] apart.
    fn meets(&self, other: &Surface, near: f64) -> bool {
        self.bounds.iter().zip(&other.bounds).all(|(a, b)| a.start <= b.end + near && b.start <= a.end + near)
    }

    /// The distance \[m\] of each of the points of a garment that are `asked` for from triangles that count, in front of this surface (`side` 1) or behind it (-1), up to
    /// `near` \[m\], where both are layers; infinite elsewhere.
    fn gaps(
        &self,
        sheet: &Sheet,
        (side, near): (f64, f64),
        asked: impl Fn(usize) -> bool + Sync,
        counts: impl Fn(u32) -> bool + Sync,
    ) -> Vec<f64> {
        let inside =
            |p: &[f64; 3]| (0..3).all(|c| self.bounds[c].start - near <= p[c] && p[c] <= self.bounds[c].end + near);
        let gap = |p: usize| {
            let (at, normal) = (sheet.positions[p], sheet.normals[p]);
            if !asked(p) || !inside(&at) {
                return None;
            }
            let found = self.closest.project(at).filter(|found| found.distance <= near && counts(found.triangle))?;
            let there = self.normals[found.triangle as usize];
            let far = distance(at, found.point);
            let way = scale(sub(at, found.point), side / far);
            (dot(there, normal) > ALIKE && far > 0.0 && dot(way, there) > ACROSS).then_some(far)
        };
        let mut gaps: Vec<f64> =
            (0..sheet.positions.len()).into_par_iter().map(|p| gap(p).unwrap_or(f64::INFINITY)).collect();
        for _ in 0..CLOSED {
            gaps = (0..gaps.len()).map(|p| if asked(p) { closed(sheet, &gaps, p) } else { gaps[p] }).collect();
        }
        gaps
    }
}

/// The gap of a point; the smallest one of its neighbours if it has none and most of these have one.
fn closed(sheet: &Sheet, gaps: &[f64], point: usize) -> f64 {
    if gaps[point].is_finite() {
        return gaps[point];
    }
    let around = || sheet.neighbours(point as u32).map(|p| gaps[p as usize]);
    let found = around().filter(|gap| gap.is_finite()).count();
    if 2 * found > around().count() { around().fold(f64::INFINITY, f64::min) } else { f64::INFINITY }
}

/// Gaps with those of points beside points that have one, larger by the way to these.
fn beyond(sheet: &Sheet, gaps: &[f64]) -> Vec<f64> {
    let next = |p: usize| {
        let way = |q: u32| gaps[q as usize] + distance(sheet.positions[p], sheet.positions[q as usize]);
        sheet.neighbours(p as u32).map(way).fold(f64::INFINITY, f64::min)
    };
    (0..gaps.len()).map(|p| if gaps[p].is_finite() { gaps[p] } else { next(p) }).collect()
}
