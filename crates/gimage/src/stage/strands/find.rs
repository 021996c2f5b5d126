//! Finds strands: triangles that are bent and have the other side of the strand behind them, in a part that a short ring divides from the garment.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashSet};

use gimage_bundle::DisjointSets;
use rayon::prelude::*;

use super::Strand;
use crate::base::closest::Closest;
use crate::base::halfedge::{BOUNDARY, euler, origin, target, twins};
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, distance, dot, scale};

/// Lengths are shares of the root of the area of a component.
/// Curvature of a triangle of a strand, at least; that of a tube is one over its radius.
const CURVATURE: f64 = 40.0;
/// Thickness, at most.
const THICKNESS: f64 = 0.016;
/// Length around the root, at most.
const AROUND: f64 = 0.06;
/// Length, at least.
const LENGTH: f64 = 0.03;
/// Area over the square of the length around the root, at least: for a tube its length over the way around.
const SLIMNESS: f64 = 2.0;
/// Length of the border of an open end over the length around the root, at most.
const OPEN: f64 = 2.0;
/// Share of the area of its component, at most.
const SHARE: f64 = 0.05;
/// Triangles of a strand, at least.
const TRIANGLES: usize = 6;
/// Cosine between the normals of both sides, at most.
const OPPOSITE: f64 = -0.2;

/// All strands of a repaired mesh, by their first triangles.
pub(super) fn strands(mesh: &Mesh) -> Vec<Strand> {
    let Some(surface) = Surface::new(mesh) else { return Vec::new() };
    let thin = surface.thin();
    let mut seen = vec![false; thin.len()];
    let mut found = Vec::new();
    let mut taken = vec![false; thin.len()];
    for first in 0..thin.len() {
        if !thin[first] || seen[first] {
            continue;
        }
        let group = surface.spread(first as u32, f64::INFINITY, |t| thin[t as usize] && !seen[t as usize]);
        group.iter().for_each(|t| seen[*t as usize] = true);
        let area: f64 = group.iter().map(|t| surface.areas[*t as usize]).sum();
        if group.len() < TRIANGLES || area > SHARE * surface.sizes[first].powi(2) {
            continue;
        }
        if let Some(strand) = surface.strand(&group).filter(|s| !s.triangles.iter().any(|t| taken[*t as usize])) {
            strand.triangles.iter().for_each(|t| taken[*t as usize] = true);
            found.push(strand);
        }
    }
    found.sort_by_key(|strand| strand.triangles[0]);
    found
}

/// A mesh by its triangles.
struct Surface<'a> {
    mesh: &'a Mesh,
    areas: Vec<f64>,
    /// Unit normals; 0 without area.
    normals: Vec<[f64; 3]>,
    centers: Vec<[f64; 3]>,
    /// The half-edge on the other side of each half-edge, or [`BOUNDARY`].
    twins: Vec<u32>,
    /// The component of each triangle, and the root \[m\] of the area of it.
    components: Vec<u32>,
    sizes: Vec<f64>,
}

impl<'a> Surface<'a> {
    /// `None` of a mesh that is not repaired: one with three triangles at an edge.
    fn new(mesh: &'a Mesh) -> Option<Self> {
        let count = mesh.triangles.len();
        let twins = twins(&mesh.triangles).ok()?;
        let mut components = DisjointSets::new(count);
        let pairs = (0..).zip(&twins).filter(|(_, twin)| **twin != BOUNDARY);
        pairs.for_each(|(h, twin)| _ = components.union(h / 3, twin / 3));
        let components = components.into_representatives();
        let areas: Vec<f64> = (0..count).map(|t| mesh.triangle_area(t)).collect();
        let mut whole = vec![0.0; count];
        (0..count).for_each(|t| whole[components[t] as usize] += areas[t]);
        let center = |t: usize| mesh.corners(t).into_iter().fold([0.0; 3], |sum, p| add(sum, scale(p, 1.0 / 3.0)));
        let sizes = components.iter().map(|c| whole[*c as usize].sqrt()).collect();
        let (normals, centers) = ((0..count).map(|t| mesh.facing(t)).collect(), (0..count).map(center).collect());
        Some(Surface { mesh, areas, normals, centers, twins, components, sizes })
    }

