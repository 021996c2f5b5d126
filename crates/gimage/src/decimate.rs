//! A coarse stand-in for a surface, whose vertices are vertices of the original.
//!
//! Half-edge collapses in the order of the quadric error (Garland, Heckbert 1997) plus a length term that keeps flat
//! parts evenly triangulated. Only proxies for searches are made this way, never output.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::vec3::{cross, dot, norm, scale, sub};

/// A coarse mesh.
pub(crate) struct Coarse {
    /// For each coarse vertex, the original vertex it is.
    pub vertex: Vec<u32>,
    /// Triangles over the coarse vertices.
    pub triangles: Vec<[u32; 3]>,
    /// For each original vertex, the coarse vertex it was collapsed into: connected patches of the original.
    pub patch: Vec<u32>,
}

#[derive(Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    fn plane(n: [f64; 3], d: f64, w: f64) -> Self {
        let [a, b, c] = n;
        Self([a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d].map(|x| x * w))
    }

    fn add(&mut self, o: &Self) {
        self.0.iter_mut().zip(o.0).for_each(|(a, b)| *a += b);
    }

    fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let q = &self.0;
        q[0] * x * x
            + 2.0 * (q[1] * x * y + q[2] * x * z + q[3] * x)
            + q[4] * y * y
            + 2.0 * (q[5] * y * z + q[6] * y)
            + q[7] * z * z
            + 2.0 * q[8] * z
            + q[9]
    }
}

struct Collapser<'a> {
    positions: &'a [[f64; 3]],
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    around: Vec<Vec<u32>>,
    boundary: Vec<bool>,
    locked: Vec<bool>,
    quadric: Vec<Quadric>,
    area: Vec<f64>,
    version: Vec<u32>,
    into: Vec<u32>,
    centre: [f64; 3],
    /// What makes costs free of units.
    unit: f64,
    /// Vertices seen in the count at work carry its number.
    seen: Vec<u32>,
    count: u32,
    /// Inner vertices stay out of the boundary.
    apart: bool,
}

/// A simplified disk that remembers the way there. Its boundary is that of the original.
pub(crate) struct Hierarchy {
    /// Triangles over original vertices: those collapsed away as they last were.
    pub triangles: Vec<[u32; 3]>,
    /// Which of these are left.
    pub alive: Vec<bool>,
    /// In order: a vertex, and the one it was collapsed into.
    pub collapses: Vec<[u32; 2]>,
    /// Ends of the collapses' ranges in `fans`.
    pub ends: Vec<u32>,
    /// The triangles around each collapsed vertex.
    pub fans: Vec<u32>,
}

impl Collapser<'_> {
    /// The neighbours of `v`, ascending, into `out`.
    fn neighbours(&mut self, v: u32, out: &mut Vec<u32>) {
        self.count += 1;
        out.clear();
        for &t in &self.around[v as usize] {
            for w in self.triangles[t as usize] {
                if w != v && self.seen[w as usize] != self.count {
                    self.seen[w as usize] = self.count;
                    out.push(w);
                }
            }
        }
        out.sort_unstable();
    }

    fn shared(&self, u: u32, v: u32) -> usize {
        self.around[u as usize].iter().filter(|&&t| self.triangles[t as usize].contains(&v)).count()
    }

    /// The cheapest vertex to collapse `u` into, of those allowed now if `strict`; `around` is left with the neighbours of
    /// `u`.
    fn best(&mut self, u: u32, around: &mut Vec<u32>, strict: bool) -> Option<(f64, u32)> {
        if self.locked[u as usize] {
            return None;
        }
        self.neighbours(u, around);
        let mut best: Option<(f64, u32)> = None;
        for &v in &*around {
            if self.boundary[u as usize] && !(self.boundary[v as usize] && self.shared(u, v) == 1) {
                continue;
            }
            if self.apart && self.boundary[v as usize] {
                continue;
            }
            let p = sub(self.positions[v as usize], self.centre);
            let l2 = {
                let d = sub(self.positions[v as usize], self.positions[u as usize]);
                dot(d, d)
            };
            let cost = self.quadric[u as usize].at(p).max(0.0) + 1e-2 * l2 * self.area[u as usize];
            // Of equal costs the first counts, not the last bits.
            let cost = f64::from((cost * self.unit) as f32);
            if best.is_none_or(|b| cost < b.0) && (!strict || self.allowed(u, v, around)) {
                best = Some((cost, v));
            }
        }
        best
    }

    /// The link condition, and no triangle turns over. `around` are the neighbours of `u`.
    fn allowed(&mut self, u: u32, v: u32, around: &[u32]) -> bool {
        self.count += 1;
        for &t in &self.around[v as usize] {
            self.triangles[t as usize].iter().for_each(|&w| self.seen[w as usize] = self.count);
        }
        let common = around.iter().filter(|&&w| w != v && self.seen[w as usize] == self.count).count();
        let shared = self.shared(u, v);
        if common != shared || (self.boundary[u as usize] && self.boundary[v as usize] && shared != 1) {
            return false;
        }
        // Keep at least a triangle; two fans of three that share two triangles are a tetrahedron, which would be left as
        // two triangles back to back.
        let (fan_u, fan_v) = (self.around[u as usize].len(), self.around[v as usize].len());
        let closed = !self.boundary[u as usize] && !self.boundary[v as usize];
        if (fan_u <= shared && fan_v <= shared) || (closed && fan_u == 3 && fan_v == 3) {
            return false;
        }
        self.around[u as usize].iter().all(|&t| {
            let tri = self.triangles[t as usize];
            if tri.contains(&v) {
                return true;
            }
            let normal = |tri: [u32; 3]| {
                let [p, q, r] = tri.map(|x| self.positions[x as usize]);
                cross(sub(q, p), sub(r, p))
            };
            let (n, m) = (normal(tri), normal(tri.map(|x| if x == u { v } else { x })));
            dot(n, m) > 0.1 * norm(n) * norm(m)
        })
    }

    fn collapse(&mut self, u: u32, v: u32) -> usize {
        let fans = std::mem::take(&mut self.around[u as usize]);
        let mut gone = 0;
        self.into[u as usize] = v;
        for t in fans {
            let tri = self.triangles[t as usize];
            if tri.contains(&v) {
                self.alive[t as usize] = false;
                gone += 1;
                for w in tri {
                    self.around[w as usize].retain(|&x| x != t);
                }
            } else {
                self.triangles[t as usize] = tri.map(|x| if x == u { v } else { x });
                self.around[v as usize].push(t);
            }
        }
        let q = self.quadric[u as usize];
        self.quadric[v as usize].add(&q);
        self.area[v as usize] += self.area[u as usize];
        gone
    }
}

