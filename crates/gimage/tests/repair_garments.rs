//! Repairs real and hand-made garments where they are at hand: in `$GIMAGE_SHARED`, or `shared` beside the repository.

use std::path::PathBuf;

use crate::skip;
use gimage::component::{Component, ComponentOptions, extract, split};
use gimage::mesh::Mesh;
use gimage::record::{Finding, Severity};
use gimage::repair::{RepairOptions, Repaired, repair};

fn garment(name: &str) -> Option<Vec<u8>> {
    let shared = std::env::var_os("GIMAGE_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let path = shared.join("garments").join(name);
    if !path.exists() {
        skip::skip("no shared garments (set GIMAGE_SHARED to the folder that holds garments/)");
        return None;
    }
    Some(std::fs::read(path).unwrap())
}

/// Vertices and faces only, polygons as fans.
fn obj(name: &str) -> Option<Mesh> {
    let text = String::from_utf8(garment(name)?).unwrap();
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                mesh.positions.push([p[0], p[1], p[2]]);
            }
            Some("f") => {
                let v: Vec<u32> = words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
                mesh.triangles.extend((2..v.len()).map(|k| [v[0], v[k - 1], v[k]]));
            }
            _ => {}
        }
    }
    Some(mesh)
}

/// All primitives of all nodes, in world space.
fn glb(name: &str) -> Option<Mesh> {
    let gltf = gltf::Gltf::from_slice(&garment(name)?).unwrap();
    let mut mesh = Mesh::default();
    let mut stack: Vec<(gltf::Node, Vec<[[f32; 4]; 4]>)> =
        gltf.scenes().flat_map(|s| s.nodes().collect::<Vec<_>>()).map(|n| (n, Vec::new())).collect();
    stack.reverse();
    while let Some((node, mut transforms)) = stack.pop() {
        transforms.push(node.transform().matrix());
        for primitive in node.mesh().into_iter().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
            let reader = primitive.reader(|_| gltf.blob.as_deref());
            let base = mesh.positions.len() as u32;
            mesh.positions.extend(reader.read_positions().unwrap().map(|p| {
                transforms.iter().rev().fold(p.map(f64::from), |p, m| {
                    std::array::from_fn(|k| (0..3).map(|j| f64::from(m[j][k]) * p[j]).sum::<f64>() + f64::from(m[3][k]))
                })
            }));
            let index: Vec<u32> = match reader.read_indices() {
                Some(i) => i.into_u32().map(|i| base + i).collect(),
                None => (base..mesh.positions.len() as u32).collect(),
            };
            mesh.triangles.extend(index.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
        }
        stack.extend(node.children().map(|c| (c, transforms.clone())));
    }
    Some(mesh)
}

fn run(mesh: Mesh) -> (Repaired, Vec<Component>) {
    let r = repair(mesh, &RepairOptions::default()).unwrap();
    let s = split(&r.mesh, &ComponentOptions { accessory_area: 0.0 });
    for c in &s.pieces {
        let surface = extract(&r.mesh, c);
        let twin = gimage::halfedge::twins(&surface.triangles).unwrap();
        assert_eq!(gimage::halfedge::boundary_loops(&surface.triangles, &twin).unwrap().len(), c.loops);
        assert_eq!(gimage::halfedge::euler(&surface.triangles), c.euler);
    }
    (r, s.pieces)
}

fn counts(findings: &[Finding]) -> Vec<(&str, u64)> {
    findings.iter().map(|f| (f.kind, f.count)).collect()
}

fn repairs(findings: &[Finding]) -> Vec<(&str, u64)> {
    findings.iter().filter(|f| f.severity != Severity::Note).map(|f| (f.kind, f.count)).collect()
}

/// (Euler, loops) of each component, sorted.
fn shapes(components: &[Component]) -> Vec<(i64, usize)> {
    let mut all: Vec<_> = components.iter().map(|c| (c.euler, c.loops)).collect();
    all.sort_unstable();
    all
}

#[test]
fn clean_garments_come_through_unchanged() {
    for (name, triangles, components, loops, euler) in [
        ("skirt_evening.obj", 5220, 1, 2, 0),
        ("tshirt_1900.obj", 3726, 1, 4, -2),
        ("hat_fedora.obj", 1244, 1, 1, 1),
        ("suit_male06.obj", 7168, 2, 7, -3),
        ("models/spot.obj", 5856, 1, 0, 2),
        ("models/camel.obj", 5720, 1, 0, 2),
        ("models/feline.obj", 20532, 1, 0, -2),
        ("models/stanford-bunny.obj", 69451, 1, 5, -3),
        ("bad/needles_1e4.obj", 8, 1, 1, 1),
        ("bad/needles_1e6.obj", 80, 1, 1, 1),
        ("bad/tube_tiny_1e-6.obj", 384, 1, 2, 0),
        ("bad/tube_huge_1e6.obj", 384, 1, 2, 0),
        ("bad/tube_far_1e6.obj", 384, 1, 2, 0),
        ("bad/sphere.obj", 0, 1, 0, 2),
        ("bad/torus.obj", 0, 1, 0, 0),
        ("bad/double_torus.obj", 0, 1, 0, -2),
        ("bad/genus16.obj", 0, 1, 0, -30),
        ("bad/torus_with_hole.obj", 0, 1, 1, -1),
        ("bad/one_triangle.obj", 1, 1, 1, 1),
    ] {
        let Some(mesh) = obj(name) else { continue };
        let given: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let (r, c) = run(mesh);
        assert_eq!(repairs(&r.findings), [], "{name}");
        assert!((0..given.len()).all(|t| r.mesh.corners(t) == given[t]), "{name}");
        assert!(triangles == 0 || r.mesh.triangles.len() == triangles, "{name}: {}", given.len());
        assert_eq!(c.len(), components, "{name}");
        assert_eq!(c.iter().map(|c| c.loops).sum::<usize>(), loops, "{name}");
        assert_eq!(c.iter().map(|c| c.euler).sum::<i64>(), euler, "{name}");
        assert!(c.iter().all(|c| c.orientable), "{name}");
        if name == "models/stanford-bunny.obj" {
            assert_eq!(r.mesh.positions.len(), 34834);
            assert_eq!(counts(&r.findings), [("unused-vertices", 35947 - 34834)]);
        }
    }
}

