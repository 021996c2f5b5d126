//! Gives each fan of triangles around a vertex a vertex of its own.
//!
//! Two corners share a vertex if triangles joined across edges lead from one to the other. That takes apart bow ties
//! (fans that touch in a vertex only) and sheets that touched along a crowded edge, in one go.

use gimage_bundle::DisjointSets;

use super::nonmanifold::Gluing;
use super::work::Work;
use crate::base::halfedge::{BOUNDARY, next, origin, prev};
use crate::base::words;
use crate::record::Severity;

/// Splits vertices until every edge has at most two triangles and every vertex one fan. O(n log n) unless the surface
/// runs back into its own crowded edges over and over.
pub(super) fn split_vertices(work: &mut Work, gluing: &mut Gluing) {
    let mut slits = 0;
    let mut sets = fans(work, gluing);
    while let n @ 1.. = detach(work, gluing, &mut sets) {
        slits += n;
        sets = fans(work, gluing);
    }
    close_pairs(work, gluing, &mut sets);

    let crowded_ends: Vec<bool> = {
        let mut ends = vec![false; work.mesh.positions.len()];
        for &h in gluing.crowded.iter().flatten() {
            ends[origin(&work.mesh.triangles, h) as usize] = true;
            ends[origin(&work.mesh.triangles, next(h)) as usize] = true;
        }
        ends
    };
    report_edges(work, gluing, slits);

    // The fan with the first corner keeps the vertex; the others get copies, in the order of their first corners.
    const UNSEEN: u32 = u32::MAX;
    let mut owner = vec![UNSEEN; work.mesh.positions.len()];
    let mut name = vec![UNSEEN; 3 * work.len()];
    let mut ties: Vec<u32> = Vec::new();
    for c in 0..3 * work.len() as u32 {
        let root = sets.find(c) as usize;
        let (t, k) = (c as usize / 3, c as usize % 3);
        if name[root] == UNSEEN {
            let v = work.mesh.triangles[t][k];
            name[root] = if owner[v as usize] == UNSEEN {
                owner[v as usize] = root as u32;
                v
            } else {
                if !crowded_ends[v as usize] {
                    ties.push(v);
                }
                work.mesh.positions.push(work.mesh.positions[v as usize]);
                work.mesh.positions.len() as u32 - 1
            };
        }
        // Safe to write at once: the vertex of a corner is read only when its fan is met first.
        work.mesh.triangles[t][k] = name[root];
    }
    let copies = ties.len();
    ties.sort_unstable();
    ties.dedup();
    let examples = ties.iter().take(4).map(|&v| work.vertex_words(v)).collect();
    let copies = words::counted(copies, "copy", "copies");
    let message =
        format!("{} where fans of triangles touched in a point only got {copies}", words::vertices(ties.len()));
    work.report(Severity::Repair, "bow-tie-vertices", ties.len(), examples, message);
}

/// The sets of corners that joined triangles connect.
fn fans(work: &Work, gluing: &Gluing) -> DisjointSets {
    let tri = &work.mesh.triangles;
    let mut sets = DisjointSets::new(3 * tri.len());
    for h in 0..gluing.twin.len() as u32 {
        let t = gluing.twin[h as usize];
        if t == BOUNDARY || t < h {
            continue;
        }
        let (a, b) = if origin(tri, h) == origin(tri, t) { (t, next(t)) } else { (next(t), t) };
        sets.union(h, a);
        sets.union(next(h), b);
    }
    sets
}

/// The half-edges of a crowded edge that still share both vertices, as (fan at the smaller vertex, fan at the larger,
/// half-edge), in runs that keep the order of the edge.
fn shared(work: &Work, sets: &mut DisjointSets, edge: &[u32]) -> Vec<(u32, u32, u32)> {
    let tri = &work.mesh.triangles;
    let mut all: Vec<_> = edge
        .iter()
        .map(|&h| {
            let (from, to) = (sets.find(h), sets.find(next(h)));
            if origin(tri, h) < origin(tri, next(h)) { (from, to, h) } else { (to, from, h) }
        })
        .collect();
    all.sort_by_key(|x| (x.0, x.1));
    all
}

