//! Points of the body that can be touched, and points outside and inside of it, each with the joint that it follows.

use gimage_bundle::Winding;
use rayon::prelude::*;

use crate::base::closest::Closest;
use crate::base::mesh::{Mesh, Semantic};
use crate::base::scatter::Sampler;
use crate::base::vec3::{add, cross, dot, normalize, scale, sub};

/// Height above the surface at which a point is tested for being covered, as a share of the diagonal of the mesh.
const ABOVE: f64 = 1e-4;
/// Winding number from which a point is inside.
pub(super) const INSIDE: f64 = 0.5;
/// Share of the samples below which a joint is too small for a solid of its own, such as those of fingers.
const SMALL: f64 = 1.0 / 150.0;
/// Heights of points outside, as shares of the diagonal.
const HEIGHTS: [f64; 3] = [0.01, 0.04, 0.15];
/// Depths of points inside, as shares of the way to the other side.
const DEPTHS: [f64; 2] = [0.25, 0.5];
/// Share of the height of a garment, from its top, that is held to lie on the body.
const HELD: f64 = 0.12;
/// Weight of an error outwards, beside one inwards.
const OUTWARD_WEIGHT: f64 = 1.5;
/// One surface sample in this number has points outside and inside.
const EVERY: usize = 2;

/// A point and the signed distances from the surface of the solids that are right for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub point: [f64; 3],
    /// The joint with the largest weight, of points outside and inside that of the point of the surface they belong to.
    pub joint: Option<u32>,
    /// Least distance \[m\]: 0 of the surface, that of the body for points outside.
    pub low: f64,
    /// Largest distance \[m\]: 0 of the surface and inside.
    pub high: f64,
}

impl Sample {
    /// A point of the surface.
    pub fn on(point: [f64; 3], joint: Option<u32>) -> Self {
        Sample { point, joint, low: 0.0, high: 0.0 }
    }

    pub fn is_on_surface(&self) -> bool {
        self.low == self.high
    }

    pub fn is_outside(&self) -> bool {
        self.high == f64::INFINITY
    }

    /// How far a distance is from those that are right.
    pub fn error(&self, distance: f64) -> f64 {
        // A solid that stands out lifts the cloth; one that stays behind is seen less.
        (distance - self.high).max(0.0) + OUTWARD_WEIGHT * (distance - self.low).min(0.0)
    }
}

/// Points at equal shares of the area, without those that other triangles cover, such as teeth. O(count x triangles).
pub(super) fn samples(mesh: &Mesh, winding: &Winding, count: usize, seed: u64) -> Vec<Sample> {
    let corners: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
    let sampler = Sampler::new(&corners, count, seed);
    let above = ABOVE * mesh.diagonal();
    if sampler.area() <= 0.0 {
        return Vec::new();
    }
    let sample = |i: usize| {
        let (point, t) = sampler.at(i);
        let normal = normal(corners[t]);
        let covered = winding.number(add(point, scale(normal, above))) > INSIDE;
        (!covered).then(|| Sample::on(point, strongest(mesh, t, point)))
    };
    (0..count).into_par_iter().filter_map(sample).collect()
}

/// Points of the garments, which no solid may contain. Those inside the body count only near the top of their part, where garments are
/// pinned: cloth between pins inside of a solid and its surface is torn.
pub(super) fn worn(mesh: &Mesh, winding: &Winding, count: usize) -> Vec<Sample> {
    let corners: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
    let sampler = Sampler::new(&corners, count, 3);
    if sampler.area() <= 0.0 {
        return Vec::new();
    }
    let mut spans = vec![[f64::INFINITY, f64::NEG_INFINITY]; mesh.parts.len()];
    for (corners, part) in corners.iter().zip(&mesh.triangle_part) {
        let span = &mut spans[*part as usize];
        *span = corners.iter().fold(*span, |[low, high], p| [low.min(p[1]), high.max(p[1])]);
    }
    let sample = |i| {
        let (point, t) = sampler.at(i);
        let [low, high] = spans[mesh.triangle_part[t] as usize];
        let counts = point[1] >= high - HELD * (high - low) || winding.number(point) < INSIDE;
        counts.then_some(Sample { point, joint: None, low: 0.0, high: f64::INFINITY })
    };
    (0..count).into_par_iter().filter_map(sample).collect()
}

