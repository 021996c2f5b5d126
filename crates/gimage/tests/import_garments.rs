//! Real garments and broken files, where the shared folder is there.

use std::path::Path;

use crate::support::*;
use gimage::import::{ImportOptions, import};
use gimage::mesh::Semantic;
use gimage::{Error, Mesh, Result};

/// File, triangles, bounding box (0 where it is not checked).
const GARMENTS: &[(&str, usize, [f64; 3])] = &[
    ("suit_male06.obj", 7_168, [6.342, 14.4, 2.806]),
    ("hat_fedora.obj", 1_244, [2.022, 1.089, 2.616]),
    ("skirt_evening.obj", 5_220, [0.8019, 0.5503, 1.201]),
    ("tshirt_1900.obj", 3_726, [10.47, 11.38, 5.699]),
    ("jacket_fleece.glb", 93_038, [3.671, 2.728, 1.089]),
    ("dress_summer.glb", 64_760, [1.249, 1.676, 0.469]),
    ("dress_belted_202k.glb", 202_559, [0.6086, 1.364, 0.3221]),
    ("outfit_skinned.glb", 11_129, [1.063, 1.838, 0.381]),
    ("mage_skinned.glb", 5_683, [2.426, 2.716, 2.271]),
    // Its nodes scale it; the size in the table of the garments is that without them.
    ("knight_skinned/scene.gltf", 18_216, [207.3 / 83.834, 253.3 / 83.834, 72.75 / 83.834]),
    ("compressed/polo_draco.glb", 49_258, [705.5, 688.7, 295.7]),
    // 43,606 triangles that stand once, and stitches of 116 and 76 triangles that stand 1,527 and 1,424 times.
    ("compressed/shorts_meshopt.glb", 43_606 + 116 * 1_527 + 76 * 1_424, [0.0; 3]),
    ("models/stanford-bunny.obj", 69_451, [0.1557, 0.1543, 0.1207]),
    ("models/feline.obj", 20_532, [1.502, 1.46, 0.6354]),
    ("models/camel.obj", 5_720, [0.3056, 0.979, 0.9987]),
    ("models/spot.obj", 5_856, [0.9431, 1.69, 1.718]),
];

fn extent(mesh: &Mesh) -> [f64; 3] {
    let (lo, hi) = mesh.bounds().unwrap();
    std::array::from_fn(|k| hi[k] - lo[k])
}

#[test]
fn every_garment_has_its_triangles_and_its_size() {
    let Some(folder) = garments_or_skip("every_garment_has_its_triangles_and_its_size") else { return };
    for (file, triangles, size) in GARMENTS {
        let got = import(&folder.join(file), &ImportOptions::default()).unwrap();
        check(&got);
        assert_eq!(got.mesh.triangles.len(), *triangles, "{file}");
        let mut found = extent(&got.mesh);
        let mut want = *size;
        found.sort_by(f64::total_cmp);
        want.sort_by(f64::total_cmp);
        for (a, b) in found.iter().zip(want).filter(|(_, b)| *b != 0.0) {
            assert!((a - b).abs() < 1e-3 * b, "{file}: {found:?} {want:?}");
        }
    }
}

#[test]
fn credits_skeletons_and_channels() {
    let Some(folder) = garments_or_skip("credits_skeletons_and_channels") else { return };
    let load = |file: &str| import(&folder.join(file), &ImportOptions::default()).unwrap();
    let jacket = load("jacket_fleece.glb");
    assert!(jacket.source.extras.iter().any(|e| e.starts_with("license: CC-BY-4.0")), "{:?}", jacket.source.extras);
    let polo = load("compressed/polo_draco.glb");
    assert_eq!(polo.mesh.positions.len(), 31_016);
    assert!(polo.mesh.channel(&Semantic::Normal).is_some() && polo.mesh.channel(&Semantic::TexCoord(0)).is_some());
    for (file, joints) in [("outfit_skinned.glb", 67), ("mage_skinned.glb", 41), ("knight_skinned/scene.gltf", 56)] {
        let got = load(file);
        assert_eq!(got.mesh.skeleton.joints.len(), joints, "{file}");
        let [j, w] = [Semantic::Joints(0), Semantic::Weights(0)].map(|s| got.mesh.channel(&s).unwrap());
        for t in 0..got.mesh.triangles.len() {
            for c in 0..3 {
                let Some(weights) = w.at(t, c) else { continue };
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                assert!(j.at(t, c).unwrap().iter().all(|&k| (k as usize) < joints));
            }
        }
        // Every part but the root hangs on a joint.
        let roots = got.mesh.skeleton.joints.iter().filter(|j| j.parent.is_none()).count();
        assert!((1..10).contains(&roots), "{file}: {roots}");
    }
    let options = ImportOptions { pieces: vec!["Wolf3D_Outfit_Top".into()], ..Default::default() };
    assert_eq!(import(&folder.join("outfit_skinned.glb"), &options).unwrap().mesh.triangles.len(), 1_204);
}