/// A mesh in which nothing is collapsed yet.
fn prepare<'a>(
    positions: &'a [[f64; 3]],
    triangles: &[[u32; 3]],
    boundary: &[bool],
    locked: &[bool],
    apart: bool,
) -> Collapser<'a> {
    let n = positions.len();
    let mut around = vec![Vec::new(); n];
    for (t, tri) in triangles.iter().enumerate() {
        tri.iter().for_each(|&v| around[v as usize].push(t as u32));
    }
    let centre = positions.first().copied().unwrap_or_default();
    let mut c = Collapser {
        positions,
        triangles: triangles.to_vec(),
        alive: vec![true; triangles.len()],
        around,
        boundary: boundary.to_vec(),
        locked: locked.to_vec(),
        quadric: vec![Quadric::default(); n],
        area: vec![0.0; n],
        version: vec![0; n],
        into: (0..n as u32).collect(),
        centre,
        unit: 1.0,
        seen: vec![0; n],
        count: 0,
        apart,
    };
    for tri in triangles {
        let [p, q, r] = tri.map(|v| sub(positions[v as usize], centre));
        let m = cross(sub(q, p), sub(r, p));
        let area = norm(m);
        if area > 0.0 {
            let unit = scale(m, 1.0 / area);
            let quadric = Quadric::plane(unit, -dot(unit, p), area);
            for &v in tri {
                c.quadric[v as usize].add(&quadric);
                c.area[v as usize] += area;
            }
        }
    }
    let total: f64 = c.area.iter().sum();
    c.unit = 1.0 / (total * total).max(1e-300);
    c
}

impl Collapser<'_> {
    /// Collapses until about `target` triangles are left; `each` sees every collapse before it is made.
    fn run(&mut self, target: usize, mut each: impl FnMut(u32, u32, &[u32])) {
        let n = self.positions.len() as u32;
        let mut heap: BinaryHeap<Reverse<(u64, u32, u32, u32)>> = BinaryHeap::with_capacity(n as usize);
        let mut around = Vec::new();
        // Most collapses are allowed, so that is looked at only for those whose turn has come.
        let mut push = |heap: &mut BinaryHeap<_>, c: &mut Self, u: u32, strict: bool| {
            if let Some((cost, v)) = c.best(u, &mut around, strict) {
                heap.push(Reverse((cost.to_bits(), u, v, c.version[u as usize])));
            }
        };
        (0..n).for_each(|u| push(&mut heap, self, u, false));
        let mut ring = Vec::new();
        let mut left = self.triangles.len();
        while left > target {
            let Some(Reverse((_, u, v, version))) = heap.pop() else { break };
            if version != self.version[u as usize]
                || self.around[u as usize].is_empty()
                || self.around[v as usize].is_empty()
            {
                continue;
            }
            self.neighbours(u, &mut ring);
            if !self.allowed(u, v, &ring) {
                push(&mut heap, self, u, true);
                continue;
            }
            each(u, v, &self.around[u as usize]);
            left -= self.collapse(u, v);
            self.version[u as usize] += 1;
            for &w in &ring {
                self.version[w as usize] += 1;
                push(&mut heap, self, w, false);
            }
        }
    }
}

