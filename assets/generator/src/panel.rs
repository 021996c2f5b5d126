//! Flat sewing panels: outlines made of named edges, and their triangulation.

use std::collections::BTreeMap;

use crate::delaunay::triangulate;
use crate::math::{V2, V3, cross2, dist2, noise};

/// One edge of an outline. Two edges of the same name, in one panel or in two, are sewn to each other.
#[derive(Clone, Debug)]
pub struct Edge {
    /// The name that the edge is sewn by; a name used once is a free edge.
    pub name: String,
    /// The edge as a fine polyline, in the order of the outline.
    pub curve: Vec<V2>,
}

/// A flat piece of cloth as seen from outside the garment, in metres.
pub struct Panel {
    /// The outline, counter-clockwise; each edge starts where the one before ends.
    pub outline: Vec<Edge>,
    /// Holes, as clockwise polygons whose corners all become vertices.
    pub holes: Vec<Vec<V2>>,
    /// Roughly where a point of the panel starts in space before draping.
    pub place: Box<dyn Fn(V2) -> V3>,
}

/// A triangulated panel.
pub struct PanelMesh {
    /// Points; the outline comes first, then the holes.
    pub points: Vec<V2>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[usize; 3]>,
    /// For each edge of the outline its name and its points from start to end.
    pub edges: Vec<(String, Vec<usize>)>,
    /// The points of each hole.
    pub holes: Vec<Vec<usize>>,
}

/// A straight edge.
pub fn line(name: &str, a: V2, b: V2) -> Edge {
    Edge { name: name.into(), curve: vec![a, b] }
}

/// A cubic Bézier edge.
pub fn bezier(name: &str, p: [V2; 4]) -> Edge {
    let curve = (0..=64).map(|i| {
        let t = f64::from(i) / 64.0;
        let s = 1.0 - t;
        let w = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        [0, 1].map(|k| (0..4).map(|j| w[j] * p[j][k]).sum())
    });
    Edge { name: name.into(), curve: curve.collect() }
}

/// An edge through the points of `f` for t in 0..=1.
pub fn curve(name: &str, f: impl Fn(f64) -> V2) -> Edge {
    Edge { name: name.into(), curve: (0..=96).map(|i| f(f64::from(i) / 96.0)).collect() }
}

/// The outline seen in a mirror; `rename` gives each edge its new name.
pub fn mirror(outline: &[Edge], rename: impl Fn(&str) -> String) -> Vec<Edge> {
    let flip = |e: &Edge| Edge { name: rename(&e.name), curve: e.curve.iter().rev().map(|p| [-p[0], p[1]]).collect() };
    outline.iter().rev().map(flip).collect()
}

impl Edge {
    /// The length of the edge.
    pub fn length(&self) -> f64 {
        self.curve.windows(2).map(|w| dist2(w[0], w[1])).sum()
    }

    /// `n` points evenly spaced along the edge; the last end is left to the next edge.
    fn sample(&self, n: usize) -> Vec<V2> {
        let step = self.length() / n as f64;
        let mut out = vec![self.curve[0]];
        let mut walked = 0.0;
        for w in self.curve.windows(2) {
            let d = dist2(w[0], w[1]);
            while out.len() < n && out.len() as f64 * step <= walked + d {
                let t = (out.len() as f64 * step - walked) / d;
                out.push([0, 1].map(|k| w[0][k] + t * (w[1][k] - w[0][k])));
            }
            walked += d;
        }
        out
    }
}

/// How many segments each name gets, so that sewn edges meet point by point.
pub fn segments(panels: &[Panel], h: f64) -> BTreeMap<String, usize> {
    let mut sums: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for e in panels.iter().flat_map(|p| &p.outline) {
        let s = sums.entry(e.name.clone()).or_default();
        *s = (s.0 + e.length(), s.1 + 1.0);
    }
    sums.into_iter().map(|(k, (l, n))| (k, (l / n / h).round().max(1.0) as usize)).collect()
}

impl Panel {
    /// Triangulates the panel with edges about `h` long.
    pub fn mesh(&self, h: f64, segments: &BTreeMap<String, usize>) -> PanelMesh {
        let mut points = Vec::new();
        let mut edges = Vec::new();
        for e in &self.outline {
            let start = points.len();
            points.extend(e.sample(segments[&e.name]));
            edges.push((e.name.clone(), (start..=points.len()).collect::<Vec<_>>()));
        }
        let rim = points.len();
        edges.iter_mut().for_each(|(_, ids)| ids.iter_mut().for_each(|i| *i %= rim));
        let mut loops = vec![points.clone()];
        let mut holes = Vec::new();
        for hole in &self.holes {
            holes.push((points.len()..points.len() + hole.len()).collect());
            points.extend(hole);
            loops.push(hole.clone());
        }
        let fixed = points.len();
        points.extend(lattice(&loops, h));
        let mut triangles = inside(&points, &loops, h);
        // A few gentle smoothing rounds even out the triangles but keep some of the jitter.
        for _ in 0..4 {
            relax(&mut points, &triangles, fixed);
            triangles = inside(&points, &loops, h);
        }
        PanelMesh { points, triangles, edges, holes }
    }
}

