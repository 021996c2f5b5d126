use super::*;
use crate::bundle::Bundle;
use crate::manifest::RenderEntry;
use crate::map::{Image, MapKind};
use crate::validate::{FaultKind, validate};

/// A container around a JSON text and bytes.
fn container(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    let total = 12 + 8 + text.len() + 8 + bin.len();
    out.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text[..]), (b"BIN\0", bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

/// One triangle whose vertices are bound as `coords` tell.
fn triangle(coords: [[f32; 3]; 3]) -> Vec<u8> {
    let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let offsets = [[0.0f32; 3]; 3];
    let floats = positions.iter().chain(&coords).chain(&offsets).flatten();
    let bin: Vec<u8> = floats.flat_map(|x| x.to_le_bytes()).collect();
    let accessor = |k: usize| {
        format!(r#"{{"bufferView":0,"byteOffset":{},"componentType":5126,"count":3,"type":"VEC3"}}"#, 36 * k)
    };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":108}}],"bufferViews":[{{"buffer":0,"byteLength":108}}],
        "accessors":[{},{},{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"{COORD}":1,"{OFFSET}":2}},
        "material":0}}]}}],"materials":[{{"alphaMode":"MASK","pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0,1]}}}}],
        "nodes":[{{"name":"a","children":[1],"translation":[0,2,0]}},{{"mesh":0,"scale":[2,2,2]}}]}}"#,
        accessor(0),
        accessor(1),
        accessor(2)
    );
    container(&json, &bin)
}

fn flag(render: Vec<u8>, bound: u64) -> Bundle {
    let mut bundle = Bundle::new("test");
    let piece = bundle.add_piece("flag", 2, 2).unwrap();
    let data = vec![0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0];
    bundle.insert(piece, MapKind::Position, Image { width: 2, height: 2, channels: 4, data }).unwrap();
    bundle.count().unwrap();
    bundle.render = Some(render);
    let transform = super::matrix::IDENTITY;
    bundle.manifest.render =
        Some(RenderEntry { file: RENDER_FILE.into(), vertices: 3, bound, largest_offset: 0.0, transform });
    bundle
}

#[test]
fn a_file_is_read_with_its_nodes_and_materials() {
    let bytes = triangle([[0.0, 0.0, 0.0], [0.0, 1.0, 0.5], [-1.0, 0.0, 0.0]]);
    let file = RenderFile::parse(&bytes).unwrap();
    let all = file.primitives().unwrap();
    assert_eq!(all.len(), 1);
    assert_eq!((all[0].world[0], all[0].world[13], &all[0].indices[..]), (2.0, 2.0, &[0, 1, 2][..]));
    assert_eq!(all[0].coords[1], [0.0, 1.0, 0.5]);
    let material = file.material(all[0].material);
    assert_eq!((material.base_color, material.cutoff), ([1.0, 0.5, 0.0, 1.0], Some(0.5)));
    assert_eq!(file.material(Some(9)), RenderMaterial::default());
}

#[test]
fn bindings_off_the_surface_are_faults() {
    let good = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.5], [-1.0, 0.0, 0.0]];
    assert_eq!(validate(&flag(triangle(good), 2)), []);
    let count = validate(&flag(triangle(good), 3));
    assert!(count.len() == 1 && count[0].kind == FaultKind::Count, "{count:?}");
    for bad in [[1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, f32::NAN, 0.0]] {
        let faults = validate(&flag(triangle([good[0], good[1], bad]), 2));
        assert!(faults.iter().any(|f| f.kind == FaultKind::Render && f.message.contains("vertex 2")), "{faults:?}");
    }
}

#[test]
fn a_bundle_with_a_file_comes_back() {
    let bundle = flag(triangle([[0.0, 0.0, 0.0]; 3]), 3);
    let files = bundle.encode().unwrap();
    assert_eq!(files.len(), 3);
    let back = Bundle::from_files(&files).unwrap();
    assert_eq!((&back.render, &back.manifest.render), (&bundle.render, &bundle.manifest.render));
    let mut changed = files.clone();
    changed.get_mut(RENDER_FILE).unwrap()[30] ^= 1;
    assert!(Bundle::from_files(&changed).unwrap_err().to_string().contains("SHA-256"));
}

