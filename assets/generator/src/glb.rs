//! Writes one mesh, with its node tree and perhaps a skin, as a GLB file of plain core glTF 2.0.

use serde_json::{Map, Value, json};

use crate::surface::Surface;

const FLOAT: u32 = 5126;
const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;

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
}

/// What goes into the file besides the triangles.
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

#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an accessor with a view of its own; `extra` joins its fields.
    fn push(&mut self, data: &[u8], target: Option<u32>, count: usize, kind: (&str, u32), extra: Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteLength": data.len(), "byteOffset": self.bytes.len()});
        if let Some(t) = target {
            view["target"] = json!(t);
        }
        self.bytes.extend(data);
        self.views.push(view);
        let mut accessor =
            json!({"bufferView": self.views.len() - 1, "componentType": kind.1, "count": count, "type": kind.0});
        for (k, v) in extra.as_object().into_iter().flatten() {
            accessor[k] = v.clone();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, data: &[[f32; N]], extra: Value) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        let bytes: Vec<u8> = data.iter().flatten().flat_map(|f| f.to_le_bytes()).collect();
        self.push(&bytes, Some(34962), data.len(), (kind, FLOAT), extra)
    }
}

/// The bytes of the file.
pub fn write(s: &Surface, scene: &Scene) -> Vec<u8> {
    let mut b = Buffer::default();
    let bound = |f: fn(f32, f32) -> f32, from: f32| [0, 1, 2].map(|k| s.positions.iter().map(|p| p[k]).fold(from, f));
    let bounds = json!({"max": bound(f32::max, f32::MIN), "min": bound(f32::min, f32::MAX)});
    let mut attributes = json!({
        "NORMAL": b.floats(&s.normals, json!({})),
        "POSITION": b.floats(&s.positions, bounds),
        "TEXCOORD_0": b.floats(&s.uvs, json!({})),
    });
    if let Some(pin) = &scene.pin {
        let pin: Vec<[f32; 1]> = pin.iter().map(|&p| [p]).collect();
        attributes["_PIN"] = json!(b.floats(&pin, json!({})));
    }
    if let Some(c) = &scene.colours {
        let bytes = c.as_flattened();
        attributes["COLOR_0"] = json!(b.push(bytes, Some(34962), c.len(), ("VEC4", U8), json!({"normalized": true})));
    }
    let mut nodes = vec![json!({"mesh": 0, "name": scene.name})];
    let mut roots = vec![0];
    let mut skins = Vec::new();
    if let Some(skin) = &scene.skin {
        let bytes = skin.indices.as_flattened();
        attributes["JOINTS_0"] = json!(b.push(bytes, Some(34962), skin.indices.len(), ("VEC4", U8), json!({})));
        attributes["WEIGHTS_0"] = json!(b.floats(&skin.weights, json!({})));
        nodes[0]["skin"] = json!(0);
        roots.push(nodes.len());
        skins.push(add_skeleton(&mut b, &mut nodes, skin));
    }
    if let Some((name, rotation, scale)) = scene.parent {
        roots = vec![nodes.len()];
        nodes.push(json!({"children": [0], "name": name, "rotation": rotation, "scale": [scale, scale, scale]}));
    }
    let (bytes, kind): (Vec<u8>, u32) = if scene.short_indices {
        (s.indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(), U16)
    } else {
        (s.indices.iter().flat_map(|i| i.to_le_bytes()).collect(), U32)
    };
    let indices = b.push(&bytes, Some(34963), s.indices.len(), ("SCALAR", kind), json!({}));
    b.bytes.resize(b.bytes.len().next_multiple_of(4), 0);
    let (material, [red, green, blue]) = scene.material;
    let mut doc = json!({
        "accessors": b.accessors,
        "asset": {
            "copyright": "CC0-1.0, gimage project",
            "extras": {"license": "CC0-1.0", "metresPerUv": s.metres_per_uv},
            "generator": "gimage make-assets",
            "version": "2.0",
        },
        "bufferViews": b.views,
        "buffers": [{"byteLength": b.bytes.len()}],
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
    container(&sorted(doc).to_string(), &b.bytes)
}

/// Adds the joints as nodes and gives the skin. Joints only translate, so that the rest pose is the bind pose.
fn add_skeleton(b: &mut Buffer, nodes: &mut Vec<Value>, skin: &Skin) -> Value {
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
    let matrices = b.push(&inverse, None, joints.len(), ("MAT4", FLOAT), json!({}));
    json!({"inverseBindMatrices": matrices, "joints": joints, "name": "skeleton", "skeleton": first})
}

/// The same value with keys in order, whichever map type serde_json was built with.
fn sorted(v: Value) -> Value {
    match v {
        Value::Object(map) => {
            let mut pairs: Vec<(String, Value)> = map.into_iter().map(|(k, v)| (k, sorted(v))).collect();
            pairs.sort_by(|a, b| a.0.cmp(&b.0));
            Value::Object(Map::from_iter(pairs))
        }
        Value::Array(list) => Value::Array(list.into_iter().map(sorted).collect()),
        other => other,
    }
}

fn container(text: &str, bytes: &[u8]) -> Vec<u8> {
    let mut text = text.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = Vec::new();
    for word in [0x4654_6C67, 2, (12 + 8 + text.len() + 8 + bytes.len()) as u32, text.len() as u32, 0x4E4F_534A] {
        out.extend(word.to_le_bytes());
    }
    out.extend(&text);
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(0x004E_4942u32.to_le_bytes());
    out.extend(bytes);
    out
}
