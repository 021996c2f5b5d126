use gimage::topology::Topology;

use super::*;

/// Each family at several hardnesses.
fn made(family: &str) -> Vec<Shape> {
    let (_, make) = FAMILIES.iter().find(|f| f.0 == family).unwrap();
    (0..9).map(|k| make(&mut Random::new(11, k), k as f64 / 8.0)).collect()
}

/// Topology of the triangles with three different corners.
fn topology(s: &Shape) -> Topology {
    let sound = |t: &&[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    Topology::of(&s.triangles.iter().filter(sound).copied().collect::<Vec<_>>())
}

/// -0 and 0 are the same place.
fn bits(x: f64) -> u64 {
    (x + 0.0).to_bits()
}

/// With equal positions joined, as the importer does.
fn joined(s: &Shape) -> Shape {
    let mut number = std::collections::BTreeMap::new();
    let to: Vec<u32> = (0..).zip(&s.positions).map(|(v, p)| *number.entry(p.map(bits)).or_insert(v)).collect();
    let triangles = s.triangles.iter().map(|t| t.map(|v| to[v as usize])).collect();
    Shape { positions: s.positions.clone(), triangles }
}

/// Longest side / height of each triangle, infinite without an area.
fn aspects(s: &Shape) -> Vec<f64> {
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let aspect = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| s.positions[v as usize]);
        let sub = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| p[k] - q[k]);
        let (u, v) = (sub(b, a), sub(c, a));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let longest = length(u).max(length(v)).max(length(sub(b, c)));
        longest * longest / length(n)
    };
    s.triangles.iter().map(aspect).collect()
}

/// Triangles around the vertex that has most.
fn largest_fan(s: &Shape) -> usize {
    let mut count = vec![0; s.positions.len()];
    s.triangles.iter().flatten().for_each(|&v| count[v as usize] += 1);
    count.into_iter().max().unwrap_or(0)
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

#[test]
fn the_same_seed_gives_the_same_meshes_and_another_seed_others() {
    let n = 2 * FAMILIES.len();
    let differ = (0..n).filter(|&k| {
        assert_eq!(mesh(1, k, n), mesh(1, k, n));
        mesh(1, k, n).1 != mesh(2, k, n).1
    });
    assert!(differ.count() > n * 2 / 3);
}

#[test]
fn every_mesh_is_finite_of_a_bearable_size_and_indexed_within_bounds() {
    for (name, make) in FAMILIES {
        for k in 0..5 {
            let s = make(&mut Random::new(5, k), k as f64 / 4.0);
            assert!(!s.triangles.is_empty() && s.triangles.len() <= 60_000, "{name}: {}", s.triangles.len());
            assert!(s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()), "{name}");
            assert!(s.positions.iter().flatten().all(|x| x.is_finite()), "{name}");
        }
    }
}

#[test]
fn names_are_unique() {
    let mut names: Vec<String> = (0..1000).map(name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 1000);
}

#[test]
fn lace_net_and_strainer_have_as_many_holes_as_asked() {
    for family in ["lace", "net"] {
        let loops: Vec<usize> = made(family).iter().map(|s| topology(s).boundary_loops).collect();
        assert_eq!((loops[0], loops[8]), (10, 401), "{family}: {loops:?}");
    }
    let loops: Vec<usize> = made("strainer").iter().map(|s| topology(s).boundary_loops).collect();
    assert_eq!((loops[0], loops[8]), (11, 202), "{loops:?}");
}

#[test]
fn one_sided_surfaces_are_one_sided() {
    assert!(made("klein").iter().all(|s| topology(s).misoriented_edges > 0 && topology(s).euler <= 0));
    assert!(made("moebius").iter().any(|s| topology(s).misoriented_edges > 0 && topology(s).boundary_loops == 1));
}

#[test]
fn handles_reach_genus_20() {
    let genus = |s: &Shape| {
        let t = topology(s);
        (2 - t.euler - t.boundary_loops as i64) / 2
    };
    let found: Vec<i64> = made("handles").iter().map(genus).collect();
    assert_eq!((found[0], found[8]), (1, 20), "{found:?}");
    assert!(made("menger").iter().any(|s| genus(s) > 20));
    // Open ends may touch at a corner, which spoils the count.
    let sound = |s: &&Shape| topology(s).singular_vertices == 0;
    assert!(made("tree").iter().filter(sound).count() >= 4);
    assert!(made("tree").iter().filter(sound).all(|s| genus(s) == 0));
}