/// A sheet may leave a crowded edge and come back to it, around both ends; then its corners there are one fan although
/// it is not joined across the edge. All but one pair are cut loose at the smaller vertex, by a slit along the next
/// edge. Returns the number of slits; fans only ever get smaller, so this ends.
fn detach(work: &Work, gluing: &mut Gluing, sets: &mut DisjointSets) -> usize {
    let tri = &work.mesh.triangles;
    let mut slits = 0;
    let crowded = std::mem::take(&mut gluing.crowded);
    for edge in &crowded {
        for run in shared(work, sets, edge).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|run| run.len() > 2) {
            let stays = run.iter().map(|x| x.2).find(|&h| gluing.twin[h as usize] != BOUNDARY).unwrap_or(run[0].2);
            let with = gluing.twin[stays as usize];
            for h in run.iter().map(|x| x.2).filter(|&h| h != stays && h != with) {
                // The other edge of this triangle at the smaller vertex of the crowded one.
                let side = if origin(tri, h) < origin(tri, next(h)) { prev(h) } else { next(h) };
                if gluing.twin[side as usize] != BOUNDARY {
                    gluing.part(side);
                    slits += 1;
                }
            }
        }
    }
    gluing.crowded = crowded;
    slits
}

/// Two open half-edges left with the same two vertices are joined: indices cannot tell them apart.
fn close_pairs(work: &Work, gluing: &mut Gluing, sets: &mut DisjointSets) {
    for edge in gluing.crowded.clone() {
        for run in shared(work, sets, &edge).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [x, y] = run {
                gluing.join(x.2, y.2);
            }
        }
    }
}

fn report_edges(work: &mut Work, gluing: &Gluing, slits: usize) {
    let examples = gluing.crowded.iter().take(4).map(|edge| {
        let h = edge[0];
        let a = work.vertex_words(origin(&work.mesh.triangles, h));
        let b = work.vertex_words(origin(&work.mesh.triangles, next(h)));
        format!("{} between {a} and {b}", words::triangles(edge.len()))
    });
    let examples = examples.collect();
    let count = gluing.crowded.len();
    let mut message = format!(
        "{} with three or more triangles: the straightest pairs stay joined, the others were detached",
        words::edges(count)
    );
    if slits > 0 {
        let slits = words::counted(slits, "slit", "slits");
        message += &format!(", with {slits} where a sheet ran back into its own edge");
    }
    work.report(Severity::Repair, "non-manifold-edges", count, examples, message);
}

#[cfg(test)]
mod tests {
    use super::super::nonmanifold::glue;
    use super::*;
    use crate::base::halfedge::twins;
    use crate::base::mesh::Mesh;

    fn split(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Work {
        let mut w = Work::new(Mesh { positions, triangles, ..Default::default() });
        let mut g = glue(&w, &Default::default());
        split_vertices(&mut w, &mut g);
        assert_eq!(twins(&w.mesh.triangles).unwrap(), g.twin);
        w
    }

    #[test]
    fn a_bow_tie_comes_apart() {
        let p = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
        let w = split(p, vec![[0, 1, 2], [0, 3, 4]]);
        assert_eq!(w.mesh.triangles, [[0, 1, 2], [5, 3, 4]]);
        assert_eq!((w.findings[0].kind, w.findings[0].count), ("bow-tie-vertices", 1));
    }

    #[test]
    fn the_straight_pair_stays_joined() {
        // A wall (0 1 4) on a floor of two.
        let p = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]];
        let w = split(p, vec![[0, 1, 4], [0, 1, 2], [1, 0, 3]]);
        assert_eq!(w.mesh.triangles, [[0, 1, 4], [5, 6, 2], [6, 5, 3]]);
        assert_eq!((w.findings[0].kind, w.findings[0].count), ("non-manifold-edges", 1));
        assert_eq!(w.findings.len(), 1);
    }

    #[test]
    fn four_triangles_make_two_sheets() {
        let p = vec![[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.]];
        let w = split(p, vec![[0, 1, 2], [0, 1, 4], [1, 0, 3], [1, 0, 5]]);
        assert_eq!(w.mesh.triangles, [[0, 1, 2], [6, 7, 4], [1, 0, 3], [7, 6, 5]]);
    }
}
