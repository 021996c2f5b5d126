//! glTF features, each on the smallest file that shows it.

mod support;

use gimage::Error;
use gimage::import::{ImportOptions, Up};
use gimage::mesh::{NONE, Semantic};
use serde_json::json;
use support::*;

fn area(imported: &gimage::import::Imported) -> f64 {
    check(imported);
    (0..imported.mesh.triangles.len()).map(|t| imported.mesh.triangle_area(t)).sum()
}

fn face_normal(mesh: &gimage::Mesh, t: usize) -> [f64; 3] {
    let [a, b, c] = mesh.corners(t);
    let (u, v): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

#[test]
fn a_square_keeps_its_attributes() {
    let got = load(square()).unwrap();
    assert_eq!((area(&got), got.mesh.positions.len(), got.findings.len()), (1.0, 4, 0));
    assert_eq!(got.mesh.parts[0].node, "n");
    assert_eq!(got.mesh.channel(&Semantic::TexCoord(0)).unwrap().at(1, 2), Some(&[0.0, 0.0][..]));
    assert_eq!(got.mesh.channel(&Semantic::Normal).unwrap().at(0, 0), Some(&[0.0, 0.0, 1.0][..]));
    assert_eq!((got.source.file_name.as_str(), got.source.sha256.len()), ("test.glb", 64));
}

#[test]
fn every_index_type_and_none() {
    for component in [U8, U16, U32, 0] {
        let mut glb = Glb::default();
        let order = [0u32, 1, 2, 0, 2, 3];
        if component == 0 {
            let soup: Vec<f32> = order.iter().flat_map(|&v| SQUARE[3 * v as usize..][..3].to_vec()).collect();
            let p = glb.floats("VEC3", &soup);
            glb.mesh(json!({"attributes": {"POSITION": p}}));
        } else {
            let p = glb.floats("VEC3", &SQUARE);
            let bytes: Vec<u8> = match component {
                U8 => order.iter().map(|&v| v as u8).collect(),
                U16 => order.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
                _ => order.iter().flat_map(|&v| v.to_le_bytes()).collect(),
            };
            let i = glb.accessor("SCALAR", component, 6, &bytes);
            glb.mesh(json!({"attributes": {"POSITION": p}, "indices": i}));
        }
        assert_eq!(area(&load(glb).unwrap()), 1.0);
    }
}

#[test]
fn strips_and_fans_keep_their_winding() {
    for (mode, order) in [(5, vec![0u16, 1, 3, 2]), (6, vec![0, 1, 2, 3]), (5, vec![0, 1, 3, 2, 2, 2])] {
        let mut glb = Glb::default();
        let p = glb.floats("VEC3", &SQUARE);
        let i = glb.u16s(&order);
        glb.mesh(json!({"attributes": {"POSITION": p}, "indices": i, "mode": mode}));
        let got = load(glb).unwrap();
        assert_eq!((got.mesh.triangles.len(), area(&got)), (2, 1.0));
        assert!((0..2).all(|t| face_normal(&got.mesh, t)[2] > 0.0), "mode {mode}");
    }
}

#[test]
fn sparse_values_replace_their_elements() {
    let mut glb = square();
    let i = glb.view(&[2, 0]);
    let v = glb.view(&[3f32, 3.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    glb.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": i, "componentType": U16}, "values": {"bufferView": v}
    });
    assert_eq!(load(glb).unwrap().mesh.positions[2], [3.0, 3.0, 0.0]);

    let mut glb = square();
    let i = glb.view(&[200, 0]);
    glb.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": i, "componentType": U16}, "values": {"bufferView": 0}
    });
    assert!(is_malformed(&load(glb), "element 200 of 4"));
}