#[test]
fn flat_borders_are_disks() {
    for family in ["comb", "coast", "koch", "maze", "ribbon", "spiral", "necks", "graded", "flipped", "slivers", "fan"]
    {
        for s in made(family) {
            let t = topology(&s);
            let loops = if family == "coast" { 2 } else { 1 };
            assert_eq!((t.components, t.boundary_loops, t.non_manifold_edges), (1, loops, 0), "{family}: {t:?}");
        }
    }
}

#[test]
fn slivers_and_needles_are_as_thin_as_they_claim() {
    let slivers = largest(made("slivers").iter().flat_map(aspects));
    assert!((0.9e8..3e8).contains(&slivers), "{slivers:e}");
    assert!(made("needles").iter().all(|s| largest(aspects(s)) > 5.0));
    assert!(made("caps").iter().all(|s| largest(aspects(s)) > 1e3));
    assert!(largest(made("flipped").iter().flat_map(aspects)) > 100.0);
}

#[test]
fn fans_reach_ten_thousand_triangles() {
    assert_eq!(made("fan").iter().map(largest_fan).max(), Some(10_000));
    assert_eq!(made("bipyramid").iter().map(largest_fan).max(), Some(5_000));
}

#[test]
fn scales_span_36_orders_of_magnitude_and_ribbons_are_1_to_10_000() {
    let sizes: Vec<f64> = made("scale").iter().map(Shape::diagonal).collect();
    assert!(sizes[0] < 1e-17 && sizes[8] > 5e17, "{sizes:?}");
    let ratio = largest(made("ribbon").iter().map(Shape::diagonal));
    assert!((9_000.0..11_000.0).contains(&ratio), "{ratio}");
}

#[test]
fn broken_meshes_are_broken() {
    let any = |family: &str, test: &dyn Fn(&Topology) -> bool| made(family).iter().any(|s| test(&topology(s)));
    assert!(any("soup", &|t| t.components > 2000));
    assert!(any("tiles", &|t| t.components == 1000));
    assert!(any("knot", &|t| t.non_manifold_edges > 100));
    assert!(any("cubes", &|t| t.non_manifold_edges > 10 && t.singular_vertices > 0));
    assert!(any("windings", &|t| t.misoriented_edges > 100));
    assert!(any("copies", &|t| t.non_manifold_edges > 100));
    assert!(made("zero").iter().any(|s| aspects(s).iter().any(|a| !a.is_finite())));
}

#[test]
fn sheets_coincide_and_pages_share_a_spine() {
    let shared = |s: &Shape| {
        let mut points: Vec<_> = s.positions.iter().map(|p| p.map(bits)).collect();
        points.sort_unstable();
        points.dedup();
        s.positions.len() - points.len()
    };
    assert!(made("coincident").iter().any(|s| shared(s) > 300));
    assert!(made("book").iter().all(|s| shared(s) >= 8));
    assert!(made("crossing").iter().any(|s| shared(s) > 0));
    assert!(made("hair").iter().any(|s| shared(s) > 2));
}

#[test]
fn shells_are_thin_and_spikes_far() {
    let thin = made("shell");
    assert!(thin.iter().all(|s| topology(&joined(s)).boundary_loops == 0));
    let far = made("spike");
    assert!(far[8].diagonal() > 1e5 && far[0].diagonal() < 10.0);
    assert!(made("hedgehog")[8].diagonal() > 150.0);
}

#[test]
fn slits_have_two_sides_that_do_not_coincide() {
    let loops: Vec<usize> = made("slits").iter().map(|s| topology(s).boundary_loops).collect();
    assert_eq!((loops[0], loops[8]), (2, 61), "{loops:?}");
}

#[test]
fn a_cover_is_a_disk_of_several_turns() {
    for s in made("cover") {
        let t = topology(&s);
        assert_eq!((t.components, t.boundary_loops, t.euler), (1, 1, 1));
    }
}
