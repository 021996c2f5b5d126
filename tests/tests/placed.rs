//! Where a file puts its meshes: nodes that viewers ignore, that mirror, and primitives that compression has rounded one by one.

use std::path::Path;

use gimage::import::{ImportOptions, import};
use gimage::options::BuildOptions;
use gimage_bundle::Bundle;
use gimage_runtime::{RenderMesh, RenderVertex};
use gimage_tests::glb::Glb;
use gimage_tests::shapes::{Random, sheet};
use gimage_tests::{asset, build, check, reread, texels, texels_of};
use serde_json::{Value, json};

use crate::drawn::stepper;

/// The T-shirt of a figure.
fn shirt() -> BuildOptions {
    let mut options = texels(1024);
    options.select.cloth = vec!["T-shirt".parse().unwrap()];
    options
}

/// The figure with other nodes, in a folder.
fn figure(folder: &Path, change: impl Fn(&mut Value)) -> Bundle {
    let mut file = Glb::read(&asset("figure.glb"));
    change(&mut file.json);
    let path = folder.join("figure.glb");
    file.write(&path);
    let built = build(&path, &shirt()).unwrap();
    check("figure.glb", &built);
    reread(&built.bundle)
}

/// The corners of the box of the particles of a bundle \[m\].
fn bounds(bundle: &Bundle) -> [[f64; 3]; 2] {
    let all = (0..bundle.manifest.pieces.len()).flat_map(|piece| texels_of(bundle, piece));
    let there = bundle.particles().unwrap().into_iter().zip(all).filter(|(particle, _)| particle.exists());
    let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for (_, texel) in there {
        for k in 0..3 {
            corners[0][k] = corners[0][k].min(texel[k].into());
            corners[1][k] = corners[1][k].max(texel[k].into());
        }
    }
    corners
}

fn gap(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_skinned_mesh_stands_as_its_joints_pose_it_wherever_its_node_is() {
    let folder = tempfile::tempdir().unwrap();
    let plain = figure(folder.path(), |_| {});
    // As from programs whose unit is a centimetre and whose z is up: viewers draw the same.
    let hung = figure(folder.path(), |json| {
        let h = 0.5f64.sqrt();
        let nodes = json["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"name": "Armature", "scale": [0.01, 0.01, 0.01], "rotation": [-h, 0.0, 0.0, h], "children": [0, 1, 2]}));
        json["scenes"][0]["nodes"] = json!([22, 3]);
    });
    assert!(gap(bounds(&plain), bounds(&hung)) < 1e-4, "{:?} {:?}", bounds(&plain), bounds(&hung));
    let binds = |bundle: &Bundle| -> Vec<f32> {
        bundle.manifest.skeleton.iter().flat_map(|s| &s.joints).flat_map(|joint| joint.inverse_bind).collect()
    };
    assert!(binds(&plain).iter().zip(binds(&hung)).all(|(a, b)| (a - b).abs() < 1e-4));
    let [a, b] = [&plain, &hung].map(drawn);
    let far = a.iter().zip(&b).flat_map(|(a, b)| (0..3).map(|k| (a.position[k] - b.position[k]).abs()));
    assert!(a.len() == b.len() && far.fold(0.0, f32::max) < 1e-3);
    // Joints below a node that scales make the whole figure larger.
    let large = figure(folder.path(), |json| {
        json["nodes"].as_array_mut().unwrap().push(json!({"scale": [2.0, 2.0, 2.0], "children": [3]}));
        json["scenes"][0]["nodes"] = json!([0, 1, 2, 22]);
    });
    let twice = bounds(&plain).map(|corner| corner.map(|x| 2.0 * x));
    assert!(gap(twice, bounds(&large)) < 2e-4, "{twice:?} {:?}", bounds(&large));
}

#[test]
fn a_root_that_is_bound_in_another_size_does_not_say_how_large_a_mesh_is() {
    let folder = tempfile::tempdir().unwrap();
    let plain = figure(folder.path(), |_| {});
    // As from programs that put a joint above all others, which no vertex follows.
    let mut file = Glb::read(&asset("figure.glb"));
    let skin = &file.json["skins"][0];
    let accessor = skin["inverseBindMatrices"].as_u64().unwrap() as usize;
    let joints = skin["joints"].as_array().unwrap().len();
    let root = file.json["nodes"].as_array().unwrap().len();
    let view = file.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    let offset = |json: &Value| json["byteOffset"].as_u64().unwrap_or(0) as usize;
    let start = offset(&file.json["bufferViews"][view]) + offset(&file.json["accessors"][accessor]);
    let mut binds = file.bytes[start..start + 64 * joints].to_vec();
    let small: [f32; 16] = std::array::from_fn(|k| {
        if k == 15 {
            1.0
        } else if k % 5 == 0 {
            0.25
        } else {
            0.0
        }
    });
    binds.extend(small.iter().flat_map(|x| x.to_le_bytes()));
    file.bytes.resize(file.bytes.len().next_multiple_of(4), 0);
    let views = file.json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": file.bytes.len(), "byteLength": binds.len()}));
    let view = views.len() - 1;
    file.bytes.extend(binds);
    let json = &mut file.json;
    json["buffers"][0]["byteLength"] = json!(file.bytes.len());
    let mut own = json["accessors"][accessor].clone();
    (own["bufferView"], own["byteOffset"], own["count"]) = (json!(view), json!(0), json!(joints + 1));
    json["accessors"].as_array_mut().unwrap().push(own);
    json["skins"][0]["inverseBindMatrices"] = json!(json["accessors"].as_array().unwrap().len() - 1);
    json["skins"][0]["joints"].as_array_mut().unwrap().push(json!(root));
    json["nodes"].as_array_mut().unwrap().push(json!({"name": "_rootJoint", "children": [3]}));
    json["scenes"][0]["nodes"] = json!([0, 1, 2, root]);
    let path = folder.path().join("rooted.glb");
    file.write(&path);
    let rooted = reread(&build(&path, &shirt()).unwrap().bundle);
    assert!(gap(bounds(&plain), bounds(&rooted)) < 1e-4, "{:?} {:?}", bounds(&plain), bounds(&rooted));
}

/// The drawn vertices of a bundle at rest.
fn drawn(bundle: &Bundle) -> Vec<RenderVertex> {
    let mesh = RenderMesh::from_bundle(bundle).unwrap().unwrap();
    let mut vertices = Vec::new();
    stepper(bundle).wrap(0, &mesh, 1.0, &mut vertices).unwrap();
    vertices
}

#[test]
fn triangles_of_a_mirrored_node_wind_as_their_normals_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tshirt.glb");
    let mut file = Glb::read(&asset("tshirt.glb"));
    for node in file.json["nodes"].as_array_mut().unwrap().iter_mut().filter(|node| node["mesh"].is_u64()) {
        node["scale"] = json!([-1.0, 1.0, 1.0]);
    }
    file.write(&path);
    let bundle = reread(&build(&path, &texels(1024)).unwrap().bundle);
    let (mesh, vertices) = (RenderMesh::from_bundle(&bundle).unwrap().unwrap(), drawn(&bundle));
    let along = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| vertices[v as usize].position);
        let [p, q] = [b, c].map(|end| [0, 1, 2].map(|k| end[k] - a[k]));
        let face = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
        t.iter().all(|v| (0..3).map(|k| face[k] * vertices[*v as usize].normal[k]).sum::<f32>() > 0.0)
    };
    let triangles = mesh.indices.as_chunks::<3>().0;
    let alike = triangles.iter().filter(|t| along(t)).count();
    assert!(10 * alike > 9 * triangles.len(), "{alike} of {}", triangles.len());
}

