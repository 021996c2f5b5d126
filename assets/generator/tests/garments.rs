//! Promises of every sample garment: topology, shape, texture coordinates, and the bytes in the repository.

mod glb;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use glb::Glb;

static ALL: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(gimage_assets::all);

fn open(name: &str) -> Glb {
    Glb::read(&ALL.iter().find(|(n, _)| *n == name).expect("a garment of this name").1)
}

/// Triangles over exactly welded positions.
struct Welded {
    points: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

fn weld(glb: &Glb) -> Welded {
    let (mut seen, mut points) = (BTreeMap::new(), Vec::new());
    let mut ids = Vec::new();
    for p in glb.floats_of::<3>(0, "POSITION") {
        let id = *seen.entry(p.map(f32::to_bits)).or_insert_with(|| {
            points.push(p.map(f64::from));
            points.len() - 1
        });
        ids.push(id);
    }
    let triangles = glb.triangles_of(0).iter().map(|t| t.map(|i| ids[i])).collect();
    Welded { points, triangles }
}

/// Components, boundary loops and genus; panics unless the mesh is an oriented manifold.
fn topology(w: &Welded) -> (usize, usize, usize) {
    let mut half = BTreeMap::new();
    for t in &w.triangles {
        for k in 0..3 {
            // Twice in one direction: three faces at an edge, or two that disagree on the outside.
            assert!(half.insert((t[k], t[(k + 1) % 3]), ()).is_none());
        }
    }
    let rim: Vec<(usize, usize)> = half.keys().filter(|(a, b)| !half.contains_key(&(*b, *a))).copied().collect();
    let next: BTreeMap<usize, usize> = rim.iter().copied().collect();
    assert_eq!(next.len(), rim.len(), "a vertex lies on two boundary loops");
    let mut group: Vec<usize> = (0..w.points.len()).collect();
    let loops = count_groups(&mut group, rim.iter().copied(), &rim.iter().map(|e| e.0).collect::<Vec<_>>());
    let mut group: Vec<usize> = (0..w.points.len()).collect();
    let parts = count_groups(&mut group, half.keys().copied(), &(0..w.points.len()).collect::<Vec<_>>());
    let edges = (half.len() + rim.len()) / 2;
    let euler = (w.points.len() + w.triangles.len()) as i64 - edges as i64;
    let twice = 2 * parts as i64 - loops as i64 - euler;
    assert!(twice >= 0 && twice % 2 == 0, "Euler number {euler}");
    (parts, loops, twice as usize / 2)
}

fn count_groups(group: &mut [usize], pairs: impl Iterator<Item = (usize, usize)>, of: &[usize]) -> usize {
    fn root(group: &mut [usize], mut i: usize) -> usize {
        while group[i] != i {
            group[i] = group[group[i]];
            i = group[i];
        }
        i
    }
    for (a, b) in pairs {
        let (a, b) = (root(group, a), root(group, b));
        group[a] = b;
    }
    of.iter().filter(|&&i| root(group, i) == i).count()
}

#[test]
fn topology_is_as_described() {
    let want = [
        ("tshirt.glb", (1, 4, 0)),
        ("skirt.glb", (1, 2, 0)),
        ("trousers.glb", (1, 3, 1)),
        ("cape.glb", (1, 1, 0)),
        ("dress.glb", (1, 4, 0)),
        ("sleeve.glb", (1, 2, 0)),
    ];
    for (name, expected) in want {
        assert_eq!(topology(&weld(&open(name))), expected, "{name}");
    }
}

#[test]
fn triangles_are_well_shaped() {
    for (name, bytes) in ALL.iter() {
        let glb = Glb::read(bytes);
        let w = weld(&glb);
        assert!((1000..6000).contains(&w.triangles.len()), "{name}: {}", w.triangles.len());
        let unit = if *name == "skirt.glb" { 0.01 } else { 1.0 };
        for t in &w.triangles {
            let p = t.map(|i| w.points[i].map(|c| c * unit));
            let d = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            let mut side = [d(p[0], p[1]), d(p[1], p[2]), d(p[2], p[0])];
            side.sort_by(f64::total_cmp);
            let s = side.iter().sum::<f64>() / 2.0;
            let area = (s * side.iter().map(|l| s - l).product::<f64>()).sqrt();
            assert!(side[2] * side[2] / (2.0 * area) < 6.0, "{name}: aspect of {side:?}");
            assert!(side[0] > 0.005 && side[2] < 0.045, "{name}: {side:?}");
        }
        for n in glb.floats_of::<3>(0, "NORMAL") {
            assert!((n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-4, "{name}: {n:?}");
        }
    }
}

#[test]
fn texture_coordinates_are_the_panels() {
    for (name, bytes) in ALL.iter() {
        let glb = Glb::read(bytes);
        let uv = glb.floats_of::<2>(0, "TEXCOORD_0");
        assert!(uv.iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{name}");
        let metres = glb.doc["asset"]["extras"]["metresPerUv"].as_f64().expect("the scale of the panels");
        let unit = if *name == "skirt.glb" { 0.01 } else { 1.0 };
        let p = glb.floats_of::<3>(0, "POSITION");
        let mut stretch = Vec::new();
        for t in glb.triangles_of(0) {
            let [a, b, c] = t.map(|i| uv[i].map(f64::from));
            // V points down, so what is counter-clockwise in a panel has a negative area here.
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(area < 0.0, "{name}: a panel is folded over");
            for k in 0..3 {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                let flat = (0..2).map(|k| f64::from(uv[i][k] - uv[j][k]).powi(2)).sum::<f64>().sqrt() * metres;
                let real = (0..3).map(|k| f64::from(p[i][k] - p[j][k]).powi(2)).sum::<f64>().sqrt() * unit;
                stretch.push(real / flat);
            }
        }
        stretch.sort_by(f64::total_cmp);
        let at = |share: f64| stretch[(share * (stretch.len() - 1) as f64) as usize];
        assert!((at(0.5) - 1.0).abs() < 0.02, "{name}: median {}", at(0.5));
        assert!(at(0.02) > 0.85 && at(0.98) < 1.15, "{name}: {} to {}", at(0.02), at(0.98));
    }
}

#[test]
fn panels_do_not_overlap() {
    let islands = [
        ("tshirt.glb", 4),
        ("skirt.glb", 2),
        ("trousers.glb", 5),
        ("cape.glb", 1),
        ("dress.glb", 4),
        ("sleeve.glb", 1),
    ];
    for (name, count) in islands {
        let glb = open(name);
        let uv = glb.floats_of::<2>(0, "TEXCOORD_0");
        let mut group: Vec<usize> = (0..uv.len()).collect();
        let pairs = glb.triangles_of(0).into_iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2])]);
        let all: Vec<usize> = (0..uv.len()).collect();
        assert_eq!(count_groups(&mut group, pairs, &all), count, "{name}");
        let root = |mut i: usize| {
            while group[i] != i {
                i = group[i];
            }
            i
        };
        let mut boxes: BTreeMap<usize, [f32; 4]> = BTreeMap::new();
        for (i, p) in uv.iter().enumerate() {
            let b = boxes.entry(root(i)).or_insert([1.0, 1.0, 0.0, 0.0]);
            *b = [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])];
        }
        let boxes: Vec<[f32; 4]> = boxes.into_values().collect();
        for (i, a) in boxes.iter().enumerate() {
            for b in &boxes[i + 1..] {
                assert!(a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1], "{name}");
            }
        }
    }
}

