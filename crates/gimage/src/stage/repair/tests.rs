//! Whatever goes in, an oriented manifold comes out.

use proptest::prelude::*;

use super::*;
use crate::base::halfedge::{self, BOUNDARY};
use crate::base::mesh::{Channel, Semantic};
use crate::error::Error;
use crate::stage::component::{ComponentOptions, split};

fn area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| mesh.triangle_area(t)).sum()
}

/// Checks the guarantees of [`Repaired`]; `one_sided` says that pieces that are not orientable may be there.
fn check(mesh: &Mesh, one_sided: bool) {
    let tri = &mesh.triangles;
    assert_eq!(mesh.triangle_part.len(), tri.len());
    mesh.channels.iter().for_each(|c| assert_eq!(c.corners.len(), 3 * tri.len()));
    assert!(tri.iter().all(|[a, b, c]| a != b && b != c && c != a));
    let twin = halfedge::twins(tri).expect("at most two triangles an edge");
    let mut fans = UnionCorners::new(tri.len());
    for h in 0..twin.len() as u32 {
        let t = twin[h as usize];
        if t == BOUNDARY {
            continue;
        }
        let same_way = halfedge::origin(tri, h) == halfedge::origin(tri, t);
        assert!(one_sided || !same_way, "neighbours wind alike");
        let (a, b) = if same_way { (t, halfedge::next(t)) } else { (halfedge::next(t), t) };
        fans.0.union(h, a);
        fans.0.union(halfedge::next(h), b);
    }
    let roots = (0..twin.len() as u32).filter(|&c| fans.0.find(c) == c).count();
    assert_eq!(roots, mesh.positions.len(), "every vertex is used and has one fan");
    assert!(halfedge::boundary_loops(tri, &twin).is_some());
}

struct UnionCorners(gimage_bundle::DisjointSets);

impl UnionCorners {
    fn new(triangles: usize) -> Self {
        UnionCorners(gimage_bundle::DisjointSets::new(3 * triangles))
    }
}

fn counts(findings: &[Finding]) -> Vec<(&'static str, u64)> {
    findings.iter().map(|f| (f.kind, f.count)).collect()
}

fn soup(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let n = triangles.len();
    // The channel copies positions, so that corners can be checked after any edit.
    let values = positions.iter().flatten().map(|&x| x as f32).collect();
    let corners = triangles.iter().flatten().copied().collect();
    let channels = vec![Channel { semantic: Semantic::Custom("_COPY".into()), width: 3, values, corners }];
    Mesh { positions, triangles, triangle_part: vec![0; n], channels, ..Default::default() }
}

/// Few vertices on a coarse lattice: coincident, collinear, doubled and crowded are the rule.
fn lattice() -> impl Strategy<Value = Mesh> {
    let corner = (0..3i32, 0..3i32, 0..2i32).prop_map(|(x, y, z)| [f64::from(x), f64::from(y), f64::from(z)]);
    (prop::collection::vec(corner, 3..14)).prop_flat_map(|p| {
        let n = p.len() as u32;
        prop::collection::vec([0..n, 0..n, 0..n], 0..60).prop_map(move |t| soup(p.clone(), t))
    })
}

/// Few vertices anywhere.
fn scattered() -> impl Strategy<Value = Mesh> {
    prop::collection::vec([-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64], 4..10).prop_flat_map(|p| {
        let n = p.len() as u32;
        prop::collection::vec([0..n, 0..n, 0..n], 0..60).prop_map(move |t| soup(p.clone(), t))
    })
}