    /// The triangles beside one.
    fn beside(&self, t: u32) -> impl Iterator<Item = u32> + '_ {
        let twins = &self.twins[3 * t as usize..3 * t as usize + 3];
        twins.iter().filter(|h| **h != BOUNDARY).map(|h| h / 3)
    }

    /// Triangles that hang together with one, of those that are asked for, by the order in which they are found; up to an area.
    fn spread(&self, first: u32, most: f64, is_asked: impl Fn(u32) -> bool) -> Vec<u32> {
        let (mut found, mut known, mut next) = (vec![first], HashSet::from([first]), 0);
        let mut area = 0.0;
        while let Some(&t) = found.get(next) {
            area += self.areas[t as usize];
            if area > most {
                break;
            }
            found.extend(self.beside(t).filter(|n| is_asked(*n) && known.insert(*n)));
            next += 1;
        }
        found
    }

    /// Whether each triangle is bent, and has another one close behind it that faces away from it.
    fn thin(&self) -> Vec<bool> {
        let is_bent = |t: u32| {
            self.beside(t).any(|n| {
                let [a, b] = [t, n].map(|k| self.normals[k as usize]);
                let angle = dot(a, b).clamp(-1.0, 1.0).acos();
                let far = distance(self.centers[t as usize], self.centers[n as usize]);
                a != [0.0; 3] && b != [0.0; 3] && angle * self.sizes[t as usize] > CURVATURE * far
            })
        };
        let bent: Vec<u32> = (0..self.areas.len() as u32).filter(|t| is_bent(*t)).collect();
        let tree = Closest::of(&bent.iter().map(|t| self.mesh.corners(*t as usize)).collect::<Vec<_>>());
        let has_back = |t: &u32| {
            let at = *t as usize;
            let (own, n) = (self.components[at], self.normals[at]);
            let is_back = |k: u32, normal: [f64; 3]| {
                let other = bent[k as usize];
                other != *t && self.components[other as usize] == own && dot(normal, n) < OPPOSITE
            };
            tree.along(self.centers[at], scale(n, -1.0), THICKNESS * self.sizes[at], is_back).is_some()
        };
        let backed: Vec<bool> = bent.par_iter().map(has_back).collect();
        let mut thin = vec![false; self.areas.len()];
        bent.iter().zip(backed).for_each(|(t, backed)| thin[*t as usize] = backed);
        thin
    }

    /// The strand in thin triangles that hang together: of all parts of them that begin at the tip, the slimmest, if it is one.
    fn strand(&self, group: &[u32]) -> Option<Strand> {
        let (first, size) = (group[0] as usize, self.sizes[group[0] as usize]);
        // With what they enclose, as the end of the tip.
        let mut group: BTreeMap<u32, bool> = group.iter().map(|t| (*t, true)).collect();
        for t in group.keys().copied().collect::<Vec<_>>() {
            for n in self.beside(t).collect::<Vec<_>>() {
                if group.contains_key(&n) {
                    continue;
                }
                let most = SHARE * size * size;
                let hole = self.spread(n, most, |t| group.get(&t) != Some(&true));
                let is_hole = hole.iter().map(|t| self.areas[*t as usize]).sum::<f64>() <= most;
                hole.iter().for_each(|t| _ = group.insert(*t, is_hole));
            }
        }
        let is_inside = |t: &u32| group.get(t) == Some(&true);
        let inside = || group.keys().copied().filter(|t| is_inside(t));
        let root: Vec<u32> = inside().filter(|t| self.beside(*t).any(|n| !is_inside(&n))).collect();
        let farthest = self.ways(&root, &is_inside).into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let mut order: Vec<(u32, f64)> = self.ways(&[farthest?.0], &is_inside).into_iter().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let mut part = HashSet::new();
        let (mut around, mut area, mut best) = (0.0, 0.0, (0.0, 0));
        for (n, (t, _)) in order.iter().enumerate() {
            part.insert(*t);
            area += self.areas[*t as usize];
            for h in 3 * t..3 * t + 3 {
                // The edge of an open end does not hang together with anything.
                let twin = self.twins[h as usize];
                if twin != BOUNDARY {
                    around += if part.contains(&(twin / 3)) { -self.length(h) } else { self.length(h) };
                }
            }
            let slimness: f64 = area / (around * around);
            if around > 1e-6 * size && slimness > best.0 {
                best = (slimness, n + 1);
            }
        }
        let part = &order[..best.1];
        let length = part.last()?.1;
        if best.0 < SLIMNESS || part.len() < TRIANGLES || length < LENGTH * size {
            return None;
        }
        let mut triangles: Vec<u32> = part.iter().map(|(t, _)| *t).collect();
        triangles.sort_unstable();
        let ring = self.ring(&triangles)?;
        let around: f64 = ring.iter().map(|h| self.length(*h)).sum();
        let area: f64 = triangles.iter().map(|t| self.areas[*t as usize]).sum();
        let open: f64 = triangles
            .iter()
            .flat_map(|t| 3 * t..3 * t + 3)
            .filter(|h| self.is_border(*h))
            .map(|h| self.length(h))
            .sum();
        if around > AROUND * size || open > OPEN * around || area < SLIMNESS * around * around {
            return None;
        }
        let node = self.mesh.parts.get(self.mesh.triangle_part[first] as usize).map(|part| part.node.clone());
        Some(Strand { node: node.unwrap_or_default(), triangles, area, length, around, ring })
    }

    /// The shortest ways \[m\] over centres of triangles from some to each of those inside.
    fn ways(&self, from: &[u32], is_inside: &impl Fn(&u32) -> bool) -> BTreeMap<u32, f64> {
        let mut ways: BTreeMap<u32, f64> = from.iter().map(|t| (*t, 0.0)).collect();
        // The bits of numbers of at least 0 are in their order.
        let mut next: BinaryHeap<Reverse<(u64, u32)>> = from.iter().map(|t| Reverse((0, *t))).collect();
        while let Some(Reverse((bits, t))) = next.pop() {
            let way = f64::from_bits(bits);
            if way > ways[&t] {
                continue;
            }
            for n in self.beside(t).filter(is_inside) {
                let way = way + distance(self.centers[t as usize], self.centers[n as usize]);
                if ways.get(&n).is_none_or(|known| way < *known) {
                    ways.insert(n, way);
                    next.push(Reverse((way.to_bits(), n)));
                }
            }
        }
        ways
    }

    fn is_border(&self, h: u32) -> bool {
        self.twins[h as usize] == BOUNDARY
    }

    fn length(&self, h: u32) -> f64 {
        let [a, b] = [origin(&self.mesh.triangles, h), target(&self.mesh.triangles, h)];
        distance(self.mesh.positions[a as usize], self.mesh.positions[b as usize])
    }

    /// The half-edges of the garment around triangles, in order, if they are one ring and the triangles are a disk, or a tube with an open end.
    fn ring(&self, triangles: &[u32]) -> Option<Vec<u32>> {
        let is_own = |t: u32| triangles.binary_search(&t).is_ok();
        let halves = || triangles.iter().flat_map(|t| 3 * t..3 * t + 3);
        let other = |h: u32| Some(self.twins[h as usize]).filter(|twin| *twin != BOUNDARY && !is_own(twin / 3));
        let mut from = BTreeMap::new();
        for h in halves().filter_map(other) {
            if from.insert(origin(&self.mesh.triangles, h), h).is_some() {
                return None;
            }
        }
        let has_end = halves().any(|h| self.is_border(h));
        let corners: Vec<[u32; 3]> = triangles.iter().map(|t| self.mesh.triangles[*t as usize]).collect();
        if euler(&corners) != i64::from(!has_end) || from.len() < 3 {
            return None;
        }
        let mut ring = vec![*from.values().next()?];
        while ring.len() < from.len() {
            ring.push(*from.get(&target(&self.mesh.triangles, *ring.last()?))?);
        }
        let is_ring = target(&self.mesh.triangles, *ring.last()?) == origin(&self.mesh.triangles, ring[0]);
        let mut sorted = ring.clone();
        sorted.sort_unstable();
        sorted.dedup();
        (is_ring && sorted.len() == ring.len()).then_some(ring)
    }
}
