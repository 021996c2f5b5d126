//! Writes one mesh, with its node tree and perhaps a skin, as a GLB file of plain core glTF 2.0.

use gimage::export::glb::{BinaryChunk, Component, Target, bounds};
use serde_json::{Value, json};

use crate::surface::Surface;

/// One joint of a skeleton.
pub struct Joint {
    /// The joint's name.
    pub name: &'static str,
    /// The joint above it, as an index before its own.
    pub parent: Option<usize>,
    /// Where the joint is in the rest pose.
    pub at: [f32; 3],
}

/// Skeleton and weights.
pub struct Skin {
    /// Joints, parents first.
    pub joints: Vec<Joint>,
    /// Four joints for each vertex.
    pub indices: Vec<[u8; 4]>,
    /// Their weights, of sum one.
    pub weights: Vec<[f32; 4]>,
    /// Animations of the joints.
    pub clips: Vec<Clip>,
}

/// An animation.
pub struct Clip {
    /// Its name.
    pub name: &'static str,
    /// The tracks of its joints.
    pub tracks: Vec<Track>,
}

/// Key frames of one property of a joint.
pub struct Track {
    /// Index of the joint.
    pub joint: usize,
    /// `translation`, `rotation` or `scale`.
    pub path: &'static str,
    /// The way from key to key.
    pub between: Between,
    /// Seconds.
    pub times: Vec<f32>,
    /// Three or four numbers per key, three times as many for a spline.
    pub values: Vec<f32>,
}

/// Interpolations of glTF.
#[derive(Clone, Copy)]
pub enum Between {
    /// `STEP`
    Step,
    /// `LINEAR`
    Linear,
    /// `CUBICSPLINE`
    Cubic,
}