#[test]
fn normalised_and_quantised_integers() {
    let mut glb = square();
    let shorts: Vec<u8> = SQUARE
        .chunks(3)
        .flat_map(|p| [p[0], p[1], p[2], 0.0])
        .flat_map(|x| ((x * 32767.0) as i16).to_le_bytes())
        .collect();
    let view = glb.view(&shorts);
    glb.json["bufferViews"][view]["byteStride"] = json!(8);
    let p = glb.push(
        "accessors",
        json!({"bufferView": view, "componentType": I16, "count": 4, "type": "VEC3", "normalized": true}),
    );
    let c = glb.accessor("VEC3", U8, 4, &[255, 0, 51, 255, 0, 51, 255, 0, 51, 255, 0, 51]);
    glb.json["accessors"][c]["normalized"] = json!(true);
    let x = glb.accessor("SCALAR", U16, 4, &[1, 0, 2, 0, 3, 0, 4, 0]);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(p);
    attributes["COLOR_0"] = json!(c);
    attributes["_THICKNESS"] = json!(x);
    glb.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    glb.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    let got = load(glb).unwrap();
    assert_eq!(area(&got), 4.0);
    let color = got.mesh.channel(&Semantic::Color(0)).unwrap();
    assert_eq!(color.at(0, 0), Some(&[1.0, 0.0, 0.2, 1.0][..]));
    assert_eq!(got.mesh.channel(&Semantic::Custom("_THICKNESS".into())).unwrap().at(1, 2), Some(&[4.0][..]));
}

#[test]
fn buffers_in_data_uris_and_beside_the_file() {
    let mut glb = square();
    glb.bin.resize(glb.bin.len().next_multiple_of(4), 0);
    let bin = std::mem::take(&mut glb.bin);
    let mut json = glb.json.clone();
    let encoded = base64(&bin);
    json["buffers"][0] =
        json!({"byteLength": bin.len(), "uri": format!("data:application/octet-stream;base64,{encoded}")});
    let got = load_with("a.gltf", json.to_string().as_bytes(), &ImportOptions::default()).unwrap();
    assert_eq!(area(&got), 1.0);

    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/my data.bin"), &bin).unwrap();
    json["buffers"][0] = json!({"byteLength": bin.len(), "uri": "sub/my%20data.bin"});
    json["images"] = json!([{"uri": "not-there.png"}, {"broken": 1}]);
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    let got = gimage::import::import(&path, &ImportOptions::default()).unwrap();
    assert_eq!((area(&got), got.source.outside[0].name.as_str()), (1.0, "sub/my data.bin"));

    for uri in ["http://example.com/a.bin", "../a.bin", "/etc/passwd"] {
        json["buffers"][0]["uri"] = json!(uri);
        let got = load_with("a.gltf", json.to_string().as_bytes(), &ImportOptions::default());
        assert!(is_malformed(&got, uri), "{uri}");
    }
    json["buffers"][0]["uri"] = json!("gone.bin");
    let got = load_with("dir/a.gltf", json.to_string().as_bytes(), &ImportOptions::default());
    assert!(matches!(got, Err(Error::Io { path, .. }) if path.ends_with("dir/gone.bin")));
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |c: &[u8]| {
        let bits = (0..3).fold(0u32, |b, k| b << 8 | u32::from(c.get(k).copied().unwrap_or(0)));
        (0..4)
            .map(|k| if k > c.len() { '=' } else { DIGITS[(bits >> (18 - 6 * k) & 63) as usize] as char })
            .collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

#[test]
fn a_mirrored_node_keeps_its_outside_out() {
    let mut glb = square();
    glb.json["nodes"][0]["scale"] = json!([2, 1, -1]);
    let got = load(glb).unwrap();
    let normal = got.mesh.channel(&Semantic::Normal).unwrap();
    for t in 0..2 {
        assert!(face_normal(&got.mesh, t)[2] < 0.0);
        assert_eq!(normal.at(t, 0), Some(&[0.0, 0.0, -1.0][..]));
    }
    // Corners follow their vertices when the winding is turned.
    let uv = got.mesh.channel(&Semantic::TexCoord(0)).unwrap();
    for (t, c) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        let p = got.mesh.corners(t)[c];
        assert_eq!(uv.at(t, c), Some(&[(p[0] / 2.0) as f32, 1.0 - p[1] as f32][..]));
    }
}

#[test]
fn nodes_compose_and_instances_repeat() {
    let mut glb = square();
    let t = glb.floats("VEC3", &[0., 0., 0., 10., 0., 0., 20., 0., 0.]);
    let s = glb.floats("VEC3", &[1., 1., 1., 1., 1., 1., 2., 2., 2.]);
    glb.json["nodes"] = json!([
        {"children": [1], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]},
        {"mesh": 0, "name": "n", "translation": [1, 0, 0],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": t, "SCALE": s}}}}
    ]);
    let got = load(glb).unwrap();
    assert_eq!((got.mesh.triangles.len(), area(&got), got.mesh.parts.len()), (6, 6.0, 3));
    assert!(has(&got, "instances"));
    // Instance 2, corner (1, 0, 0): scaled to (2, 0, 0), moved to (22, 0, 0), to (23, 0, 0), turned to (0, 23, 0), moved.
    assert_eq!(got.mesh.corners(4)[1], [5.0, 23.0, 0.0]);
}

#[test]
fn the_unit_scales_and_must_be_one() {
    let options = ImportOptions { unit: 0.01, ..Default::default() };
    let got = load_with("a.glb", &square().finish(), &options).unwrap();
    assert_eq!(got.mesh.bounds().unwrap().1, [0.01, 0.01, 0.0]);
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = ImportOptions { unit, ..Default::default() };
        assert!(matches!(load_with("a.glb", &square().finish(), &options), Err(Error::Option { .. })));
    }
}

