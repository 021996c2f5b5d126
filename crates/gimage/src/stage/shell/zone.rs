//! The triangles of components that may be shells, with the sheet that faces each of them.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::rays::{Opposite, Sheets, reach, subcentres};
use crate::base::mesh::Mesh;
use crate::base::vec3::{cross, distance, normalize, sub};
use crate::stage::component::Component;

/// Share of a component that must have an opposite sheet for a closer look.
const WORTH_A_LOOK: f64 = 0.35;
/// Distances beyond this multiple of a component's median do not count: they run across a strap, not through it.
const FARTHEST: f64 = 3.0;
/// Triangles get one point per this share of their component's area.
const SHARE: f64 = 1.0 / 256.0;
/// A triangle is narrow if its height is below this multiple of the thickness.
const NARROW: f64 = 1.2;
/// Largest ratio of the distances that two facing triangles have from each other.
const ALIKE: f64 = 2.5;
/// Share of the smaller of two components that must face the other, and be faced, for them to be sheets of one shell.
const LINKED: f64 = 0.35;

/// Two triangles that face each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub triangle: u32,
    pub other: u32,
}

/// Components that may be shells; triangles are numbered within the zone.
pub(super) struct Zone {
    /// The triangle of the mesh.
    pub source: Vec<u32>,
    /// Vertices, as in the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// The component, as the caller numbers them.
    pub component: Vec<u32>,
    /// Area \[m2\].
    pub area: Vec<f64>,
    /// Unit normal out of the fabric, zero for a triangle without area.
    pub normal: Vec<[f64; 3]>,
    /// Distance \[m\] of the opposite sheet; infinite without one.
    pub gap: Vec<f64>,
    /// Whether the height of the triangle is not larger than the thickness, as that of rims.
    pub is_narrow: Vec<bool>,
    /// Triangles that face each other, each pair at least once.
    pub pairs: Vec<Pair>,
}

impl Zone {
    /// The zone of some components of a mesh. O(n log n); only a few rays per component that is not in it.
    pub fn new(mesh: &Mesh, components: &[Component]) -> Self {
        let mut owner = vec![0; mesh.triangles.len()];
        components.iter().enumerate().for_each(|(k, c)| c.triangles.iter().for_each(|&t| owner[t as usize] = k as u32));
        let sheets = Sheets::new(mesh, &owner);
        let looks: Vec<_> = components.par_iter().map(|c| sheets.nearest(c)).collect();
        let mut zone = Self {
            source: Vec::new(),
            triangles: Vec::new(),
            component: Vec::new(),
            area: Vec::new(),
            normal: Vec::new(),
            gap: Vec::new(),
            is_narrow: Vec::new(),
            pairs: Vec::new(),
        };
        let mut hits: Vec<Vec<(f64, u32)>> = Vec::new();
        for (k, component) in components.iter().enumerate() {
            let Some(look) = looks[k].filter(|o| o.share >= WORTH_A_LOOK) else { continue };
            let reach = reach(component.area).min(FARTHEST * look.thickness);
            let of = |&t: &u32| {
                let points =
                    subcentres(&mesh.corners(t as usize), mesh.triangle_area(t as usize) / (SHARE * component.area));
                let found = points.iter().filter_map(|&p| sheets.hit(t, p, look.side, reach));
                let found: Vec<_> = found.collect();
                if 2 * found.len() >= points.len() { found } else { Vec::new() }
            };
            hits.extend(component.triangles.par_iter().map(of).collect::<Vec<_>>());
            zone.add(mesh, component, k as u32, &look);
        }
        zone.join(mesh.triangles.len(), hits);
        zone
    }

    fn add(&mut self, mesh: &Mesh, component: &Component, number: u32, look: &Opposite) {
        for &t in &component.triangles {
            let [a, b, c] = mesh.corners(t as usize);
            self.source.push(t);
            self.triangles.push(mesh.triangles[t as usize]);
            self.component.push(number);
            self.area.push(mesh.triangle_area(t as usize));
            let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
            self.is_narrow.push(2.0 * mesh.triangle_area(t as usize) <= NARROW * look.thickness * longest);
            self.normal.push(normalize(cross(sub(b, a), sub(c, a))).map(|x| -look.side * x));
        }
    }

    /// Takes the hits of each triangle, on triangles of the mesh: pairs that face each other both ways.
    fn join(&mut self, triangles: usize, hits: Vec<Vec<(f64, u32)>>) {
        let mut local = vec![u32::MAX; triangles];
        self.source.iter().enumerate().for_each(|(k, &t)| local[t as usize] = k as u32);
        let middle = |hits: &Vec<(f64, u32)>| {
            let mut gaps: Vec<f64> = hits.iter().map(|h| h.0).collect();
            gaps.sort_by(f64::total_cmp);
            gaps.get(gaps.len() / 2).copied().unwrap_or(f64::INFINITY)
        };
        self.gap = hits.iter().map(middle).collect();
        let mut pairs: Vec<(Pair, f64)> = Vec::new();
        for (k, hits) in hits.iter().enumerate() {
            for &(gap, other) in hits {
                let other = local[other as usize];
                if self.gap.get(other as usize).is_some_and(|&g| g <= ALIKE * gap && gap <= ALIKE * g) {
                    pairs.push((Pair { triangle: k as u32, other }, self.area[k] / hits.len() as f64));
                }
            }
        }
        let linked = self.linked(&pairs);
        pairs.retain(|(p, _)| linked(self.component[p.triangle as usize], self.component[p.other as usize]));
        // A triangle whose partners all belong to something else has none.
        let mut has = vec![false; self.gap.len()];
        pairs.iter().for_each(|(p, _)| has[p.triangle as usize] = true);
        self.gap.iter_mut().zip(has).for_each(|(gap, has)| *gap = if has { *gap } else { f64::INFINITY });
        self.pairs = pairs.into_iter().map(|x| x.0).collect();
    }

    /// Which components are sheets of one shell: they face each other both ways.
    fn linked(&self, pairs: &[(Pair, f64)]) -> impl Fn(u32, u32) -> bool + use<> {
        let (mut votes, mut areas): (BTreeMap<(u32, u32), f64>, BTreeMap<u32, f64>) = Default::default();
        for (pair, weight) in pairs {
            let at = |t: u32| self.component[t as usize];
            *votes.entry((at(pair.triangle), at(pair.other))).or_default() += weight;
        }
        self.component.iter().zip(&self.area).for_each(|(&c, a)| *areas.entry(c).or_default() += a);
        move |a, b| {
            let vote = |a, b| votes.get(&(a, b)).copied().unwrap_or(0.0);
            let area = |c| areas.get(&c).copied().unwrap_or(0.0);
            a == b || vote(a, b).min(vote(b, a)) >= LINKED * area(a).min(area(b))
        }
    }
}