#[test]
fn damage_is_an_error() {
    let bytes = triangle([[0.0; 3]; 3]);
    for end in 0..bytes.len() {
        assert!(RenderFile::parse(&bytes[..end]).is_err(), "{end}");
    }
    let replaced = |from: &str, to: &str| {
        let text = String::from_utf8_lossy(&bytes[20..]).into_owned();
        let json = text.split("BIN").next().unwrap();
        let json = &json[..json.rfind('}').unwrap() + 1];
        assert!(json.contains(from), "{from}");
        container(&json.replace(from, to), &[0; 108])
    };
    for (from, to) in [
        (r#""byteOffset":72"#, r#""byteOffset":76"#),
        (r#""count":3"#, r#""count":4000000000"#),
        (r#""componentType":5126"#, r#""componentType":5127"#),
        (r#""type":"VEC3""#, r#""type":"VEC2""#),
        (r#""byteLength":108}]"#, r#""byteLength":999}]"#),
        (r#""children":[1]"#, r#""children":[7]"#),
        (r#""mesh":0,"scale""#, r#""mesh":0,"children":[0],"scale""#),
        (r#""mesh":0,"scale""#, r#""mesh":3,"scale""#),
        (r#""_GIMAGE_OFFSET":2"#, r#""_OTHER":2"#),
    ] {
        let file = replaced(from, to);
        let result = RenderFile::parse(&file).and_then(|f| f.primitives());
        // A cycle leaves no root, and so nothing in the scene.
        assert!(result.as_ref().map_or(true, Vec::is_empty), "{from} {to}: {result:?}");
    }
}

#[test]
fn shares_of_the_blend_are_from_0_to_1() {
    let share = |x: f32| {
        let bytes = triangle([[0.0, 0.0, 0.0]; 3]);
        let text = String::from_utf8_lossy(&bytes[20..]).into_owned();
        let json = text.split("BIN").next().unwrap();
        let json = json[..json.rfind('}').unwrap() + 1].replace(r#""POSITION":0"#, r#""POSITION":0,"_GIMAGE_BLEND":3"#);
        let last = r#"{"bufferView":0,"byteOffset":108,"componentType":5126,"count":3,"type":"SCALAR"}],"meshes""#;
        let json = json.replace(r#"],"meshes""#, &format!(",{last}"));
        let json = json.replace(r#""byteLength":108"#, r#""byteLength":120"#);
        let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let floats = positions.into_iter().chain([[0.0; 3]; 6]).flatten().chain([1.0, x, 0.0]);
        flag(container(&json, &floats.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()), 3)
    };
    let file = share(0.25);
    assert_eq!(validate(&file), []);
    let file = RenderFile::parse(file.render.as_ref().unwrap()).unwrap();
    assert_eq!(file.primitives().unwrap()[0].blends, [1.0, 0.25, 0.0]);
    for wrong in [-0.1, 1.5, f32::NAN] {
        let faults = validate(&share(wrong));
        assert!(faults.iter().any(|f| f.to_string().contains("_GIMAGE_BLEND")), "{wrong}: {faults:?}");
    }
}

#[test]
fn a_host_in_memory_may_leave_the_mesh_out() {
    let mut files = flag(triangle([[0.0, 0.0, 0.0]; 3]), 3).encode().unwrap();
    let whole = Bundle::from_files(&files).unwrap();
    files.remove(RENDER_FILE).unwrap();
    let bare = Bundle::from_files(&files).unwrap();
    assert!(whole.render.is_some() && bare.render.is_none() && bare.manifest.render.is_none());
    assert_eq!((&bare.images, validate(&bare)), (&whole.images, vec![]));
    // A bundle on disk is whole or damaged.
    let read = |name: &str, _| files.get(name).cloned().ok_or(crate::Error::Missing { file: name.into() });
    assert!(matches!(Bundle::decode(read), Err(crate::Error::Missing { file }) if file == RENDER_FILE));
}
