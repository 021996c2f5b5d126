//! Attributes and skins.

use gimage::Error;
use gimage::import::{ImportOptions, Up};
use gimage::mesh::{NONE, Semantic};
use serde_json::json;

use super::area;
use crate::support::*;

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
    // A transform of the scene applies to the surface and to its joints alike.
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
