//! The topology of a triangle mesh, counted without assuming that it is a manifold.

use gimage_bundle::DisjointSets;

use crate::base::halfedge::{Used, next, origin, sorted_edges};
use serde::Serialize;

/// Counts of the elements and the faults of a triangle mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Topology {
    /// Vertices that triangles use.
    pub vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Vertices - edges + triangles.
    pub euler: i64,
    /// Connected components of the edges with one triangle.
    pub boundary_loops: usize,
    /// Edges with one triangle.
    pub boundary_edges: usize,
    /// Edges with three triangles or more.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles run along it the same way.
    pub misoriented_edges: usize,
    /// Vertices where two fans of triangles or more touch (bow ties).
    pub singular_vertices: usize,
    /// Components, joined by shared vertices.
    pub components: usize,
}

impl Topology {
    /// Counts. Triangles must not repeat a vertex.
    pub fn of(triangles: &[[u32; 3]]) -> Self {
        let all = sorted_edges(triangles);
        let vertices = Used::new(triangles);
        let (used, index) = (vertices.count, |v: u32| vertices.number(v));
        let mut components = DisjointSets::new(used);
        let mut border = DisjointSets::new(used);
        let mut on_border = vec![false; used];
        // Corners of one vertex that share an edge with two triangles belong to one fan.
        let mut fans = DisjointSets::new(3 * triangles.len());
        let mut out = Self { vertices: used, triangles: triangles.len(), ..Self::default() };
        for run in all.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let (a, b) = (index(run[0].0), index(run[0].1));
            out.edges += 1;
            components.union(a, b);
            match run {
                [_] => {
                    out.boundary_edges += 1;
                    border.union(a, b);
                    on_border[a as usize] = true;
                    on_border[b as usize] = true;
                }
                [x, y] => {
                    let (x, y) = (x.2, y.2);
                    let same_way = origin(triangles, x) == origin(triangles, y);
                    out.misoriented_edges += same_way as usize;
                    // The corner at the end of a half-edge is the origin of the next one.
                    let (xe, ye) = (next(x), next(y));
                    let (at_start, at_end) = if same_way { (y, ye) } else { (ye, y) };
                    fans.union(x, at_start);
                    fans.union(xe, at_end);
                }
                _ => out.non_manifold_edges += 1,
            }
        }
        out.euler = out.vertices as i64 - out.edges as i64 + out.triangles as i64;
        out.components = components.count(&vec![true; used]);
        out.boundary_loops = border.count(&on_border);
        let mut fans_at = vec![0u32; used];
        for (h, root) in fans.into_representatives().into_iter().enumerate() {
            if root as usize == h {
                fans_at[index(triangles[h / 3][h % 3]) as usize] += 1;
            }
        }
        out.singular_vertices = fans_at.iter().filter(|&&n| n > 1).count();
        out
    }

    /// Whether it is an oriented manifold, with or without boundary.
    pub fn is_oriented_manifold(&self) -> bool {
        self.non_manifold_edges == 0 && self.misoriented_edges == 0 && self.singular_vertices == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_a_sphere() {
        let t = Topology::of(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
        assert_eq!((t.euler, t.boundary_loops, t.components), (2, 0, 1));
        assert!(t.is_oriented_manifold());
    }

    #[test]
    fn a_bow_tie_is_singular() {
        let t = Topology::of(&[[0, 1, 2], [0, 3, 4]]);
        assert_eq!((t.singular_vertices, t.components, t.euler), (1, 1, 1));
    }

    #[test]
    fn defects_are_counted() {
        assert_eq!(Topology::of(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).non_manifold_edges, 1);
        assert_eq!(Topology::of(&[[0, 1, 2], [0, 1, 3]]).misoriented_edges, 1);
        assert_eq!(Topology::of(&[]), Topology::default());
        assert_eq!(Topology::of(&[[7, 1 << 30, u32::MAX], [u32::MAX, 1 << 30, 3]]).vertices, 4);
        let two = Topology::of(&[[5, 6, 7], [9, 10, 11]]);
        assert_eq!((two.components, two.boundary_loops, two.boundary_edges), (2, 2, 6));
    }
}