#[test]
fn a_scene_without_nodes_is_valid() {
    // Beside the scene that is shown: nothing changes.
    let mut glb = square();
    glb.json["scenes"] = json!([{"nodes": [0]}, {"name": "empty"}]);
    let got = load(glb).unwrap();
    assert_eq!((area(&got), got.findings.len()), (1.0, 0));
    // As the only one, or the default: the nodes of the others, else all of them.
    for (scenes, squares) in
        [(json!([{}]), 2.0), (json!([{"name": "Scene"}, {"nodes": [0]}]), 1.0), (json!([{"nodes": []}, {}]), 2.0)]
    {
        let mut glb = square();
        glb.json["scenes"] = scenes;
        glb.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 1]}]);
        let got = load(glb).unwrap();
        assert_eq!(area(&got), squares);
        assert!(has(&got, "empty-scene"), "{:?}", got.findings);
    }
    // Without nodes at all each mesh is placed once.
    let mut glb = square();
    glb.json["scenes"] = json!([{}]);
    glb.json.as_object_mut().unwrap().remove("nodes");
    let got = load(glb).unwrap();
    assert_eq!(area(&got), 1.0);
    assert!(has(&got, "no-scene") && !has(&got, "empty-scene"), "{:?}", got.findings);
    let mut glb = square();
    glb.json["scene"] = json!(3);
    assert!(is_malformed(&load(glb), "the default scene does not exist"));
}

#[test]
fn up_turns_positions_and_normals() {
    // The square faces z; with z up it faces y.
    let options = ImportOptions { up: Up::Z, ..Default::default() };
    let got = load_with("a.glb", &square().finish(), &options).unwrap();
    check(&got);
    assert_eq!(got.mesh.bounds(), Some(([0.0, 0.0, -1.0], [1.0, 0.0, 0.0])));
    assert_eq!(got.mesh.channel(&Semantic::Normal).unwrap().at(0, 0), Some(&[0.0, 1.0, 0.0][..]));
    assert!((0..2).all(|t| face_normal(&got.mesh, t) == [0.0, 1.0, 0.0]));
    // An OBJ file alike.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    let got = load_with("a.obj", text.as_bytes(), &ImportOptions { up: Up::MinusZ, ..Default::default() }).unwrap();
    assert_eq!(got.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(got.mesh.channel(&Semantic::Normal).unwrap().at(0, 0), Some(&[0.0, -1.0, 0.0][..]));
}

#[test]
fn pieces_are_kept_by_name() {
    let mut glb = square();
    glb.json["nodes"] = json!([{"mesh": 0, "name": "front"}, {"mesh": 0, "name": "back", "translation": [0, 0, -1]}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    glb.json["materials"] = json!([{"name": "wool"}]);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let bytes = glb.finish();
    for (name, triangles) in [("back", 2), ("m", 4), ("wool", 4)] {
        let options = ImportOptions { pieces: vec![name.into()], ..Default::default() };
        let got = load_with("a.glb", &bytes, &options).unwrap();
        assert_eq!((got.mesh.triangles.len(), got.mesh.parts[0].material.as_str()), (triangles, "wool"));
    }
    let options = ImportOptions { pieces: vec!["back".into(), "sleeve".into()], ..Default::default() };
    let error = load_with("a.glb", &bytes, &options).unwrap_err().to_string();
    assert!(error.contains("`sleeve`") && error.contains("`front`"), "{error}");
}

#[test]
fn node_graphs_must_be_forests() {
    let mut glb = square();
    glb.json["nodes"] = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]);
    assert!(is_malformed(&load(glb), "as a child"));
    let mut glb = square();
    glb.json["nodes"] = json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}]);
    assert!(is_malformed(&load(glb), "cycle"));
    // Deep chains must not exhaust the stack.
    let mut glb = square();
    let deep = 200_000;
    let mut nodes: Vec<_> = (0..deep).map(|i| json!({"children": [i + 1]})).collect();
    nodes.push(json!({"mesh": 0}));
    glb.json["nodes"] = json!(nodes);
    assert_eq!(area(&load(glb).unwrap()), 1.0);
}