fn sound_and_stable(mesh: Mesh) {
    let before = area(&mesh);
    let once = repair(mesh, &RepairOptions::default()).unwrap();
    let one_sided = once.findings.iter().any(|f| f.kind == "not-orientable");
    check(&once.mesh, one_sided);
    assert!(area(&once.mesh) <= before * (1.0 + 1e-9) + 1e-15);
    for t in 0..once.mesh.triangles.len() {
        for (c, p) in once.mesh.corners(t).iter().enumerate() {
            assert_eq!(once.mesh.channels[0].at(t, c).unwrap(), p.map(|x| x as f32));
        }
    }
    let components = split(&once.mesh, &ComponentOptions { accessory_area: 0.0 });
    assert_eq!(components.pieces.iter().any(|c| !c.orientable), one_sided);
    assert_eq!(components.pieces.iter().map(|c| c.triangles.len()).sum::<usize>(), once.mesh.triangles.len());
    let twice = repair_joined(once.mesh.clone());
    assert_eq!(twice.mesh, once.mesh);
    assert!(twice.findings.iter().all(|f| f.severity == Severity::Note), "{:?}", twice.findings);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..Default::default() })]

    #[test]
    fn lattice_soups_become_manifolds(mesh in lattice()) {
        sound_and_stable(mesh);
    }

    #[test]
    fn scattered_soups_become_manifolds(mesh in scattered()) {
        sound_and_stable(mesh);
    }

    #[test]
    fn the_order_of_triangles_does_not_matter(mesh in scattered(), seed in any::<u64>()) {
        let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
        let mut s = seed | 1;
        for i in (1..order.len()).rev() {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            order.swap(i, (s >> 33) as usize % (i + 1));
        }
        let shuffled = soup(mesh.positions.clone(), order.iter().map(|&t| mesh.triangles[t]).collect());
        let [a, b] = [mesh, shuffled].map(|m| repair(m, &RepairOptions::default()).unwrap());
        let kinds = |r: &Repaired| {
            // Which copy of a triangle stays depends on the order, and with it the winding of the rest.
            let before_winding = |f: &&Finding| !matches!(f.kind, "flipped-faces" | "not-orientable");
            counts(&r.findings.iter().filter(before_winding).cloned().collect::<Vec<_>>())
        };
        let copies = a.findings.iter().any(|f| f.kind == "duplicate-faces");
        prop_assert_eq!(a.mesh.triangles.len(), b.mesh.triangles.len());
        if !copies {
            prop_assert_eq!(a.mesh.positions.len(), b.mesh.positions.len());
            prop_assert_eq!(kinds(&a), kinds(&b));
        }
    }

    #[test]
    fn a_weld_within_a_distance_keeps_the_promise(mesh in scattered(), d in 0.01..1.5f64) {
        let once = repair(mesh, &RepairOptions { weld: Some(d) }).unwrap();
        check(&once.mesh, once.findings.iter().any(|f| f.kind == "not-orientable"));
    }
}

#[test]
fn an_empty_mesh_stays_empty() {
    let r = repair(Mesh::default(), &RepairOptions::default()).unwrap();
    assert_eq!((r.mesh, r.findings), (Mesh::default(), vec![]));
}

#[test]
fn nonsense_is_dropped_and_said() {
    let mut mesh = soup(
        vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f64::NAN, 0., 0.], [0., f64::INFINITY, 0.]],
        vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 99]],
    );
    mesh.channels[0].corners.truncate(2);
    mesh.channels[0].corners[1] = 77;
    mesh.triangle_part.clear();
    let r = repair(mesh, &RepairOptions::default()).unwrap();
    assert_eq!(counts(&r.findings), [("unusable-faces", 3), ("unused-vertices", 2)]);
    assert_eq!(r.mesh.channels[0].corners, [0, NONE, NONE]);
    check(&r.mesh, false);
}

#[test]
fn an_impossible_weld_is_refused() {
    for d in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(repair(Mesh::default(), &RepairOptions { weld: Some(d) }), Err(Error::Option { .. })));
    }
}

/// A grid of `n` by `n` quads.
fn grid(n: u32) -> Mesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| [f64::from(i), f64::from(j), 0.0])).collect();
    let quad = |i, j| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    soup(positions, (0..n).flat_map(|i| (0..n).flat_map(move |j| quad(i, j))).collect())
}