/// Points outside the body, which no solid may come nearer to than the body is, and points inside, which solids should contain:
/// without them a solid may be a thin plate below the surface, or reach far beyond the body where it has no samples.
pub(super) fn guards(mesh: &Mesh, winding: &Winding, surface: &[Sample]) -> Vec<Sample> {
    let closest = Closest::new(&mesh.positions, &mesh.triangles);
    let diagonal = mesh.diagonal();
    let of = |s: &Sample| {
        let mut out = Vec::new();
        let Some(at) = closest.project(s.point) else { return out };
        let normal = normal(mesh.corners(at.triangle as usize));
        for height in HEIGHTS {
            let point = add(s.point, scale(normal, height * diagonal));
            let distance = closest.project(point).map_or(0.0, |n| n.distance);
            // Near another part of the body a point is no longer free.
            if distance > 0.5 * height * diagonal && winding.number(point) < INSIDE {
                out.push(Sample { point, joint: s.joint, low: distance, high: f64::INFINITY });
            }
        }
        let wall =
            closest.along(s.point, scale(normal, -1.0), diagonal, |t, n| t != at.triangle && dot(n, normal) < 0.0);
        if let Some((through, _)) = wall {
            let inside = |d: f64| add(s.point, scale(normal, -d * through));
            out.extend(DEPTHS.map(|d| Sample { point: inside(d), joint: s.joint, low: f64::NEG_INFINITY, high: 0.0 }));
        }
        out
    };
    let some: Vec<&Sample> = surface.iter().step_by(EVERY).collect();
    some.into_par_iter().flat_map_iter(of).collect()
}

pub(super) fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    normalize(cross(sub(b, a), sub(c, a)))
}

/// The joint with the largest weight at a point of triangle `t`.
pub(super) fn strongest(mesh: &Mesh, t: usize, point: [f64; 3]) -> Option<u32> {
    let at = barycentric(mesh.corners(t), point);
    let mut sums: Vec<(u32, f64)> = Vec::new();
    for n in 0.. {
        let channels = (mesh.channel(&Semantic::Joints(n)), mesh.channel(&Semantic::Weights(n)));
        let (Some(joints), Some(weights)) = channels else { break };
        for (c, share) in at.iter().enumerate() {
            let (Some(joints), Some(weights)) = (joints.at(t, c), weights.at(t, c)) else { continue };
            for (joint, weight) in joints.iter().zip(weights) {
                let joint = *joint as u32;
                let amount = share * f64::from(*weight);
                match sums.iter_mut().find(|(j, _)| *j == joint) {
                    Some((_, sum)) => *sum += amount,
                    None => sums.push((joint, amount)),
                }
            }
        }
    }
    let best = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    (best.1 > 0.0 && (best.0 as usize) < mesh.skeleton.joints.len()).then_some(best.0)
}

pub(super) fn barycentric([a, b, c]: [[f64; 3]; 3], p: [f64; 3]) -> [f64; 3] {
    let (u, v, w) = (sub(b, a), sub(c, a), sub(p, a));
    let normal = cross(u, v);
    let area = dot(normal, normal);
    if area <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (y, z) = (dot(cross(w, v), normal) / area, dot(cross(u, w), normal) / area);
    [1.0 - y - z, y, z]
}

/// Gives the samples of joints that have few, such as fingers, to the parent joint.
pub(super) fn join_small(samples: &mut [Sample], parents: &[Option<u32>]) {
    let depth = |joint: usize| {
        let chain = std::iter::successors(Some(joint), |j| parents[*j].map(|p| p as usize));
        chain.take(parents.len() + 1).count()
    };
    let mut order: Vec<usize> = (0..parents.len()).collect();
    order.sort_by_cached_key(|&j| std::cmp::Reverse(depth(j)));
    let few = (SMALL * samples.len() as f64) as usize;
    let mut counts = vec![0; parents.len()];
    samples.iter().filter_map(|s| s.joint).for_each(|j| counts[j as usize] += 1);
    let mut goes: Vec<u32> = (0..parents.len() as u32).collect();
    for &joint in &order {
        let Some(parent) = parents[joint].filter(|_| counts[joint] < few) else { continue };
        counts[parent as usize] += std::mem::take(&mut counts[joint]);
        goes.iter_mut().filter(|g| **g == joint as u32).for_each(|g| *g = parent);
    }
    samples.iter_mut().for_each(|s| s.joint = s.joint.map(|j| goes[j as usize]));
}