/// The `gltf` crate reads uncompressed sound files: every corner must be where it puts it.
#[test]
fn corners_agree_with_the_gltf_crate() {
    let Some(folder) = garments_or_skip("corners_agree_with_the_gltf_crate") else { return };
    for file in
        ["jacket_fleece.glb", "dress_summer.glb", "dress_belted_202k.glb", "outfit_skinned.glb", "mage_skinned.glb"]
    {
        let path = folder.join(file);
        let other = gltf::Gltf::open(&path).unwrap();
        let mut corners = Vec::new();
        let identity = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., 0., 0., 1.]];
        let mut stack: Vec<_> = other.default_scene().unwrap().nodes().map(|n| (n, identity)).collect();
        stack.reverse();
        while let Some((node, parent)) = stack.pop() {
            let local = node.transform().matrix();
            let world: [[f32; 4]; 4] =
                std::array::from_fn(|j| std::array::from_fn(|i| (0..4).map(|k| parent[k][i] * local[j][k]).sum()));
            for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
                let reader = primitive.reader(|_| other.blob.as_deref());
                let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
                for v in reader.read_indices().unwrap().into_u32() {
                    let p = positions[v as usize];
                    corners.push(std::array::from_fn(|i| {
                        world[0][i] * p[0] + world[1][i] * p[1] + world[2][i] * p[2] + world[3][i]
                    }));
                }
            }
            let children: Vec<_> = node.children().collect();
            stack.extend(children.into_iter().rev().map(|c| (c, world)));
        }
        let got = import(&path, &ImportOptions::default()).unwrap().mesh;
        compare(file, &got, &corners);
    }
}

fn compare(file: &str, mesh: &Mesh, corners: &[[f32; 3]]) {
    assert_eq!(3 * mesh.triangles.len(), corners.len(), "{file}");
    let tolerance = 1e-5 * mesh.diagonal();
    for (v, c) in mesh.triangles.iter().flatten().zip(corners) {
        let p = mesh.positions[*v as usize];
        assert!((0..3).all(|k| (p[k] - f64::from(c[k])).abs() < tolerance), "{file}: {p:?} {c:?}");
    }
}

/// So must `tobj` where faces are triangles.
#[test]
fn corners_agree_with_tobj() {
    let Some(folder) = garments_or_skip("corners_agree_with_tobj") else { return };
    for file in ["models/spot.obj", "models/stanford-bunny.obj", "skirt_evening.obj", "tshirt_1900.obj"] {
        let path = folder.join(file);
        let (models, _) = tobj::load_obj(&path, &tobj::LoadOptions::default()).unwrap();
        let corner = |m: &tobj::Mesh, v: u32| std::array::from_fn(|k| m.positions[3 * v as usize + k]);
        let corners: Vec<[f32; 3]> =
            models.iter().flat_map(|m| m.mesh.indices.iter().map(|&v| corner(&m.mesh, v))).collect();
        compare(file, &import(&path, &ImportOptions::default()).unwrap().mesh, &corners);
    }
}

/// The outcome of a file.
fn outcome(result: &Result<gimage::import::Imported>) -> String {
    match result {
        Ok(got) => {
            check(got);
            let kinds: Vec<_> = got.findings.iter().map(|f| f.kind).collect();
            format!("{} triangles {}", got.mesh.triangles.len(), kinds.join(" ")).trim_end().into()
        }
        Err(Error::Io { .. }) => "io".into(),
        Err(Error::Malformed { .. }) => "malformed".into(),
        Err(Error::Unsupported { .. }) => "unsupported".into(),
        Err(Error::Empty { .. }) => "empty".into(),
        Err(Error::TooLarge { .. }) => "too large".into(),
        Err(other) => other.to_string(),
    }
}

