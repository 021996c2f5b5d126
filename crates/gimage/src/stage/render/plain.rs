//! A glTF document of a mesh whose file was not glTF: geometry, texture coordinates, normals and the names of materials.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::Document;
use crate::base::mesh::{Channel, Mesh, NONE, Semantic};

/// The vertices of a primitive: one per combination of position, texture coordinate and normal.
#[derive(Default)]
struct Corners {
    number: HashMap<[u32; 3], u32>,
    keys: Vec<[u32; 3]>,
    indices: Vec<u32>,
}

/// The document of an imported mesh, in its own space, a node per part.
pub(crate) fn document(mesh: &Mesh) -> Document {
    let [uv, normal] = [Semantic::TexCoord(0), Semantic::Normal].map(|s| mesh.channel(&s));
    let mut parts: Vec<Corners> = mesh.parts.iter().map(|_| Corners::default()).collect();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let Some(part) = mesh.triangle_part.get(t).and_then(|&p| parts.get_mut(p as usize)) else { continue };
        for (c, &v) in corners.iter().enumerate() {
            let value = |channel: Option<&Channel>| channel.map_or(NONE, |channel| channel.corners[3 * t + c]);
            let key = [v, value(uv), value(normal)];
            let next = part.keys.len() as u32;
            let k = *part.number.entry(key).or_insert(next);
            if k == next {
                part.keys.push(key);
            }
            part.indices.push(k);
        }
    }
    let mut out = Document {
        json: json!({"asset": {"generator": concat!("gimage ", env!("CARGO_PKG_VERSION")), "version": "2.0"}}),
        bin: Vec::new(),
        vertices: Vec::new(),
    };
    let mut materials: Vec<&str> = mesh.parts.iter().map(|p| p.material.as_str()).filter(|m| !m.is_empty()).collect();
    materials.sort_unstable();
    materials.dedup();
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for (part, corners) in mesh.parts.iter().zip(&parts).filter(|(_, c)| !c.indices.is_empty()) {
        let positions: Vec<[f32; 3]> =
            corners.keys.iter().map(|k| mesh.positions[k[0] as usize].map(|x| x as f32)).collect();
        let least = |k: usize| positions.iter().map(|p| p[k]).fold(f32::INFINITY, f32::min);
        let most = |k: usize| positions.iter().map(|p| p[k]).fold(f32::NEG_INFINITY, f32::max);
        let (lo, hi) = ([0, 1, 2].map(least), [0, 1, 2].map(most));
        let bounds = json!({"min": lo, "max": hi});
        let mut attributes = json!({});
        attributes["POSITION"] = out.push(bytes(&positions), positions.len(), ("VEC3", 5126), bounds);
        for (name, channel, k) in [("NORMAL", normal, 2), ("TEXCOORD_0", uv, 1)] {
            let Some(channel) = channel.filter(|_| corners.keys.iter().all(|key| key[k] != NONE)) else { continue };
            let value = |key: &[u32; 3]| key[k] as usize * channel.width..(key[k] as usize + 1) * channel.width;
            let values: Vec<f32> = corners.keys.iter().flat_map(|key| &channel.values[value(key)]).copied().collect();
            let kind = if k == 1 { "VEC2" } else { "VEC3" };
            attributes[name] = out.push(bytes(&[values]), corners.keys.len(), (kind, 5126), json!({}));
        }
        let order: Vec<u8> = corners.indices.iter().flat_map(|k| k.to_le_bytes()).collect();
        let indices = out.push(order, corners.indices.len(), ("SCALAR", 5125), json!({}));
        let mut primitive = json!({"attributes": attributes, "indices": indices});
        if let Ok(material) = materials.binary_search(&part.material.as_str()) {
            primitive["material"] = json!(material);
        }
        let name = [&part.mesh, &part.node].into_iter().find(|n| !n.is_empty()).map_or("mesh", |n| n);
        meshes.push(json!({"name": name, "primitives": [primitive]}));
        let node = if part.node.is_empty() { name } else { &part.node };
        nodes.push(json!({"mesh": meshes.len() - 1, "name": node}));
        out.vertices.push(corners.keys.iter().map(|key| key[0]).collect());
    }
    out.json["scene"] = json!(0);
    out.json["scenes"] = json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]);
    (out.json["meshes"], out.json["nodes"]) = (json!(meshes), json!(nodes));
    if !materials.is_empty() {
        // The other side of cloth is seen.
        let material = |name: &&str| json!({"name": name, "doubleSided": true});
        out.json["materials"] = materials.iter().map(material).collect();
    }
    out
}

fn bytes<T: AsRef<[f32]>>(values: &[T]) -> Vec<u8> {
    values.iter().flat_map(|v| v.as_ref()).flat_map(|x| x.to_le_bytes()).collect()
}

impl Document {
    /// Appends an array with a view and an accessor of its own.
    fn push(&mut self, data: Vec<u8>, count: usize, (kind, component): (&str, u32), more: Value) -> Value {
        let target = if component == 5126 { 34962 } else { 34963 };
        let view = json!({"buffer": 0, "byteLength": data.len(), "byteOffset": self.bin.len(), "target": target});
        self.bin.extend(data);
        let mut add = |list: &str, item: Value| {
            let items = self.json.get_mut(list).and_then(Value::as_array_mut);
            match items {
                Some(items) => {
                    items.push(item);
                    items.len() - 1
                }
                None => {
                    self.json[list] = json!([item]);
                    0
                }
            }
        };
        let view = add("bufferViews", view);
        let mut accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        for (name, value) in more.as_object().into_iter().flatten() {
            accessor[name] = value.clone();
        }
        json!(add("accessors", accessor))
    }
}