/// Simplifies an edge-manifold mesh to about `target` triangles. `locked` vertices stay. O(n log n).
pub(crate) fn decimate(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    boundary: &[bool],
    locked: &[bool],
    target: usize,
) -> Coarse {
    let n = positions.len();
    let mut c = prepare(positions, triangles, boundary, locked, false);
    c.run(target, |_, _, _| {});
    let mut index = vec![u32::MAX; n];
    let mut coarse = Coarse { vertex: Vec::new(), triangles: Vec::new(), patch: Vec::new() };
    for (tri, _) in c.triangles.iter().zip(&c.alive).filter(|(_, a)| **a) {
        let t = tri.map(|v| {
            if index[v as usize] == u32::MAX {
                index[v as usize] = coarse.vertex.len() as u32;
                coarse.vertex.push(v);
            }
            index[v as usize]
        });
        coarse.triangles.push(t);
    }
    coarse.patch = (0..n)
        .map(|v| {
            let mut r = v;
            while c.into[r] as usize != r {
                r = c.into[r] as usize;
            }
            index[r]
        })
        .collect();
    coarse
}

/// Simplifies the inside of a disk to about `target` triangles. No edge is made between boundary vertices, so a map
/// onto a rectangle stays possible. O(n log n).
pub(crate) fn hierarchy(positions: &[[f64; 3]], triangles: &[[u32; 3]], boundary: &[bool], target: usize) -> Hierarchy {
    let mut c = prepare(positions, triangles, boundary, boundary, true);
    let (mut collapses, mut ends, mut fans) = (Vec::new(), Vec::new(), Vec::new());
    c.run(target, |u, v, fan| {
        collapses.push([u, v]);
        fans.extend_from_slice(fan);
        ends.push(fans.len() as u32);
    });
    Hierarchy { triangles: c.triangles, alive: c.alive, collapses, ends, fans }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use crate::topology::Topology;
    use crate::{halfedge, shapes};
    use proptest::prelude::*;

    fn check(s: &Surface, locked: &[bool], target: usize) -> Coarse {
        let c = decimate(&s.positions, &s.triangles, &shapes::rim(s), locked, target);
        let (a, b) = (Topology::of(&s.triangles), Topology::of(&c.triangles));
        assert_eq!((a.euler, a.boundary_loops, a.components), (b.euler, b.boundary_loops, b.components));
        assert_eq!((b.non_manifold_edges, b.singular_vertices), (0, 0));
        assert!(halfedge::twins(&c.triangles).is_ok());
        // Every patch is connected and holds its coarse vertex.
        let mut sets = crate::disjoint::Disjoint::new(s.positions.len());
        for t in &s.triangles {
            for k in 0..3 {
                let (x, y) = (t[k], t[(k + 1) % 3]);
                if c.patch[x as usize] == c.patch[y as usize] {
                    sets.join(x, y);
                }
            }
        }
        let set = sets.into_representatives();
        for (v, &k) in c.patch.iter().enumerate() {
            assert_eq!(set[v], set[c.vertex[k as usize] as usize], "a patch in pieces");
        }
        for (v, _) in locked.iter().enumerate().filter(|x| *x.1) {
            assert_eq!(c.vertex[c.patch[v] as usize] as usize, v);
        }
        c
    }

    #[test]
    fn every_shape_keeps_its_topology_however_coarse() {
        for (_, s) in shapes::all() {
            let none = vec![false; s.positions.len()];
            check(&s, &none, 0);
            check(&s, &none, s.triangles.len() / 2);
            let mut draw = shapes::random(1);
            let some: Vec<bool> = none.iter().map(|_| draw(5) == 0).collect();
            check(&s, &some, 0);
        }
    }

    #[test]
    fn a_flat_tetrahedron_is_left_alone() {
        // Flat enough that no facet turns over when one end of an edge moves to the other.
        let p = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.7, 1e-3]];
        let s = shapes::surface(p, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
        assert_eq!(check(&s, &[false; 4], 0).triangles.len(), 4);
    }

    #[test]
    fn nothing_is_done_where_nothing_is_to_do() {
        let s = shapes::torus(8, 6);
        let c = check(&s, &vec![false; s.positions.len()], s.triangles.len());
        assert_eq!(c.triangles.len(), s.triangles.len());
        assert!(decimate(&[], &[], &[], &[], 10).triangles.is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn random_blobs_keep_their_topology(seed in any::<u64>(), cells in 1usize..100, holes in 0usize..20, target in 0usize..200) {
            let s = shapes::blob(seed, cells, holes);
            check(&s, &vec![false; s.positions.len()], target);
        }
    }
}