#[test]
fn what_is_not_kept_is_told() {
    let mut glb = square();
    let t = glb.floats("VEC4", &[1.0; 16]);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(t);
    glb.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    glb.json["animations"] = json!([{}]);
    glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}}]}));
    let got = load(glb).unwrap();
    for kind in ["tangents", "morph-targets", "animations", "mesh-not-in-scene"] {
        assert!(has(&got, kind), "{kind}: {:?}", got.findings);
    }
}

#[test]
fn required_extensions() {
    let try_with = |name: &str| {
        let mut glb = square();
        glb.json["extensionsRequired"] = json!([name]);
        load(glb)
    };
    assert!(try_with("KHR_materials_unlit").is_ok());
    assert!(try_with("EXT_texture_webp").is_ok());
    match try_with("ACME_cloth") {
        Err(Error::Unsupported { feature, .. }) => assert!(feature.contains("ACME_cloth")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn meshopt_streams_under_both_names() {
    let order = [0u32, 1, 2, 0, 2, 3];
    let corners: Vec<[f32; 3]> = SQUARE.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
    let octahedral: [[f32; 4]; 4] = [[0.6, 0.0, 0.8, 0.0]; 4];
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mut glb = Glb::default();
        let streams = [
            (meshopt::encode_vertex_buffer(&corners).unwrap(), "ATTRIBUTES", "NONE", 12, 4),
            (meshopt::encode_index_buffer(&order, 4).unwrap(), "TRIANGLES", "NONE", 2, 6),
            (meshopt::encode_index_sequence(&order, 4).unwrap(), "INDICES", "NONE", 4, 6),
            (
                meshopt::encode_vertex_buffer(&meshopt::encode_filter_oct::<i16>(&octahedral, 16)).unwrap(),
                "ATTRIBUTES",
                "OCTAHEDRAL",
                8,
                4,
            ),
            (
                meshopt::encode_vertex_buffer(&meshopt::encode_filter_exp::<3>(
                    &corners,
                    15,
                    meshopt::EncodeExpMode::Separate,
                ))
                .unwrap(),
                "ATTRIBUTES",
                "EXPONENTIAL",
                12,
                4,
            ),
        ];
        let views = streams.map(|(bytes, mode, filter, stride, count)| {
            let view = glb.view(&bytes);
            let at = glb.json["bufferViews"][view]["byteOffset"].clone();
            let mut header = json!({"buffer": 0, "byteOffset": at, "byteLength": bytes.len(), "byteStride": stride,
                "count": count, "mode": mode});
            if filter != "NONE" {
                header["filter"] = json!(filter);
            }
            glb.json["bufferViews"][view] =
                json!({"buffer": 1, "byteLength": stride * count, "extensions": {name: header}});
            view
        });
        glb.push("buffers", json!({"byteLength": 1000, "extensions": {name: {"fallback": true}}}));
        glb.json["extensionsRequired"] = json!([name]);
        let mut accessor = |view: usize, component: u32, count: usize, kind: &str, normalized: bool| {
            let v = views[view];
            let a = json!({"bufferView": v, "componentType": component, "count": count, "type": kind, "normalized": normalized});
            glb.push("accessors", a)
        };
        let p = accessor(0, F32, 4, "VEC3", false);
        let i = [accessor(1, U16, 6, "SCALAR", false), accessor(2, U32, 6, "SCALAR", false)];
        let n = accessor(3, I16, 4, "VEC3", true);
        let e = accessor(4, F32, 4, "VEC3", false);
        let primitive = |p: usize, i: usize| json!({"attributes": {"POSITION": p, "NORMAL": n}, "indices": i});
        glb.push("meshes", json!({"primitives": [primitive(p, i[0]), primitive(e, i[1])]}));
        let got = load(glb).unwrap();
        assert!((area(&got) - 2.0).abs() < 1e-3);
        let normal = got.mesh.channel(&Semantic::Normal).unwrap().at(3, 1).unwrap();
        assert!((normal[0] - 0.6).abs() < 1e-3 && (normal[2] - 0.8).abs() < 1e-3, "{normal:?}");
    }
}

/// world * inverse_bind * position is what glTF's formula gives, whatever transform the mesh's node has.
#[test]
fn stored_binds_reproduce_the_skinned_positions() {
    let mut glb = square();
    let j = glb.accessor("VEC4", U8, 4, &[0, 1, 0, 0].repeat(4));
    let w = glb.floats("VEC4", &[0.25, 0.75, 0.0, 0.0].repeat(4));
    let bind = |x: f32| [2., 0., 0., 0., 0., 2., 0., 0., 0., 0., 2., 0., x, 1., 0., 1.];
    let b = glb.floats("MAT4", &[bind(0.0), bind(3.0)].concat());
    glb.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [7, 8, 9], "rotation": [0, 0, 0.6, 0.8], "scale": [1, -2, 3]},
        {"name": "root", "translation": [0, 1, 0], "children": [2]},
        {"name": "spacer", "children": [3]},
        {"name": "tip", "rotation": [1, 0, 0, 0], "translation": [0, 0, 5]}
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    glb.json["skins"] = json!([{"joints": [1, 3], "inverseBindMatrices": b}]);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(j);
    attributes["WEIGHTS_0"] = json!(w);
    let bytes = glb.finish();
    for unit in [1.0, 0.01] {
        let got = load_with("a.glb", &bytes, &ImportOptions { unit, ..Default::default() }).unwrap();
        check(&got);
        let joints = &got.mesh.skeleton.joints;
        assert_eq!((joints[0].name.as_str(), joints[0].parent), ("root", None));
        assert_eq!((joints[1].name.as_str(), joints[1].parent), ("tip", Some(0)));
        let apply = |m: &[f64; 16], p: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i])
        };
        for (v, stored) in got.mesh.positions.iter().enumerate() {
            let local: [f64; 3] = std::array::from_fn(|k| f64::from(SQUARE[3 * v + k]));
            // Joint 0: bind, then up by 1. Joint 1: bind, half a turn about x, then by (0, 1, 5).
            let b = |x: f64| [2.0 * local[0] + x, 2.0 * local[1] + 1.0, 2.0 * local[2]];
            let (p, q) = (b(0.0), b(3.0));
            let want = [[p[0], p[1] + 1.0, p[2]], [q[0], 1.0 - q[1], 5.0 - q[2]]];
            for k in 0..2 {
                let skinned = apply(&joints[k].world, apply(&joints[k].inverse_bind, *stored));
                assert!((0..3).all(|i| (skinned[i] - unit * want[k][i]).abs() < 1e-9), "{skinned:?} {:?}", want[k]);
            }
        }
        let weights = got.mesh.channel(&Semantic::Weights(0)).unwrap();
        assert_eq!(weights.at(0, 0), Some(&[0.25, 0.75, 0.0, 0.0][..]));
    }
    // Turned and moved, skin and surface still go together: what a joint does is turned and moved alike.
    let skinned = |got: &gimage::import::Imported| -> Vec<[f64; 3]> {
        let apply = |m: &[f64; 16], p: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i])
        };
        let joints = &got.mesh.skeleton.joints;
        let at = |p: &[f64; 3]| joints.iter().map(|j| apply(&j.world, apply(&j.inverse_bind, *p))).collect::<Vec<_>>();
        got.mesh.positions.iter().flat_map(at).collect()
    };
    let plain = load_with("a.glb", &bytes, &ImportOptions::default()).unwrap();
    for center in [false, true] {
        let got = load_with("a.glb", &bytes, &ImportOptions { up: Up::Z, center, ..Default::default() }).unwrap();
        let turned = |p: &[f64; 3]| [p[0], p[2], -p[1]];
        let by: [f64; 3] = std::array::from_fn(|k| got.mesh.positions[0][k] - turned(&plain.mesh.positions[0])[k]);
        assert_eq!(by != [0.0; 3], center);
        for (before, after) in skinned(&plain).iter().zip(skinned(&got)) {
            let want: [f64; 3] = std::array::from_fn(|k| turned(before)[k] + by[k]);
            assert!((0..3).all(|k| (after[k] - want[k]).abs() < 1e-9), "{after:?} {want:?}");
        }
    }
}

