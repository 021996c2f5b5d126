//! A sleeve whose upper half is skinned and whose lower half is cloth: no crack opens between them.

use gimage::colliders::ColliderOptions;
use gimage::import::{Character, ImportOptions};
use gimage::options::BuildOptions;
use gimage::pipeline::{Built, dress};
use gimage::progress::Quiet;
use gimage_bundle::{Bundle, RenderFile};
use gimage_runtime::{Backend, Cloth, Options, RenderMesh, Scene, Stepper};
use gimage_tests::{asset, build, reread, texels};
use serde_json::{Value, json};

/// Where the halves meet \[m\].
const MIDDLE: f32 = 0.450_01;

/// `sleeve.glb` with a primitive of the material `upper` towards the shoulder and one of the material `lower` towards the wrist.
fn two_halves() -> Vec<u8> {
    let bytes = std::fs::read(asset("sleeve.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let mut bin = bytes[28 + length..].to_vec();
    let primitive = json["meshes"][0]["primitives"][0].clone();
    let view = |json: &Value, accessor: &Value| {
        let view = &json["bufferViews"]
            [json["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"].as_u64().unwrap() as usize];
        view["byteOffset"].as_u64().unwrap_or(0) as usize..
    };
    let count = json["accessors"][primitive["indices"].as_u64().unwrap() as usize]["count"].as_u64().unwrap() as usize;
    let (at, list) =
        (view(&json, &primitive["attributes"]["POSITION"]).start, view(&json, &primitive["indices"]).start);
    let index = |k: usize| u16::from_le_bytes([bin[list + 2 * k], bin[list + 2 * k + 1]]);
    let x = |v: u16| f32::from_le_bytes(bin[at + 12 * v as usize..][..4].try_into().unwrap());
    let triangles: Vec<[u16; 3]> = (0..count / 3).map(|t| [0, 1, 2].map(|c| index(3 * t + c))).collect();
    let halves = [true, false].map(|arm| -> Vec<u8> {
        let own = triangles.iter().filter(|t| t.iter().all(|v| x(*v) < MIDDLE) == arm);
        own.flatten().flat_map(|v| v.to_le_bytes()).collect()
    });
    json["materials"] = json!([{"name": "upper"}, {"name": "lower"}]);
    let mut primitives = Vec::new();
    for (k, half) in halves.iter().enumerate() {
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": half.len()}));
        let view = views.len() - 1;
        let accessors = json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": 5123, "count": half.len() / 2, "type": "SCALAR"}));
        let mut own = primitive.clone();
        own["indices"] = json!(accessors.len() - 1);
        own["material"] = json!(k);
        primitives.push(own);
        bin.extend(half);
        bin.resize(bin.len().next_multiple_of(4), 0);
    }
    json["meshes"][0]["primitives"] = json!(primitives);
    json["buffers"] = json!([{"byteLength": bin.len()}]);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + text.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

fn options() -> BuildOptions {
    let mut options = texels(1000);
    options.select.cloth = vec!["lower".parse().unwrap()];
    options
}

fn dressed(change: impl Fn(&mut BuildOptions)) -> Built {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("halves.glb");
    std::fs::write(&path, two_halves()).unwrap();
    let mut options = options();
    options.select.body = vec!["upper".parse().unwrap()];
    change(&mut options);
    dress(&path, &options, &ColliderOptions::default(), &Quiet).unwrap()
}

/// The rest positions and influences of the vertices of the sleeve, and the first vertex of the render mesh that is one.
fn source(bundle: &Bundle) -> (usize, gimage_bundle::RenderPrimitive) {
    let file = RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap();
    let mut first = 0;
    for primitive in file.primitives().unwrap() {
        if !primitive.coords.is_empty() {
            return (first, primitive);
        }
        first += primitive.positions.len();
    }
    panic!("nothing is bound");
}

#[test]
fn a_border_with_a_skinned_part_stays_on_the_skin() {
    let built = dressed(|_| {});
    let finding = built.report.findings.iter().find(|f| f.kind == "hint-blend").expect("a finding of the border");
    assert!(finding.message.contains("the border is pinned") && finding.message.contains("0.05 m"), "{finding:?}");
    let bundle = reread(&built.bundle);
    let blends = bundle.blends().expect("a map");
    for (k, share) in (0u32..).zip(&blends) {
        let from = f64::from(bundle.position(k).unwrap()[0] - 0.45);
        assert!((0.0..=1.0).contains(share));
        assert!(from > 1e-3 || *share == 0.0, "{k}: {share} at {from} m");
        // The distance along the images is at least the distance in space. The border takes up one texel of it.
        assert!(from < 0.09 || *share == 1.0, "{k}: {share} at {from} m");
    }
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let (first, source) = source(&bundle);
    assert!(mesh.blended() > 50 && source.sets == 1);
    let path = asset("sleeve.glb");
    let character = Character::read(&path, "swing", &ImportOptions::default()).unwrap();
    let mut cloth = Cloth::from_bundle("sleeve", &bundle).unwrap();
    let skin = cloth.skin().unwrap().clone();
    let nodes: Vec<usize> = skin.joints().iter().map(|j| character.node(&j.name).unwrap()).collect();
    let joints = |time: f64| {
        let worlds = character.worlds(time);
        skin.matrices(&nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect::<Vec<_>>()).unwrap()
    };
    cloth.follow_joints(&joints(0.0)).unwrap();
    let mut scene = Scene::new("sleeve");
    scene.cloths.push(cloth);
    let mut stepper = Stepper::on_cpu(scene, Options { backend: Backend::Cpu, ..Options::default() }).unwrap();
    let (mut border, mut moved, mut free) = (0, 0.0f64, 0.0f64);
    let mut out = Vec::new();
    for frame in 1..=30 {
        let matrices = joints(f64::from(frame) / 60.0);
        stepper.set_joints(0, &matrices).unwrap();
        stepper.advance(1.0 / 60.0).unwrap();
        stepper.wrap(0, &mesh, 1.0, &mut out).unwrap();
        for (v, rest) in source.positions.iter().enumerate() {
            let [x, y, z] = rest.map(f64::from);
            let (joints, weights) = source.influences[v];
            let to: [f64; 3] = std::array::from_fn(|r| {
                let one = |m: &[f32; 16]| {
                    let m = m.map(f64::from);
                    m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]
                };
                joints.iter().zip(weights).map(|(j, w)| f64::from(w) * one(&matrices[*j as usize])).sum()
            });
            let at = out[first + v].position;
            let far = (0..3).map(|c| (f64::from(at[c]) - to[c]).powi(2)).sum::<f64>().sqrt();
            if source.coords[v][0] >= 0.0 && (rest[0] - 0.45).abs() < 1e-3 {
                assert!(far < 1e-6, "frame {frame}: vertex {v} of the border is {far} m off the skin");
                border += 1;
                moved = moved.max((0..3).map(|c| (to[c] - [x, y, z][c]).abs()).fold(0.0, f64::max));
            } else if rest[0] > 0.6 && source.coords[v][0] >= 0.0 {
                free = free.max(far);
            }
        }
    }
    assert!(border >= 24 * 30, "{border} vertices on the border");
    assert!(moved > 0.1 && free > 1e-3, "the border moves by {moved} m, cloth is {free} m off the skin");
}

#[test]
fn expressions_and_widths_set_the_blend() {
    let none = dressed(|options| options.blend.width = Some("none".parse().unwrap())).bundle;
    assert!(none.blends().is_none() && source(&none).1.influences.is_empty());
    let wide = dressed(|options| {
        options.blend.width = Some("0.1".parse().unwrap());
        options.assemble.blends =
            vec!["box:0.6,1,-1,1,2,1=0.25".parse().unwrap(), "box:0.68,1,-1,1,2,1=0".parse().unwrap()];
    });
    let shares = wide.bundle.blends().unwrap();
    for (k, share) in (0u32..).zip(&shares) {
        let x = wide.bundle.position(k).unwrap()[0];
        match x {
            0.601..0.679 => assert_eq!(*share, 0.25, "{x}"),
            0.681.. => assert_eq!(*share, 0.0, "{x}"),
            0.57..0.599 => assert_eq!(*share, 1.0, "{x}"),
            _ => {}
        }
    }
    assert_eq!(wide.bundle.manifest.options["blend_width"], json!("0.1"));
    // A build makes no blend of its own, and says nothing of it in its manifest.
    let plain = build(&asset("sleeve.glb"), &texels(400)).unwrap().bundle;
    assert!(plain.blends().is_none());
    assert!(["blend", "blend_width"].iter().all(|option| !plain.manifest.options.contains_key(*option)));
}
