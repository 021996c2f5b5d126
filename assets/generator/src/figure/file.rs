//! Writes skinned parts that share a skeleton as a GLB file of plain core glTF 2.0.

use gimage::export::glb::{BinaryChunk, Component, Target, bounds};
use serde_json::{Value, json};

use crate::glb::{Clip, Joint, Skin, add_skeleton, animation};
use crate::surface::Surface;

/// A mesh with its material.
pub struct Part {
    /// The name of mesh and node.
    pub name: &'static str,
    /// The name of the material.
    pub material: &'static str,
    /// Its colours.
    pub look: Look,
    /// The triangles.
    pub surface: Surface,
    /// For each vertex four joints, and their weights of sum 255.
    pub follows: Vec<([u8; 4], [u8; 4])>,
}

/// The colours of a material.
pub struct Look {
    /// Linear base colour, times that of the texture.
    pub factor: [f64; 3],
    /// The texture, a PNG file.
    pub image: Vec<u8>,
}

/// The bytes of the file.
pub fn write(parts: &[Part], joints: Vec<Joint>, clips: Vec<Clip>) -> Vec<u8> {
    let mut b = BinaryChunk::default();
    let mut nodes: Vec<Value> =
        parts.iter().enumerate().map(|(k, p)| json!({"mesh": k, "name": p.name, "skin": 0})).collect();
    let meshes: Vec<Value> = parts.iter().enumerate().map(|(k, part)| mesh(&mut b, k, part)).collect();
    let mut roots: Vec<usize> = (0..=parts.len()).collect();
    let first = nodes.len();
    roots[first] = first;
    let skin = Skin { joints, indices: vec![], weights: vec![], clips };
    let skeleton = add_skeleton(&mut b, &mut nodes, &skin);
    let animations: Vec<Value> = skin.clips.iter().map(|clip| animation(&mut b, clip, first)).collect();
    let images: Vec<Value> = parts
        .iter()
        .map(|p| json!({"bufferView": b.view(&p.look.image, None), "mimeType": "image/png", "name": p.material}))
        .collect();
    let texture = |k| json!({"sampler": 0, "source": k});
    let doc = json!({
        "animations": animations,
        "asset": {
            "copyright": "CC0-1.0, gimage project",
            "extras": {"license": "CC0-1.0"},
            "generator": "gimage make-assets",
            "version": "2.0",
        },
        "images": images,
        "materials": parts.iter().enumerate().map(|(k, p)| material(k, p)).collect::<Vec<_>>(),
        "meshes": meshes,
        "nodes": nodes,
        // Pixels stay sharp, and repeat.
        "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
        "scene": 0,
        "scenes": [{"name": "figure", "nodes": roots}],
        "skins": [skeleton],
        "textures": (0..parts.len()).map(texture).collect::<Vec<_>>(),
    });
    b.file(doc).expect("a figure is far below 4 GiB")
}

fn mesh(b: &mut BinaryChunk, material: usize, part: &Part) -> Value {
    let s = &part.surface;
    let (joints, weights): (Vec<[u8; 4]>, Vec<[u8; 4]>) = part.follows.iter().copied().unzip();
    let mut bytes = |list: &[[u8; 4]], more: Value| {
        b.push(list.as_flattened(), Some(Target::Vertices), list.len(), "VEC4", Component::U8, more)
    };
    let (joints, weights) = (bytes(&joints, json!({})), bytes(&weights, json!({"normalized": true})));
    let attributes = json!({
        "JOINTS_0": joints,
        "NORMAL": b.floats(&s.normals, json!({})),
        "POSITION": b.floats(&s.positions, bounds(&s.positions)),
        "TEXCOORD_0": b.floats(&s.uvs, json!({})),
        "WEIGHTS_0": weights,
    });
    let list: Vec<u8> = s.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
    let indices = b.push(&list, Some(Target::Indices), s.indices.len(), "SCALAR", Component::U16, json!({}));
    json!({
        "name": part.name,
        "primitives": [{"attributes": attributes, "indices": indices, "material": material, "mode": 4}],
    })
}

fn material(texture: usize, part: &Part) -> Value {
    let [r, g, b] = part.look.factor;
    json!({
        "doubleSided": part.material != "skin",
        "name": part.material,
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0],
            "baseColorTexture": {"index": texture},
            "metallicFactor": 0.0,
            "roughnessFactor": 0.9,
        },
    })
}