#[test]
fn hand_made_faults_are_mended() {
    let go = |name| obj(name).map(run);
    if let Some((r, c)) = go("bad/bowtie_spheres.obj") {
        assert_eq!(shapes(&c), [(2, 0), (2, 0)]);
        assert_eq!(repairs(&r.findings), [("bow-tie-vertices", 1)]);
    }
    if let Some((r, c)) = go("bad/bowtie_vertex.obj") {
        assert_eq!(shapes(&c), [(1, 1), (1, 1)]);
        assert_eq!(repairs(&r.findings), [("bow-tie-vertices", 1)]);
    }
    if let Some((r, c)) = go("bad/nonmanifold_edge.obj") {
        assert_eq!(shapes(&c), [(1, 1), (1, 1)]);
        assert_eq!(repairs(&r.findings)[0], ("non-manifold-edges", 1));
    }
    if let Some((r, c)) = go("bad/mixed_winding.obj") {
        assert_eq!(shapes(&c), [(1, 1)]);
        assert_eq!(repairs(&r.findings)[0].0, "flipped-faces");
        assert!(c[0].orientable);
    }
    for (name, genus, loops) in [("bad/klein_bottle.obj", 2, 0), ("bad/moebius.obj", 1, 1)] {
        if let Some((r, c)) = go(name) {
            assert_eq!((c.len(), c[0].genus, c[0].loops, c[0].orientable), (1, genus, loops, false), "{name}");
            assert_eq!(repairs(&r.findings), [], "{name}");
            assert!(r.findings.iter().any(|f| f.kind == "not-orientable"), "{name}");
        }
    }
    for name in ["bad/concave_quad.obj", "bad/empty.obj", "bad/points_only.obj", "bad/two_components.obj"] {
        go(name);
    }
}

#[test]
fn hand_made_glb_faults_are_mended() {
    let go = |name| glb(name).map(run);
    if let Some((r, c)) = go("bad/double_sided_sheet.glb") {
        assert_eq!(shapes(&c), [(1, 1)]);
        assert_eq!(repairs(&r.findings), [("duplicate-faces", r.mesh.triangles.len() as u64)]);
    }
    if let Some((r, c)) = go("bad/t_junction_wall.glb") {
        assert_eq!(shapes(&c), [(1, 1), (1, 1)]);
        assert_eq!(repairs(&r.findings)[0].0, "non-manifold-edges");
    }
    if let Some((r, c)) = go("bad/duplicate_faces.glb") {
        assert_eq!(shapes(&c), [(1, 1)]);
        assert_eq!(repairs(&r.findings), [("duplicate-faces", 30)]);
    }
    if let Some((r, c)) = go("bad/zero_area.glb") {
        assert_eq!(shapes(&c), [(1, 1)]);
        println!("{:?}", r.findings);
    }
    if let Some((r, c)) = go("bad/all_degenerate.glb") {
        assert_eq!((r.mesh.triangles.len(), c.len()), (0, 0));
    }
    if let Some((_, c)) = go("bad/triangle_soup_tube.glb") {
        assert_eq!(shapes(&c), [(0, 2)]);
    }
    if let Some((r, c)) = go("bad/confetti_200_components.glb") {
        assert_eq!(c.len(), 200);
        let s = split(&r.mesh, &ComponentOptions::default());
        assert_eq!((s.pieces.len(), s.accessories.len(), s.findings[0].kind), (0, 200, "no-piece"));
    }
    if let Some(mesh) = glb("bad/near_duplicate_soup_tube.glb") {
        let r = repair(mesh, &RepairOptions { weld: Some(2e-6) }).unwrap();
        let s = split(&r.mesh, &ComponentOptions::default());
        assert_eq!(shapes(&s.pieces), [(0, 2)]);
    }
}

#[test]
fn real_garments_keep_their_topology() {
    // Components and loops with an exact weld. Cut along all crowded edges and tied vertices, the belted dress would have
    // 25 and 35 and the jacket 70 and 26: joined along the straightest pairs, fewer.
    for (name, components, loops) in
        [("dress_summer.glb", 4, 0), ("dress_belted_202k.glb", 25, 32), ("jacket_fleece.glb", 70, 22)]
    {
        let Some(mesh) = glb(name) else { continue };
        let n = mesh.triangles.len();
        let start = std::time::Instant::now();
        let (r, c) = run(mesh);
        println!("{name}: {n} -> {} triangles, {:?}", r.mesh.triangles.len(), start.elapsed());
        assert_eq!((c.len(), c.iter().map(|c| c.loops).sum::<usize>()), (components, loops), "{name}");
    }
}