/// Contents of the file besides the triangles.
pub struct Scene<'a> {
    /// The name of mesh and node.
    pub name: &'a str,
    /// The material's name and its linear base colour.
    pub material: (&'a str, [f64; 3]),
    /// Whether indices take two bytes, or four.
    pub short_indices: bool,
    /// Placement of a node above the mesh node: its name, rotation quaternion, scale.
    pub parent: Option<(&'a str, [f64; 4], f64)>,
    /// The custom attribute `_PIN`.
    pub pin: Option<Vec<f32>>,
    /// `COLOR_0`, as normalised bytes.
    pub colours: Option<Vec<[u8; 4]>>,
    /// The skin.
    pub skin: Option<Skin>,
}

/// The bytes of the file.
pub fn write(s: &Surface, scene: &Scene) -> Vec<u8> {
    let mut b = BinaryChunk::default();
    let vertices = Some(Target::Vertices);
    let mut attributes = json!({
        "NORMAL": b.floats(&s.normals, json!({})),
        "POSITION": b.floats(&s.positions, bounds(&s.positions)),
        "TEXCOORD_0": b.floats(&s.uvs, json!({})),
    });
    if let Some(pin) = &scene.pin {
        let pin: Vec<[f32; 1]> = pin.iter().map(|&p| [p]).collect();
        attributes["_PIN"] = json!(b.floats(&pin, json!({})));
    }
    if let Some(c) = &scene.colours {
        let bytes = c.as_flattened();
        attributes["COLOR_0"] =
            json!(b.push(bytes, vertices, c.len(), "VEC4", Component::U8, json!({"normalized": true})));
    }
    let mut nodes = vec![json!({"mesh": 0, "name": scene.name})];
    let mut roots = vec![0];
    let (mut skins, mut animations) = (Vec::new(), Vec::new());
    if let Some(skin) = &scene.skin {
        let bytes = skin.indices.as_flattened();
        attributes["JOINTS_0"] = json!(b.push(bytes, vertices, skin.indices.len(), "VEC4", Component::U8, json!({})));
        attributes["WEIGHTS_0"] = json!(b.floats(&skin.weights, json!({})));
        nodes[0]["skin"] = json!(0);
        let first = nodes.len();
        roots.push(first);
        skins.push(add_skeleton(&mut b, &mut nodes, skin));
        animations.extend(skin.clips.iter().map(|clip| animation(&mut b, clip, first)));
    }
    if let Some((name, rotation, scale)) = scene.parent {
        roots = vec![nodes.len()];
        nodes.push(json!({"children": [0], "name": name, "rotation": rotation, "scale": [scale, scale, scale]}));
    }
    let (bytes, kind): (Vec<u8>, Component) = if scene.short_indices {
        (s.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(), Component::U16)
    } else {
        (s.indices.iter().flat_map(|i| i.to_le_bytes()).collect(), Component::U32)
    };
    let indices = b.push(&bytes, Some(Target::Indices), s.indices.len(), "SCALAR", kind, json!({}));
    let (material, [red, green, blue]) = scene.material;
    let mut doc = json!({
        "asset": {
            "copyright": "CC0-1.0, gimage project",
            "extras": {"license": "CC0-1.0", "metresPerUv": s.metres_per_uv},
            "generator": "gimage make-assets",
            "version": "2.0",
        },
        "materials": [{
            "doubleSided": true,
            "name": material,
            "pbrMetallicRoughness": {"baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9},
        }],
        "meshes": [{
            "name": scene.name,
            "primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}],
        }],
        "nodes": nodes,
        "scene": 0,
        "scenes": [{"name": scene.name, "nodes": roots}],
    });
    if !skins.is_empty() {
        doc["skins"] = json!(skins);
    }
    if !animations.is_empty() {
        doc["animations"] = json!(animations);
    }
    b.file(doc).expect("a garment is far below 4 GiB")
}

/// Adds the joints as nodes and gives the skin. Joints only translate, so that the rest pose is the bind pose.
pub(crate) fn add_skeleton(b: &mut BinaryChunk, nodes: &mut Vec<Value>, skin: &Skin) -> Value {
    let first = nodes.len();
    let mut inverse = Vec::new();
    for (i, j) in skin.joints.iter().enumerate() {
        let above = j.parent.map_or([0.0; 3], |p| skin.joints[p].at);
        let step: [f32; 3] = [0, 1, 2].map(|k| j.at[k] - above[k]);
        let children: Vec<usize> =
            (0..skin.joints.len()).filter(|&c| skin.joints[c].parent == Some(i)).map(|c| c + first).collect();
        let mut node = json!({"name": j.name, "translation": step});
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        nodes.push(node);
        let mut m = [0.0f32; 16];
        [0, 5, 10, 15].iter().for_each(|&k| m[k] = 1.0);
        (0..3).for_each(|k| m[12 + k] = -j.at[k]);
        inverse.extend(m.iter().flat_map(|f| f.to_le_bytes()));
    }
    let joints: Vec<usize> = (first..first + skin.joints.len()).collect();
    let matrices = b.push(&inverse, None, joints.len(), "MAT4", Component::F32, json!({}));
    json!({"inverseBindMatrices": matrices, "joints": joints, "name": "skeleton", "skeleton": first})
}

/// An animation of joints that are nodes from `first` on.
pub(crate) fn animation(b: &mut BinaryChunk, clip: &Clip, first: usize) -> Value {
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for (n, track) in clip.tracks.iter().enumerate() {
        let bytes = |list: &[f32]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let (kind, width) = if track.path == "rotation" { ("VEC4", 4) } else { ("VEC3", 3) };
        let ends = json!({"max": [track.times.last()], "min": [track.times.first()]});
        let input = b.push(&bytes(&track.times), None, track.times.len(), "SCALAR", Component::F32, ends);
        let count = track.values.len() / width;
        let output = b.push(&bytes(&track.values), None, count, kind, Component::F32, json!({}));
        let between = match track.between {
            Between::Step => "STEP",
            Between::Linear => "LINEAR",
            Between::Cubic => "CUBICSPLINE",
        };
        samplers.push(json!({"input": input, "output": output, "interpolation": between}));
        channels.push(json!({"sampler": n, "target": {"node": first + track.joint, "path": track.path}}));
    }
    json!({"channels": channels, "name": clip.name, "samplers": samplers})
}
