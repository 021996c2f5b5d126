//! Connected components with their counts.

use gimage_bundle::DisjointSets;

use super::Component;
use crate::base::halfedge::{origin, sorted_edges};
use crate::base::mesh::Mesh;

/// The components in the order of their first triangles, without names. An edge with more than two triangles, which a
/// repaired mesh does not have, counts as an edge and joins, no more. O(n log n).
pub(super) fn components(mesh: &Mesh) -> Vec<Component> {
    let tri = &mesh.triangles;
    let mut by_vertex = DisjointSets::new(mesh.positions.len());
    for &[a, b, c] in tri {
        by_vertex.union(a, b);
        by_vertex.union(b, c);
    }
    const NONE: usize = usize::MAX;
    let mut of_vertex = vec![NONE; mesh.positions.len()];
    let mut out: Vec<Component> = Vec::new();
    for (t, v) in tri.iter().enumerate() {
        let root = by_vertex.find(v[0]) as usize;
        if of_vertex[root] == NONE {
            of_vertex[root] = out.len();
            out.push(Component {
                triangles: Vec::new(),
                name: String::new(),
                area: 0.0,
                euler: 0,
                loops: 0,
                orientable: true,
                genus: 0,
                bounds: ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
                lies_on: None,
            });
        }
        let c = &mut out[of_vertex[root]];
        c.triangles.push(t as u32);
        c.area += mesh.triangle_area(t);
        c.euler += 1;
        for p in mesh.corners(t) {
            for (k, x) in p.into_iter().enumerate() {
                c.bounds.0[k] = c.bounds.0[k].min(x);
                c.bounds.1[k] = c.bounds.1[k].max(x);
            }
        }
    }
    let mut used = vec![false; mesh.positions.len()];
    tri.iter().flatten().for_each(|&v| used[v as usize] = true);
    for v in (0..used.len()).filter(|&v| used[v]) {
        let c = of_vertex[by_vertex.find(v as u32) as usize];
        of_vertex[v] = c;
        out[c].euler += 1;
    }
    edges(mesh, &of_vertex, &mut out);
    for c in &mut out {
        let missing = (2 - c.euler - c.loops as i64).max(0) as u32;
        c.genus = if c.orientable { missing / 2 } else { missing };
    }
    out
}

/// Counts edges and boundary loops, and finds out which components have two sides.
fn edges(mesh: &Mesh, of_vertex: &[usize], out: &mut [Component]) {
    let tri = &mesh.triangles;
    // Triangle `t` as it is and turned over: one-sided is where both end up in one set.
    let (mut sides, n) = (DisjointSets::new(2 * tri.len()), tri.len() as u32);
    let mut rims = DisjointSets::new(mesh.positions.len());
    let mut on_rim = vec![false; mesh.positions.len()];
    for run in sorted_edges(tri).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        out[of_vertex[run[0].0 as usize]].euler -= 1;
        match run {
            [(a, b, _)] => {
                rims.union(*a, *b);
                on_rim[*a as usize] = true;
                on_rim[*b as usize] = true;
            }
            [(_, _, h), (_, _, g)] => {
                let flip = if origin(tri, *h) == origin(tri, *g) { n } else { 0 };
                sides.union(h / 3, g / 3 + flip);
                sides.union(h / 3 + n, g / 3 + n - flip);
            }
            _ => {}
        }
    }
    // A vertex of a manifold has two rim edges, so rims connected by vertices are loops.
    for v in (0..on_rim.len()).filter(|&v| on_rim[v] && rims.find(v as u32) == v as u32) {
        out[of_vertex[v]].loops += 1;
    }
    for c in out {
        c.orientable = c.triangles.iter().all(|&t| sides.find(t) != sides.find(t + n));
    }
}
