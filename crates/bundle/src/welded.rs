//! The surface that pieces weld to, and its topology: section 5 of FORMAT.md.

use crate::bundle::Bundle;
use crate::counts::piece_particles;
use crate::disjoint::DisjointSets;
use crate::map::MapKind;
use crate::particle::Particle;
use crate::rings::Rings;

/// The result of welding some pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Welded {
    /// Vertices - edges + triangles.
    pub euler: i64,
    /// Connected components of the edges with one triangle.
    pub loops: usize,
    /// Components, joined by shared vertices.
    pub components: usize,
    /// Edges with three triangles or more.
    pub non_manifold_edges: usize,
}

/// The topology of the surface that some pieces weld to. `particles` and `rings` are those of the bundle. O(n log n) in the
/// texels of the pieces, O(n) in those of the bundle.
pub(crate) fn welded(bundle: &Bundle, pieces: &[usize], particles: &[Particle], rings: &Rings) -> Welded {
    let mut vertex: Vec<u32> = (0..particles.len() as u32).collect();
    for ring in rings.iter() {
        ring.iter().for_each(|&k| vertex[k as usize] = ring[0]);
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for &index in pieces {
        let Some(piece) = bundle.manifest.pieces.get(index) else { continue };
        let own = piece_particles(piece, particles);
        let Some(image) = bundle.image(index, &MapKind::Position).filter(|_| !own.is_empty()) else { continue };
        let distance = |a: u32, b: u32| -> f64 {
            let (a, b) = (image.at(a as usize), image.at(b as usize));
            (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum::<f64>().sqrt()
        };
        for j in 1..piece.height {
            for i in 1..piece.width {
                let c = j * piece.width + i;
                let quad = [c - piece.width - 1, c - piece.width, c, c - 1];
                let [p, q, r, s] = quad;
                let there: Vec<u32> = quad.into_iter().filter(|&k| own[k as usize].exists()).collect();
                let split = match there[..] {
                    [_, _, _, _] if distance(p, r) <= distance(q, s) => vec![[p, q, r], [p, r, s]],
                    [_, _, _, _] => vec![[p, q, s], [q, r, s]],
                    [a, b, c] => vec![[a, b, c]],
                    _ => continue,
                };
                let weld = |k: u32| vertex[(piece.first_particle + k) as usize];
                let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
                triangles.extend(split.into_iter().map(|t| t.map(weld)).filter(whole));
            }
        }
    }
    topology(&triangles, particles.len())
}

fn topology(triangles: &[[u32; 3]], vertices: usize) -> Welded {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    let (mut all, mut border) = (DisjointSets::new(vertices), DisjointSets::new(vertices));
    let (mut used, mut on_border) = (vec![false; vertices], vec![false; vertices]);
    let (mut count, mut out) = (0i64, Welded::default());
    for run in edges.chunk_by(|x, y| x == y) {
        let [a, b] = run[0];
        count += 1;
        all.union(a, b);
        (used[a as usize], used[b as usize]) = (true, true);
        if run.len() == 1 {
            border.union(a, b);
            (on_border[a as usize], on_border[b as usize]) = (true, true);
        }
        out.non_manifold_edges += usize::from(run.len() > 2);
    }
    out.euler = used.iter().filter(|u| **u).count() as i64 - count + triangles.len() as i64;
    out.loops = border.count(&on_border);
    out.components = all.count(&used);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::tests::sample;
    use crate::manifest::{ComponentEntry, Surface};
    use crate::validate::{FaultKind, validate};

    #[test]
    fn parts_weld_to_their_component_or_are_named() {
        // The sample is a tube in one piece: a component of one part.
        let mut bundle = sample();
        let surface = Surface { euler: 0, loops: 2, ..Surface::default() };
        bundle.manifest.components = vec![ComponentEntry { name: "shirt".into(), surface }];
        bundle.manifest.pieces[0].part_of = Some(0);
        assert_eq!(validate(&bundle), []);
        for (euler, loops) in [(1, 2), (0, 1), (2, 0)] {
            let mut wrong = bundle.clone();
            wrong.manifest.components[0].surface = Surface { euler, loops, ..Surface::default() };
            let faults = validate(&wrong);
            let named = |f: &crate::Fault| f.kind == FaultKind::Topology && f.message.contains("shirt");
            assert!(faults.len() == 1 && named(&faults[0]), "{faults:?}");
        }
        let mut lost = bundle.clone();
        lost.manifest.pieces[0].part_of = None;
        assert!(validate(&lost).iter().any(|f| f.kind == FaultKind::Manifest && f.message.contains("shirt")));
        let mut past = bundle;
        past.manifest.pieces[0].part_of = Some(1);
        assert!(validate(&past)[0].message.contains("part_of"));
    }

    #[test]
    fn a_tetrahedron_and_a_triangle_are_counted() {
        let four = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert_eq!(topology(&four, 4), Welded { euler: 2, loops: 0, components: 1, non_manifold_edges: 0 });
        assert_eq!(topology(&four[..1], 9), Welded { euler: 1, loops: 1, components: 1, non_manifold_edges: 0 });
        assert_eq!(topology(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 5).non_manifold_edges, 1);
        assert_eq!(topology(&[], 0), Welded::default());
    }
}
