//! Panels sewn to one garment.

use std::collections::{BTreeMap, BTreeSet};

use crate::math::{V2, V3, add, cross2, dist2, scale};
use crate::panel::{Panel, PanelMesh, segments};

/// Triangulated panels whose sewn points share particles.
pub struct Garment {
    /// The panels; their points are the texture coordinates, in metres.
    pub panels: Vec<PanelMesh>,
    /// For each panel, the particle of each of its points.
    pub particle: Vec<Vec<usize>>,
    /// The place of each particle.
    pub x: Vec<V3>,
}

/// A spring that keeps two particles apart: an edge, or the far corners of two triangles at an edge.
pub struct Spring {
    /// The two particles.
    pub ends: [usize; 2],
    /// The distance in the flat panels.
    pub rest: f64,
}

/// Sews the panels along edges of equal names; edges come out about `h` long.
pub fn sew(panels: &[Panel], h: f64) -> Garment {
    let counts = segments(panels, h);
    let meshes: Vec<PanelMesh> = panels.iter().map(|p| p.mesh(h, &counts)).collect();
    let base: Vec<usize> = meshes
        .iter()
        .scan(0, |n, m| {
            *n += m.points.len();
            Some(*n - m.points.len())
        })
        .collect();
    let total = base.last().unwrap_or(&0) + meshes.last().map_or(0, |m| m.points.len());
    let mut parent: Vec<usize> = (0..total).collect();
    let mut seen: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (m, b) in meshes.iter().zip(&base) {
        for (name, ids) in &m.edges {
            let ids: Vec<usize> = ids.iter().map(|i| i + b).collect();
            match seen.remove(name.as_str()) {
                // Neighbours on a surface run along their common edge in opposite directions.
                Some(other) => ids.iter().rev().zip(other).for_each(|(&a, b)| union(&mut parent, a, b)),
                None => {
                    seen.insert(name, ids);
                }
            }
        }
    }
    let mut number = BTreeMap::new();
    let all: Vec<usize> = (0..total)
        .map(|i| {
            let (root, next) = (find(&mut parent, i), number.len());
            *number.entry(root).or_insert(next)
        })
        .collect();
    let mut sums = vec![([0.0; 3], 0.0); number.len()];
    let mut particle = Vec::new();
    for ((m, &b), p) in meshes.iter().zip(&base).zip(panels) {
        for (i, &q) in m.points.iter().enumerate() {
            let s = &mut sums[all[b + i]];
            *s = (add(s.0, (p.place)(q)), s.1 + 1.0);
        }
        particle.push(all[b..b + m.points.len()].to_vec());
    }
    let x = sums.into_iter().map(|(s, n)| scale(s, 1.0 / n)).collect();
    Garment { panels: meshes, particle, x }
}

fn find(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

fn union(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b)] = a.min(b);
}

/// An edge of the panels, as its triangles have it.
#[derive(Default)]
struct Edge {
    /// Sum of its lengths in the panels' planes \[m\].
    length: f64,
    /// Triangles at it.
    count: f64,
    /// The far corner of each triangle, with its place along the edge and off it.
    far: Vec<(usize, f64, f64)>,
}

impl Garment {
    /// All triangles as particles, with their corners in the panel.
    pub fn triangles(&self) -> impl Iterator<Item = ([usize; 3], [V2; 3])> {
        self.panels
            .iter()
            .zip(&self.particle)
            .flat_map(|(m, of)| m.triangles.iter().map(|t| (t.map(|i| of[i]), t.map(|i| m.points[i]))))
    }

    /// The particles of all outline edges whose name starts with `prefix`.
    pub fn on_edges(&self, prefix: &str) -> Vec<usize> {
        let mut out = BTreeSet::new();
        for (m, of) in self.panels.iter().zip(&self.particle) {
            let edges = m.edges.iter().filter(|(name, _)| name.starts_with(prefix));
            out.extend(edges.flat_map(|(_, ids)| ids).map(|&i| of[i]));
        }
        out.into_iter().collect()
    }

    /// The springs along edges, and those across them that resist folding.
    pub fn springs(&self) -> (Vec<Spring>, Vec<Spring>) {
        let mut edges: BTreeMap<[usize; 2], Edge> = BTreeMap::new();
        for (t, p) in self.triangles() {
            for k in 0..3 {
                let [mut i, mut j] = [k, (k + 1) % 3];
                let far = (k + 2) % 3;
                if t[i] > t[j] {
                    (i, j) = (j, i);
                }
                let length = dist2(p[i], p[j]);
                let along = ((p[far][0] - p[i][0]) * (p[j][0] - p[i][0]) + (p[far][1] - p[i][1]) * (p[j][1] - p[i][1]))
                    / length;
                let e = edges.entry([t[i], t[j]]).or_default();
                (e.length, e.count) = (e.length + length, e.count + 1.0);
                e.far.push((t[far], along, cross2(p[0], p[1], p[2]) / length));
            }
        }
        let mut bends = Vec::new();
        let stretch = |(ends, edge): ([usize; 2], Edge)| {
            if let [a, b] = edge.far[..] {
                bends.push(Spring { ends: [a.0, b.0], rest: dist2([a.1, a.2], [b.1, -b.2]) });
            }
            Spring { ends, rest: edge.length / edge.count }
        };
        let mut stretches: Vec<Spring> = edges.into_iter().map(stretch).collect();
        // Holes are braced, or they would close under the weight of the cloth.
        for (m, of) in self.panels.iter().zip(&self.particle) {
            for hole in &m.holes {
                for (k, &a) in hole.iter().enumerate() {
                    let brace = |&b: &usize| Spring { ends: [of[a], of[b]], rest: dist2(m.points[a], m.points[b]) };
                    stretches.extend(hole[k + 1..].iter().map(brace));
                }
            }
        }
        (stretches, bends)
    }
}