#[test]
fn the_dress_and_the_sleeve_are_skinned_in_their_rest_pose() {
    is_skinned_in_its_rest_pose(&open("dress.glb"), 8);
    let sleeve = open("sleeve.glb");
    is_skinned_in_its_rest_pose(&sleeve, 3);
    let names: Vec<_> = sleeve.doc["animations"].as_array().expect("animations").iter().map(|a| &a["name"]).collect();
    assert_eq!(names, ["swing", "pull"]);
}

fn is_skinned_in_its_rest_pose(glb: &Glb, count: usize) {
    let skin = &glb.doc["skins"][0];
    let joints: Vec<usize> =
        skin["joints"].as_array().expect("joints").iter().map(|j| j.as_u64().expect("index") as usize).collect();
    assert_eq!(joints.len(), count);
    for (w, j) in glb.floats_of::<4>(0, "WEIGHTS_0").iter().zip(glb.bytes_of(0, "JOINTS_0").as_chunks::<4>().0) {
        assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-6 && w.iter().all(|w| *w >= 0.0));
        assert!(j.iter().all(|&j| usize::from(j) < joints.len()));
    }
    // World translation plus that of the inverse bind matrix is nothing.
    let inverse = glb.accessor::<16>(skin["inverseBindMatrices"].as_u64().expect("matrices") as usize);
    let nodes = glb.doc["nodes"].as_array().expect("nodes");
    for (k, &joint) in joints.iter().enumerate() {
        let (mut at, mut world) = (Some(joint), [0.0f64; 3]);
        while let Some(n) = at {
            for c in 0..3 {
                world[c] += nodes[n]["translation"][c].as_f64().unwrap_or(0.0);
            }
            let holds = |m: &serde_json::Value| m["children"].as_array().is_some_and(|c| c.iter().any(|i| i == n));
            at = nodes.iter().position(holds);
        }
        for c in 0..3 {
            assert!((world[c] + f64::from(inverse[k][12 + c])).abs() < 1e-6);
        }
    }
}

#[test]
fn the_cape_is_pinned_at_the_collar() {
    let glb = open("cape.glb");
    let pins = glb.floats_of::<1>(0, "_PIN");
    let pinned = pins.iter().filter(|p| p[0] == 1.0).count();
    assert!(pins.iter().all(|p| p[0] == 0.0 || p[0] == 1.0));
    assert!((10..60).contains(&pinned), "{pinned}");
}

#[test]
fn the_files_in_the_repository_are_these() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    assert!(ALL.iter().map(|(_, b)| b.len()).sum::<usize>() < 1 << 20);
    for (name, bytes) in ALL.iter() {
        let stored = std::fs::read(folder.join(name)).expect(name);
        assert!(stored == *bytes, "{name} is stale: cargo run -p gimage-assets --bin make-assets -- assets");
    }
}