#[test]
fn a_sound_mesh_is_left_alone() {
    let mesh = grid(9);
    let r = repair(mesh.clone(), &RepairOptions::default()).unwrap();
    assert_eq!((r.mesh, r.findings), (mesh, vec![]));
}

#[test]
fn a_doubled_sheet_becomes_one() {
    let mut mesh = grid(5);
    let backs: Vec<[u32; 3]> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    mesh.triangles.extend(backs);
    let r = repair(soup(mesh.positions, mesh.triangles), &RepairOptions::default()).unwrap();
    assert_eq!(r.mesh, grid(5));
    assert_eq!(counts(&r.findings), [("duplicate-faces", 50)]);
}

#[test]
fn a_wall_comes_off_a_floor_that_stays_whole() {
    let mut mesh = grid(6);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend((0..=6).map(|j| [3.0, f64::from(j), 1.0]));
    for j in 0..6 {
        let foot = 3 * 7 + j;
        mesh.triangles.extend([[foot, foot + 1, base + j], [foot + 1, base + j + 1, base + j]]);
    }
    let r = repair(soup(mesh.positions, mesh.triangles), &RepairOptions::default()).unwrap();
    assert_eq!(counts(&r.findings), [("non-manifold-edges", 6)]);
    let s = split(&r.mesh, &ComponentOptions::default());
    assert_eq!(
        s.pieces.iter().map(|c| (c.triangles.len(), c.euler, c.loops)).collect::<Vec<_>>(),
        [(72, 1, 1), (12, 1, 1)]
    );
}

#[test]
fn a_sheet_closes_under_a_fin_folded_flat_on_it() {
    // The fin stands on two edges of the sheet, there and back: removed once, it must not leave a hole.
    let mut mesh = grid(4);
    mesh.positions[11][2] = 0.4;
    let (a, b, c) = (6, 11, 16);
    mesh.triangles.extend([[a, b, c], [a, c, b]]);
    let r = repair(soup(mesh.positions, mesh.triangles), &RepairOptions::default()).unwrap();
    assert_eq!(counts(&r.findings), [("duplicate-faces", 1), ("non-manifold-edges", 2)]);
    let s = split(&r.mesh, &ComponentOptions { accessory_area: 0.0 });
    assert_eq!(s.pieces.iter().map(|c| (c.triangles.len(), c.loops)).collect::<Vec<_>>(), [(32, 1), (1, 1)]);
}

/// A strip with a half twist that was cut across, with a flap on either side of the cut: the strip goes on the straightest, but only a flap winds as it does.
#[test]
fn a_twist_that_flaps_can_undo_leaves_two_sides() {
    let n = 24;
    let at = |k: u32, side: f64| {
        let a = std::f64::consts::TAU * f64::from(k) / f64::from(n);
        let (out, up) = (0.3 * side * (0.5 * a).cos(), 0.3 * side * (0.5 * a).sin());
        [(1.0 + out) * a.cos(), up, (1.0 + out) * a.sin()]
    };
    let mut positions: Vec<[f64; 3]> = (0..n).flat_map(|k| [at(k, -1.0), at(k, 1.0)]).collect();
    let pair = |k: u32| if k < n { [2 * k, 2 * k + 1] } else { [1, 0] };
    let strip = |k: u32| {
        let ([a, b], [c, d]) = (pair(k), pair(k + 1));
        [[a, b, d], [a, d, c]]
    };
    let mut triangles: Vec<[u32; 3]> = (0..n).flat_map(strip).collect();
    let repaired = |positions: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let mesh = Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() };
        let repaired = repair(mesh, &RepairOptions::default()).unwrap();
        repaired.findings.iter().map(|f| f.kind).filter(|kind| kind.contains("orientable")).count()
    };
    assert_eq!(repaired(&positions, &triangles), 1, "a Moebius strip has one side");
    positions.extend([[1.0, 0.9, -0.44], [1.0, -0.9, 0.44]]);
    triangles.extend([[1, 0, 2 * n], [1, 0, 2 * n + 1]]);
    assert_eq!(repaired(&positions, &triangles), 0);
}