/// A file of two primitives that meet along a wavy line, each rounded to a grid of 2^`bits` - 1 cells along its box.
fn halves(path: &Path, bits: u32) {
    let wave = |u: f64, v: f64| [u + 0.07 * (9.0 * v).sin(), v, 0.2 * (5.0 * u + 3.0 * v).sin()];
    let parts: Vec<_> = [0.0, 0.9]
        .into_iter()
        .map(|from| sheet(20, 24, &mut Random(3), |u, v| wave(from + 0.9 * u, 1.3 * v)))
        .collect();
    let (mut bytes, mut views, mut accessors, mut primitives) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for part in parts {
        let of = |k: usize| part.positions.iter().map(move |p| p[k]);
        let low = [0, 1, 2].map(|k| of(k).fold(f64::INFINITY, f64::min));
        let high = [0, 1, 2].map(|k| of(k).fold(f64::NEG_INFINITY, f64::max));
        let cell = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max) / f64::from((1u32 << bits) - 1);
        let round = |p: &[f64; 3]| [0, 1, 2].map(|k| (low[k] + ((p[k] - low[k]) / cell).round() * cell) as f32);
        let positions: Vec<u8> = part.positions.iter().flat_map(round).flat_map(f32::to_le_bytes).collect();
        let indices: Vec<u8> = part.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        for (data, kind, component, width) in [(positions, "VEC3", 5126, 12), (indices, "SCALAR", 5125, 4)] {
            views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
            accessors.push(json!({"bufferView": views.len() - 1, "componentType": component, "count": data.len() / width, "type": kind}));
            bytes.extend(data);
        }
        let n = accessors.len();
        primitives.push(json!({"attributes": {"POSITION": n - 2}, "indices": n - 1}));
    }
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}], "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": bytes.len()}],
    });
    Glb { json, bytes }.write(path);
}

#[test]
fn primitives_that_were_rounded_to_grids_of_their_own_are_one_piece() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("halves.glb");
    for bits in [11, 14] {
        halves(&path, bits);
        let raw = import(&path, &ImportOptions::default()).unwrap().mesh;
        let mut places: Vec<[u64; 3]> = raw.positions.iter().map(|p| p.map(f64::to_bits)).collect();
        places.sort_unstable();
        let shared = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert!(shared < 15, "{bits} bits: most of the border is cracked: {shared} of 25 vertices are shared");
        let built = build(&path, &texels(1024)).unwrap();
        check("halves.glb", &built);
        assert_eq!(built.bundle.manifest.pieces.len(), 1, "{bits} bits");
        let joined = built.report.findings.iter().find(|f| f.kind == "rounded-borders").unwrap();
        assert_eq!(joined.count as usize, 25 - shared, "{bits} bits");
    }
}