/// A jittered triangular lattice over the inside of the loops, clear of them.
fn lattice(loops: &[Vec<V2>], h: f64) -> Vec<V2> {
    let all = || loops[0].iter();
    let bound = |k: usize, s: f64| s * all().map(|p| s * p[k]).fold(f64::MIN, f64::max);
    let (x0, x1, y0, y1) = (bound(0, -1.0), bound(0, 1.0), bound(1, -1.0), bound(1, 1.0));
    let row = h * 0.866;
    let mut out = Vec::new();
    for j in 0..=((y1 - y0) / row) as u64 {
        for i in 0..=((x1 - x0) / h) as u64 {
            let seed = 2 * (j * 4096 + i);
            let x = x0 + h * (i as f64 + 0.5 * (j % 2) as f64 + 0.18 * noise(seed));
            let y = y0 + row * j as f64 + h * 0.18 * noise(seed + 1);
            if is_inside([x, y], loops) && distance([x, y], loops) > 0.62 * h {
                out.push([x, y]);
            }
        }
    }
    out
}

/// The Delaunay triangles within the loops.
fn inside(points: &[V2], loops: &[Vec<V2>], h: f64) -> Vec<[usize; 3]> {
    let mut tris = triangulate(points, h);
    tris.retain(|t| {
        let [a, b, c] = t.map(|i| points[i]);
        let centre = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        // Collinear samples of a straight edge leave triangles of no area along it.
        cross2(a, b, c) > 2e-3 * h * h && is_inside(centre, loops)
    });
    tris
}

fn relax(points: &mut [V2], triangles: &[[usize; 3]], fixed: usize) {
    let mut sums = vec![[0.0; 3]; points.len()];
    for t in triangles {
        for k in 0..3 {
            let q = points[t[(k + 1) % 3]];
            let s = &mut sums[t[k]];
            *s = [s[0] + q[0], s[1] + q[1], s[2] + 1.0];
        }
    }
    for (p, s) in points.iter_mut().zip(sums).skip(fixed).filter(|(_, s)| s[2] > 0.0) {
        *p = [0, 1].map(|k| 0.4 * p[k] + 0.6 * s[k] / s[2]);
    }
}

/// The segments of all loops.
fn sides(loops: &[Vec<V2>]) -> impl Iterator<Item = (V2, V2)> {
    loops.iter().flat_map(|l| (0..l.len()).map(|i| (l[i], l[(i + 1) % l.len()])))
}

fn is_inside(p: V2, loops: &[Vec<V2>]) -> bool {
    let crosses = |(a, b): &(V2, V2)| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    sides(loops).filter(crosses).count() % 2 == 1
}

fn distance(p: V2, loops: &[Vec<V2>]) -> f64 {
    let to = |(a, b): (V2, V2)| {
        let d = [b[0] - a[0], b[1] - a[1]];
        let t = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
        let t = t.clamp(0.0, 1.0);
        dist2(p, [a[0] + t * d[0], a[1] + t * d[1]])
    };
    sides(loops).map(to).fold(f64::MAX, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_a_hole_keeps_its_area_and_rims() {
        let c = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]];
        let outline = (0..4).map(|i| line(&format!("e{i}"), c[i], c[(i + 1) % 4])).collect();
        let hole = vec![[0.19, 0.19], [0.19, 0.21], [0.21, 0.21], [0.21, 0.19]];
        let panel = Panel { outline, holes: vec![hole], place: Box::new(|p| [p[0], p[1], 0.0]) };
        let panels = [panel];
        let mesh = panels[0].mesh(0.02, &segments(&panels, 0.02));
        let area: f64 =
            mesh.triangles.iter().map(|t| cross2(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]])).sum();
        assert!((area / 2.0 - (0.16 - 0.0004)).abs() < 1e-9, "{area}");
        let mut open = std::collections::BTreeSet::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                if !open.remove(&(b, a)) {
                    open.insert((a, b));
                }
            }
        }
        assert_eq!(open.len(), 84);
    }
}