#[test]
fn channels_that_only_some_primitives_have() {
    let mut glb = square();
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 3});
    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().insert(0, primitive);
    let got = load(glb).unwrap();
    check(&got);
    let uv = got.mesh.channel(&Semantic::TexCoord(0)).unwrap();
    assert_eq!((uv.corners[..6].to_vec(), uv.at(2, 0)), (vec![NONE; 6], Some(&[0.0, 1.0][..])));
    assert_eq!(got.mesh.parts[1].primitive, 1);
}

#[test]
fn limits_are_kept() {
    let few = ImportOptions { max_vertices: 3, ..Default::default() };
    assert!(matches!(load_with("a.glb", &square().finish(), &few), Err(Error::TooLarge { .. })));
    let few = ImportOptions { max_triangles: 1, max_vertices: 4, ..Default::default() };
    assert!(matches!(load_with("a.glb", &square().finish(), &few), Err(Error::TooLarge { .. })));
}

#[test]
fn weights_are_made_sound() {
    let mut glb = square();
    let j = glb.accessor("VEC4", U8, 4, &[0, 1, 9, 0].repeat(4));
    // Halves that sum to 2; none; one on a joint that is not there; bytes' rounding.
    let w = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.5, 0.0, 0.25, 0.752, 0.0, 0.0];
    let w = glb.floats("VEC4", &w);
    glb.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"name": "a"}, {"name": "b"}]);
    glb.json["skins"] = json!([{"joints": [1, 2]}]);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(j);
    attributes["WEIGHTS_0"] = json!(w);
    let got = load(glb).unwrap();
    check(&got);
    let counts: Vec<_> = got.findings.iter().map(|f| (f.kind, f.count)).collect();
    assert_eq!(counts, [("joint-out-of-range", 1), ("unnormalised-weights", 2), ("zero-weights", 1)]);
    let [j, w] = [Semantic::Joints(0), Semantic::Weights(0)].map(|s| got.mesh.channel(&s).unwrap());
    assert_eq!(w.at(0, 0), Some(&[0.5, 0.5, 0.0, 0.0][..]));
    assert_eq!(w.at(0, 1), w.at(0, 0), "the first of the nearest");
    assert_eq!(w.at(0, 2), Some(&[1.0, 0.0, 0.0, 0.0][..]));
    assert!((w.at(1, 2).unwrap().iter().sum::<f32>() - 1.0).abs() < 1e-6);
    assert!(j.values.iter().all(|&k| k < 2.0));
}

