//! A cape that an animation of its file takes into the body beside its pins.

use gimage::colliders::{ColliderOptions, Tier};
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage_runtime::Cloth;
use gimage_tests::texels;
use serde_json::{Value, json};

/// The text and the buffer of a file: a block as tall as a person, and a cape 10 mm behind it at its upper edge, each on a joint. The animation takes the joint of the cape 60 mm into the block.
fn character(is_animated: bool) -> (String, Vec<u8>) {
    let (mut bytes, mut views, mut accessors): (Vec<u8>, Vec<Value>, Vec<Value>) = Default::default();
    let mut add = |kind: &str, component: u32, count: usize, data: &[u8]| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        accessors
            .push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let block: Vec<[f32; 3]> = (0..8u32)
        .map(|k| {
            [
                if k & 1 == 1 { 0.2 } else { -0.2 },
                if k & 2 == 2 { 1.7 } else { 0.0 },
                if k & 4 == 4 { 0.15 } else { -0.15 },
            ]
        })
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let sides: Vec<u16> = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let grid = |k: u16| (f32::from(k % 17) / 16.0, f32::from(k / 17) / 16.0);
    let sheet: Vec<[f32; 3]> =
        (0..289).map(grid).map(|(u, v)| [0.3 * u - 0.15, 1.6 - 0.9 * v, 0.16 + 0.2 * v]).collect();
    let cells: Vec<u16> =
        (0..272).filter(|k| k % 17 < 16).flat_map(|k| [k, k + 17, k + 1, k + 1, k + 17, k + 18]).collect();
    let mut mesh = |name: &str, joint: u8, positions: &[[f32; 3]], indices: &[u16]| {
        let count = positions.len();
        let at = add("VEC3", 5126, count, &floats(positions.as_flattened()));
        let joints = add("VEC4", 5121, count, &[joint, 0, 0, 0].repeat(count));
        let weights = add("VEC4", 5126, count, &floats(&[1.0, 0.0, 0.0, 0.0].repeat(count)));
        let corners =
            add("SCALAR", 5123, indices.len(), &indices.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>());
        json!({"name": name, "primitives": [
            {"attributes": {"POSITION": at, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": corners}]})
    };
    let meshes = [mesh("Body", 0, &block, &sides), mesh("Cape", 1, &sheet, &cells)];
    let times = add("SCALAR", 5126, 2, &floats(&[0.0, 1.0]));
    let way = add("VEC3", 5126, 2, &floats(&[0.0, 0.0, 0.0, 0.0, 0.0, -0.06]));
    for k in [0, 4, times] {
        accessors[k]["min"] = json!(if k == times { vec![0.0] } else { vec![-0.2; 3] });
        accessors[k]["max"] = json!(if k == times { vec![1.0] } else { vec![1.7; 3] });
    }
    let go = json!([{"name": "go", "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                     "samplers": [{"input": times, "output": way}]}]);
    let text = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2, 3]}],
        "nodes": [{"name": "spine", "children": [1]}, {"name": "neck"},
                  {"name": "Body", "mesh": 0, "skin": 0}, {"name": "Cape", "mesh": 1, "skin": 0}],
        "skins": [{"joints": [0, 1]}], "meshes": meshes, "animations": if is_animated { go } else { json!([]) },
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(), "uri": "block.bin"}],
    });
    (text.to_string(), bytes)
}

/// The positions of a dressed cape, whether each is pinned, and whether the build says that cloth is taken into the body.
fn dressed(is_animated: bool, tier: Tier) -> (Vec<([f32; 3], bool)>, bool) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("block.gltf");
    let (text, buffer) = character(is_animated);
    std::fs::write(&file, text).unwrap();
    std::fs::write(folder.path().join("block.bin"), buffer).unwrap();
    let mut options = texels(900);
    options.select.cloth = vec!["Cape".parse().unwrap()];
    let built = dress(&file, &options, &ColliderOptions { tier, ..Default::default() }, &Quiet).unwrap();
    let cloth = Cloth::from_bundle("cape", &built.bundle).unwrap();
    let pinned = cloth.particles().iter().map(|p| p.is_pinned());
    let said = built.report.findings.iter().any(|f| f.kind == "hint-sunk");
    (cloth.positions().iter().copied().zip(pinned).collect(), said)
}

#[test]
fn cloth_that_an_animation_takes_into_the_body_beside_pins_is_pinned() {
    let (still, said) = dressed(false, Tier::Surface);
    assert!(!said && still.iter().any(|x| x.1) && still.iter().any(|x| !x.1));
    let (moved, said) = dressed(true, Tier::Surface);
    assert!(said);
    let mut more = 0;
    for ((p, was), (_, is)) in still.iter().zip(&moved) {
        // Limits end 0.17 m along the cloth from the pins.
        let (depth, is_near) = (0.15 - (p[2] - 0.06), p[1] > 1.45);
        assert!(*is || !was, "{p:?} was pinned");
        assert!(*is || depth < 4e-3 || !is_near, "{p:?} is taken into the body and free");
        assert!(*was || !is || depth > 0.0, "{p:?} stays outside and is pinned");
        more += usize::from(*is && !was);
    }
    assert!(more > 20, "{more}");
    assert_eq!(dressed(true, Tier::Auto).0, moved);
    // Cloth on capsules is not caught in a surface.
    assert_eq!(dressed(true, Tier::Capsules), dressed(false, Tier::Capsules));
}
