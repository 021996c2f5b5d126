//! One part of a surface, cut loose from the rest but knowing where it came from.

use gimage_bundle::DisjointSets;

use crate::base::graph::EdgeGraph;
use crate::base::halfedge::{BOUNDARY, next, origin};
use crate::base::surface::Surface;

/// Some connected triangles of a surface as a surface of their own.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Manifold: a vertex where the part touches itself is there once for each fan.
    pub surface: Surface,
    /// For each vertex, that of the whole.
    pub vertex: Vec<u32>,
    /// For each triangle, that of the whole; the corners keep their order.
    pub triangles: Vec<u32>,
}

/// Cuts `triangles` (ascending) of `whole` loose. O(n log n) in the part, and O(1) in the whole.
pub(super) fn extract(whole: &Surface, graph: &EdgeGraph, triangles: &[u32]) -> Part {
    let local = |t: u32| triangles.binary_search(&t).ok().map(|k| k as u32);
    let mut fans = DisjointSets::new(3 * triangles.len());
    for (k, &t) in triangles.iter().enumerate() {
        for c in 0..3 {
            let h = 3 * t + c;
            let [a, b] = graph.halves[graph.of_half[h as usize] as usize];
            if b == BOUNDARY {
                continue;
            }
            let w = a ^ b ^ h;
            let Some(other) = local(w / 3).filter(|_| w > h) else { continue };
            let here = |h: u32, k: u32| 3 * k + h % 3;
            let k = k as u32;
            let same = origin(&whole.triangles, h) == origin(&whole.triangles, w);
            let (x, y) = (here(w, other), here(next(w), other));
            let (start, end) = if same { (x, y) } else { (y, x) };
            fans.union(here(h, k), start);
            fans.union(here(next(h), k), end);
        }
    }
    let fan = fans.into_representatives();
    let source = |corner: u32| whole.triangles[triangles[corner as usize / 3] as usize][corner as usize % 3];
    let mut firsts: Vec<(u32, u32)> =
        (0..fan.len() as u32).filter(|&c| fan[c as usize] == c).map(|c| (source(c), c)).collect();
    firsts.sort_unstable();
    let mut number = vec![0u32; fan.len()];
    firsts.iter().enumerate().for_each(|(k, x)| number[x.1 as usize] = k as u32);
    let at = |k: usize| [0, 1, 2].map(|c| number[fan[3 * k + c] as usize]);
    let of = |list: &[u32]| triangles.iter().map(|&t| list[t as usize]).collect();
    Part {
        surface: Surface {
            positions: firsts.iter().map(|x| whole.positions[x.0 as usize]).collect(),
            triangles: (0..triangles.len()).map(at).collect(),
            source_triangle: of(&whole.source_triangle),
            first_corner: triangles.iter().map(|&t| whole.first_corner[t as usize]).collect(),
        },
        vertex: firsts.iter().map(|x| x.0).collect(),
        triangles: triangles.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::stage::cut::Cutter;

    #[test]
    fn a_part_is_a_manifold_that_knows_its_place() {
        for (name, s) in shapes::all() {
            let graph = EdgeGraph::new(&s.positions, &s.triangles);
            let n = s.triangles.len() as u32;
            // A comb of triangles touches itself at many points.
            for pick in [|t: u32, _: u32| t % 3 != 2, |t: u32, n: u32| t < n / 2, |_: u32, _: u32| true] {
                let list: Vec<u32> = (0..n).filter(|&t| pick(t, n)).collect();
                if list.is_empty() {
                    continue;
                }
                let part = extract(&s, &graph, &list);
                for (k, &t) in list.iter().enumerate() {
                    let back = part.surface.triangles[k].map(|v| part.vertex[v as usize]);
                    assert_eq!(back, s.triangles[t as usize], "{name}");
                    assert_eq!(part.surface.corners(k), s.corners(t as usize));
                    assert_eq!(part.surface.source_triangle[k], s.source_triangle[t as usize]);
                }
                assert!(part.vertex.is_sorted());
                assert!(Cutter::new(&part.surface).is_some(), "{name}: not a manifold");
            }
        }
    }
}
