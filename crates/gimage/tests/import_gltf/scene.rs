//! Nodes, units, axes, selection and extensions.

use gimage::Error;
use gimage::import::{ImportOptions, Up};
use gimage::mesh::Semantic;
use serde_json::json;

use super::{area, face_normal};
use crate::support::*;

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
    assert!(!has(&got, "hint-morphs"));
    let mut glb = square();
    glb.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    glb.json["meshes"][0]["weights"] = json!([0.5]);
    assert!(has(&load(glb).unwrap(), "hint-morphs"));
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
fn a_mesh_without_a_skin_follows_the_node_that_moves_it() {
    let mut glb = square();
    let times = glb.floats("SCALAR", &[0.0, 1.0]);
    let turns = glb.floats("VEC4", &[0., 0., 0., 1., 0., 0., 1., 0.]);
    glb.json["nodes"] = json!([
        {"mesh": 0, "name": "cape", "translation": [1, 0, 0]},
        {"name": "chest", "translation": [0, 2, 0], "children": [2]},
        {"name": "hook", "translation": [0, 0, 3], "children": [0]},
        {"mesh": 0, "name": "floor"}
    ]);
    glb.json["scenes"] = json!([{"nodes": [1, 3]}]);
    // Without an animation or a skin nothing moves.
    let mut still = square();
    still.json["nodes"] = glb.json["nodes"].clone();
    still.json["scenes"] = glb.json["scenes"].clone();
    assert!(load(still).unwrap().mesh.skeleton.joints.is_empty());
    glb.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
        "samplers": [{"input": times, "output": turns}]
    }]);
    let mesh = load(glb).unwrap().mesh;
    let [joint] = &mesh.skeleton.joints[..] else { panic!("{:?}", mesh.skeleton) };
    assert_eq!((joint.name.as_str(), joint.parent), ("chest", None));
    // From the world to the chest, as it stands in the file.
    assert_eq!(joint.inverse_bind[12..15], [0.0, -2.0, 0.0]);
    let (joints, weights) = (mesh.channel(&Semantic::Joints(0)).unwrap(), mesh.channel(&Semantic::Weights(0)).unwrap());
    for (t, part) in mesh.triangle_part.iter().enumerate() {
        let follows = mesh.parts[*part as usize].node == "cape";
        assert_eq!(joints.at(t, 0), follows.then_some(&[0.0; 4][..]));
        assert_eq!(weights.at(t, 0), follows.then_some(&[1.0, 0.0, 0.0, 0.0][..]));
    }
}
