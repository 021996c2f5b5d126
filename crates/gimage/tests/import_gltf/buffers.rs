//! Buffers, accessors and their compression.

use gimage::Error;
use gimage::import::ImportOptions;
use gimage::mesh::Semantic;
use serde_json::json;

use super::{area, face_normal};
use crate::support::*;

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

#[test]
fn limits_are_kept() {
    let few = ImportOptions { max_vertices: 3, ..Default::default() };
    assert!(matches!(load_with("a.glb", &square().finish(), &few), Err(Error::TooLarge { .. })));
    let few = ImportOptions { max_triangles: 1, max_vertices: 4, ..Default::default() };
    assert!(matches!(load_with("a.glb", &square().finish(), &few), Err(Error::TooLarge { .. })));
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
