//! A coarse stand-in for a surface, whose vertices are vertices of the original.
//!
//! Half-edge collapses in the order of the quadric error (Garland, Heckbert 1997) plus a length term that keeps flat
//! parts evenly triangulated. Only proxies for searches are made this way, never output.

mod collapse;

use collapse::prepare;

/// A coarse mesh.
#[derive(Clone, Debug)]
pub(crate) struct Coarse {
    /// For each coarse vertex, the original vertex it is.
    pub vertex: Vec<u32>,
    /// Triangles over the coarse vertices.
    pub triangles: Vec<[u32; 3]>,
    /// For each original vertex, the coarse vertex it was collapsed into: connected patches of the original.
    pub patch: Vec<u32>,
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

impl Hierarchy {
    /// The vertices left, and the triangles over these. `n` is the number of all vertices.
    pub(crate) fn coarse(&self, n: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
        let (vertex, triangles, _) = left(&self.triangles, &self.alive, n);
        (vertex, triangles)
    }

    /// Puts back the vertex of collapse `k`, which must be the last one that is not undone, and calls `each` with every
    /// triangle around it. Returns how many triangles came back.
    pub(crate) fn undo(&mut self, k: usize, mut each: impl FnMut([u32; 3])) -> usize {
        let [u, v] = self.collapses[k];
        let from = k.checked_sub(1).map_or(0, |k| self.ends[k]);
        let mut back = 0;
        for &t in &self.fans[from as usize..self.ends[k] as usize] {
            let t = t as usize;
            if self.alive[t] {
                self.triangles[t] = self.triangles[t].map(|x| if x == v { u } else { x });
            } else {
                self.alive[t] = true;
                back += 1;
            }
            each(self.triangles[t]);
        }
        back
    }

    /// The triangles now there, over the original vertices.
    pub(crate) fn now(&self) -> Vec<[u32; 3]> {
        self.triangles.iter().zip(&self.alive).filter(|x| *x.1).map(|x| *x.0).collect()
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
    if triangles.len() <= target {
        let (vertex, triangles, patch) = left(triangles, &vec![true; triangles.len()], n);
        return Coarse { vertex, triangles, patch };
    }
    let mut c = prepare(positions, triangles, boundary, locked, false);
    c.run(target, |_, _, _| {});
    let (vertex, triangles, index) = left(&c.triangles, &c.alive, n);
    let patch = (0..n)
        .map(|v| {
            let mut r = v;
            while c.into[r] as usize != r {
                r = c.into[r] as usize;
            }
            index[r]
        })
        .collect();
    Coarse { vertex, triangles, patch }
}

/// The rest of a mesh of `n` vertices: these, triangles over them, and the place of each vertex among them.
fn left(triangles: &[[u32; 3]], alive: &[bool], n: usize) -> (Vec<u32>, Vec<[u32; 3]>, Vec<u32>) {
    let (mut vertex, mut index, mut out) = (Vec::new(), vec![u32::MAX; n], Vec::new());
    for (t, _) in triangles.iter().zip(alive).filter(|x| *x.1) {
        for &v in t.iter() {
            if index[v as usize] == u32::MAX {
                index[v as usize] = vertex.len() as u32;
                vertex.push(v);
            }
        }
        out.push(t.map(|v| index[v as usize]));
    }
    (vertex, out, index)
}

/// Simplifies the inside of a disk to about `target` triangles. No edge is made between boundary vertices, so a map
/// onto a rectangle stays possible. O(n log n).
pub(crate) fn hierarchy(positions: &[[f64; 3]], triangles: &[[u32; 3]], boundary: &[bool], target: usize) -> Hierarchy {
    simplified(positions, triangles, boundary, target, false)
}

/// As [`hierarchy`], until one inner vertex is left: first while no triangle turns over, then by the link condition alone.
/// A disk without inner edges between boundary vertices always has such an order: of the edges between inner
/// vertices, one inside an innermost triangle of edges that is not a face keeps the link condition. O(n log n).
pub(crate) fn to_one(positions: &[[f64; 3]], triangles: &[[u32; 3]], boundary: &[bool]) -> Hierarchy {
    simplified(positions, triangles, boundary, 0, true)
}

fn simplified(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    boundary: &[bool],
    target: usize,
    to_one: bool,
) -> Hierarchy {
    let mut c = prepare(positions, triangles, boundary, boundary, true);
    let (mut collapses, mut ends, mut fans) = (Vec::new(), Vec::new(), Vec::new());
    let mut each = |u: u32, v: u32, fan: &[u32]| {
        collapses.push([u, v]);
        fans.extend_from_slice(fan);
        ends.push(fans.len() as u32);
    };
    c.run(target, &mut each);
    if to_one {
        c.bare = true;
        c.run(target, &mut each);
    }
    Hierarchy { triangles: c.triangles, alive: c.alive, collapses, ends, fans }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::halfedge;
    use crate::base::shapes;
    use crate::base::surface::Surface;
    use crate::base::topology::Topology;
    use proptest::prelude::*;

    fn check(s: &Surface, locked: &[bool], target: usize) -> Coarse {
        let c = decimate(&s.positions, &s.triangles, &shapes::rim(s), locked, target);
        let (a, b) = (Topology::of(&s.triangles), Topology::of(&c.triangles));
        assert_eq!((a.euler, a.boundary_loops, a.components), (b.euler, b.boundary_loops, b.components));
        assert_eq!((b.non_manifold_edges, b.singular_vertices), (0, 0));
        assert!(halfedge::twins(&c.triangles).is_ok());
        // Every patch is connected and holds its coarse vertex.
        let mut sets = gimage_bundle::DisjointSets::new(s.positions.len());
        for t in &s.triangles {
            for k in 0..3 {
                let (x, y) = (t[k], t[(k + 1) % 3]);
                if c.patch[x as usize] == c.patch[y as usize] {
                    sets.union(x, y);
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