/// Outcome of each file: triangles and the kinds of findings, or the kind of error.
const BAD: &[(&str, &str)] = &[
    ("all_degenerate.glb", "3 triangles"),
    ("all_nan.glb", "empty"),
    ("bowtie_spheres.obj", "336 triangles"),
    ("bowtie_vertex.obj", "2 triangles"),
    ("bufferview_overrun.glb", "malformed"),
    ("concave_quad.obj", "3 triangles"),
    ("confetti_200_components.glb", "200 triangles hint-unit"),
    ("constant_uv.glb", "384 triangles"),
    ("double_sided_sheet.glb", "256 triangles"),
    ("double_torus.obj", "100 triangles"),
    ("duplicate_faces.glb", "158 triangles"),
    ("empty.obj", "empty"),
    ("empty_scene.glb", "empty"),
    ("genus16.obj", "460 triangles hint-unit"),
    ("huge_count.glb", "too large"),
    ("index_out_of_range.glb", "malformed"),
    ("index_out_of_range.obj", "malformed"),
    ("klein_bottle.obj", "800 triangles hint-unit"),
    ("lfs_pointer.glb", "malformed"),
    ("line_continuation.obj", "2 triangles points-and-lines"),
    ("lines_only.glb", "empty"),
    ("missing_bin.gltf", "io"),
    ("missing_vt.obj", "2 triangles"),
    ("mixed_winding.obj", "200 triangles"),
    ("moebius.obj", "240 triangles"),
    ("nan_positions.glb", "116 triangles non-finite-positions"),
    ("nan_text.obj", "malformed"),
    ("near_duplicate_soup_tube.glb", "384 triangles"),
    ("needles_1e4.obj", "8 triangles"),
    ("needles_1e6.obj", "80 triangles hint-unit"),
    ("node_cycle.gltf", "malformed"),
    ("nonmanifold_edge.obj", "3 triangles"),
    ("not_a_glb.glb", "malformed"),
    ("one_triangle.obj", "1 triangles"),
    ("one_triangle_uv.obj", "1 triangles"),
    ("plane_3_holes.glb", "458 triangles"),
    ("points_only.obj", "empty"),
    ("polygons_negative.obj", "10 triangles repeated-vertices"),
    ("requires_draco.glb", "128 triangles"),
    ("skin_joint_out_of_range.glb", "384 triangles joint-out-of-range unnormalised-weights zero-weights"),
    ("skin_ok_tube.glb", "384 triangles"),
    ("skin_unnormalised.glb", "384 triangles unnormalised-weights"),
    ("skin_zero_weights.glb", "384 triangles zero-weights"),
    ("sphere.obj", "352 triangles"),
    ("t_junction_wall.glb", "108 triangles"),
    ("torus.obj", "576 triangles"),
    ("torus_with_hole.obj", "568 triangles"),
    ("triangle_soup_tube.glb", "384 triangles"),
    ("truncated.glb", "malformed"),
    ("truncated_header.glb", "malformed"),
    ("tube_far_1e6.obj", "384 triangles"),
    ("tube_huge_1e6.obj", "384 triangles hint-unit"),
    ("tube_tiny_1e-6.obj", "384 triangles hint-unit"),
    ("two_components.obj", "336 triangles"),
    ("vt_out_of_range.obj", "1 triangles attribute-out-of-range"),
    ("zero_area.glb", "132 triangles"),
    ("zero_bytes.glb", "empty"),
    ("zero_indices.glb", "empty"),
];

#[test]
#[allow(clippy::print_stderr)]
fn every_bad_file_has_its_outcome() {
    let Some(folder) = garments_or_skip("every_bad_file_has_its_outcome") else { return };
    let mut files: Vec<_> = std::fs::read_dir(folder.join("bad")).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e != "md"));
    files.sort();
    let mut wrong = Vec::new();
    for path in &files {
        let name = path.file_name().unwrap().to_str().unwrap();
        let result = import(path, &ImportOptions::default());
        if let Err(error) = &result {
            assert!(error.to_string().contains(name) || name == "missing_bin.gltf", "{error}");
        }
        let found = outcome(&result);
        let want = BAD.iter().find(|(n, _)| *n == name).map(|(_, o)| *o);
        if want != Some(&found) {
            let message = result.err().map(|e| e.to_string().replace(path.parent().unwrap().to_str().unwrap(), ""));
            wrong.push(format!("(\"{name}\", \"{found}\"), // {}", message.unwrap_or_default()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(files.len(), BAD.len());
}

/// A small generator of pseudo-random numbers (splitmix64), so that every run does the same.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

fn mutate(name: &str, bytes: &[u8], rounds: usize) {
    let mut random = Random(7);
    let head = bytes.len().min(6000);
    for round in 0..rounds {
        let mut bad = bytes.to_vec();
        for _ in 0..1 + random.below(6) {
            let at = if random.below(4) > 0 { random.below(head) } else { random.below(bad.len()) };
            match random.below(4) {
                0 => bad[at] ^= 1 << random.below(8),
                1 => bad[at] = b"0123456789-,.\"[]{}e/\n\\"[random.below(22)],
                2 => bad[at] = random.below(256) as u8,
                _ => bad.swap(at, random.below(head)),
            }
        }
        if random.below(8) == 0 {
            bad.truncate(random.below(bad.len()));
        }
        let result = load_with(name, &bad, &ImportOptions::default());
        if let Ok(got) = &result {
            check(got);
        }
        // The guard against panics is a last resort that no test file may need.
        assert!(!is_malformed(&result, "stopped the reader"), "{name}, round {round}");
    }
}

#[test]
fn damaged_files_neither_panic_nor_hang() {
    mutate("square.glb", &square().finish(), 2000);
    let quad = "o a\ng b\nusemtl c\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/1 4\nf -1 -2 -3\n";
    mutate("quad.obj", quad.as_bytes(), 2000);
    let Some(folder) = garments_or_skip("damaged_files_neither_panic_nor_hang") else { return };
    let read = |file: &str| std::fs::read(folder.join(file)).unwrap();
    for file in ["bad/skin_ok_tube.glb", "bad/polygons_negative.obj", "bad/zero_area.glb"] {
        mutate(Path::new(file).file_name().unwrap().to_str().unwrap(), &read(file), 500);
    }
    mutate("shorts.glb", &read("compressed/shorts_meshopt.glb"), 60);
    mutate("polo.glb", &read("compressed/polo_draco.glb"), 60);
}