#[test]
fn joints_without_a_skin_mean_nothing() {
    let mut glb = square();
    let j = glb.accessor("VEC4", U8, 4, &[0; 16]);
    let w = glb.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(4));
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(j);
    attributes["WEIGHTS_0"] = json!(w);
    let got = load(glb).unwrap();
    assert!(has(&got, "joints-without-skin") && got.mesh.skeleton.joints.is_empty());
    assert_eq!(got.mesh.channels.len(), 2);
}

#[test]
fn vertices_without_a_finite_position() {
    let mut glb = square();
    glb.bin[0..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(matches!(load(glb), Err(Error::Empty { .. })), "both triangles use it");
    let mut glb = square();
    glb.bin[12..16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let got = load(glb).unwrap();
    assert_eq!((got.mesh.triangles.len(), got.mesh.positions.len(), area(&got)), (1, 3, 0.5));
    assert!(has(&got, "non-finite-positions"));
}

#[test]
fn ranges_are_checked_before_they_are_read() {
    type Change = fn(&mut serde_json::Value);
    let tries: [(&str, Change); 7] = [
        ("4 elements of 12 bytes do not fit", |j| j["accessors"][0]["byteOffset"] = json!(8)),
        ("do not fit", |j| j["accessors"][0]["count"] = json!(16_000_000)),
        ("no such view", |j| j["accessors"][0]["bufferView"] = json!(99)),
        ("no such accessor", |j| j["meshes"][0]["primitives"][0]["indices"] = json!(99)),
        ("which has", |j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX)),
        ("one every 4", |j| j["bufferViews"][0]["byteStride"] = json!(4)),
        ("NORMAL has 2 components", |j| j["accessors"][1]["type"] = json!("VEC2")),
    ];
    for (words, damage) in tries {
        let mut glb = square();
        damage(&mut glb.json);
        let got = load(glb);
        assert!(is_malformed(&got, words), "{words}: {got:?}");
    }
}
