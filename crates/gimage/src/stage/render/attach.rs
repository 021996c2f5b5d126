//! Writes bindings into a glTF document: two attributes for each primitive that has a bound vertex.

use std::collections::BTreeMap;

use gimage_bundle::{BLEND, COORD, JOINTS, OFFSET, WEIGHTS, is_binding, numbered};
use serde_json::{Value, json};

use super::bind::{Binding, UNBOUND};
use super::trace::{Influence, Trace};
use crate::base::mesh::NONE;
use crate::error::Result;
use crate::stage::export::glb::container;

/// A primitive as a node places it, with the binding of each of its vertices that has one.
pub(super) struct Bound {
    pub node: Option<usize>,
    pub mesh: usize,
    pub primitive: usize,
    /// The transform of the instance, if the node lists instances.
    pub instance: Option<[f64; 16]>,
    /// Vertices, ascending, with their bindings.
    pub vertices: Vec<(u32, Binding)>,
    /// The vertex of the imported mesh that each of them became.
    pub imported: Vec<u32>,
}

/// Where vertices have the joints of the skeleton as well, for the blend from the skin to the cloth.
pub(super) struct Skin<'a> {
    pub trace: &'a Trace,
    /// The pieces that blend.
    pub blending: &'a [usize],
}

/// The vertices of an accessor of positions: their bindings, and the vertices of the imported mesh.
type Shared = Vec<(Binding, u32)>;

/// The counts of an attached document.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Vertices of primitives with the attributes.
    pub vertices: u64,
    /// Those of them that are bound.
    pub bound: u64,
}

/// A document under way.
pub(super) struct Attached {
    json: Value,
    bin: Vec<u8>,
    pub counts: Counts,
}

impl Attached {
    /// Adds the attributes. Primitives of one node stand next to each other in `bound`; those of one instance do too.
    pub fn new(json: Value, bin: Vec<u8>, bound: &[Bound], skin: &Skin) -> Self {
        let mut out = Attached { json, bin, counts: Counts::default() };
        out.drop_bindings();
        for group in bound.chunk_by(|a, b| (a.node, a.mesh, a.instance) == (b.node, b.mesh, b.instance)) {
            if group.iter().any(|b| is_bound(&b.vertices)) {
                let mesh = out.own_mesh(&group[0]);
                out.attach(mesh, group, skin);
            }
        }
        out.drop_instancing();
        out
    }

    /// Removes the bindings of a file that was the render mesh of another bundle.
    fn drop_bindings(&mut self) {
        let meshes = self.json.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten();
        let primitives = meshes.filter_map(|m| m.get_mut("primitives")?.as_array_mut()).flatten();
        for attributes in primitives.filter_map(|p| p.get_mut("attributes")?.as_object_mut()) {
            attributes.retain(|name, _| !is_binding(name));
        }
    }

    /// The mesh that a node, or an instance of it, has for itself: bindings of two nodes differ.
    fn own_mesh(&mut self, of: &Bound) -> usize {
        let Some(node) = of.node else { return of.mesh };
        let users = self.json["nodes"].as_array().into_iter().flatten();
        let is_shared = users.filter(|n| n["mesh"].as_u64() == Some(of.mesh as u64)).count() > 1;
        if !is_shared && of.instance.is_none() {
            return of.mesh;
        }
        let copy = self.json["meshes"][of.mesh].clone();
        let mesh = push(&mut self.json, "meshes", copy);
        match of.instance {
            None => self.json["nodes"][node]["mesh"] = json!(mesh),
            Some(matrix) => {
                // Each instance becomes a child; the node itself places nothing from now on.
                let mut child = json!({"mesh": mesh});
                if matrix != IDENTITY {
                    child["matrix"] = json!(matrix);
                }
                if let Some(name) = self.json["nodes"][node].get("name") {
                    child["name"] = name.clone();
                }
                let child = push(&mut self.json, "nodes", child);
                let node = &mut self.json["nodes"][node];
                push(node, "children", json!(child));
                remove(node, "mesh");
                if let Some(extensions) = node.get_mut("extensions") {
                    remove(extensions, INSTANCING);
                    if extensions.as_object().is_some_and(|e| e.is_empty()) {
                        remove(node, "extensions");
                    }
                }
            }
        }
        mesh
    }

    fn attach(&mut self, mesh: usize, group: &[Bound], skin: &Skin) {
        // Primitives that share their positions share their bindings.
        let mut shared: BTreeMap<u64, Shared> = BTreeMap::new();
        let position = |json: &Value, b: &Bound| {
            json["meshes"][mesh]["primitives"][b.primitive]["attributes"]["POSITION"].as_u64().unwrap_or(u64::MAX)
        };
        for b in group.iter().filter(|b| is_bound(&b.vertices)) {
            let accessor = position(&self.json, b);
            let count = self.json["accessors"][accessor as usize]["count"].as_u64().unwrap_or(0) as usize;
            let list = shared.entry(accessor).or_insert_with(|| vec![(UNBOUND, NONE); count]);
            for (&(v, binding), &imported) in b.vertices.iter().zip(&b.imported) {
                if let Some(slot) = list.get_mut(v as usize).filter(|_| binding != UNBOUND) {
                    *slot = (binding, imported);
                }
            }
        }
        let mut written: BTreeMap<u64, Vec<(String, usize)>> = BTreeMap::new();
        for (&accessor, list) in &shared {
            let coord = self.accessor(list.iter().map(|(b, _)| b.coord));
            let offset = self.accessor(list.iter().map(|(b, _)| b.offset));
            let mut names = vec![(COORD.into(), coord), (OFFSET.into(), offset)];
            names.extend(self.joints(list, skin));
            if list.iter().any(|(b, _)| b.blend < 1.0) {
                names.push((BLEND.into(), self.accessor(list.iter().map(|(b, _)| [b.blend]))));
            }
            written.insert(accessor, names);
        }
        for b in group.iter().filter(|b| is_bound(&b.vertices)) {
            let accessor = position(&self.json, b);
            let attributes = &mut self.json["meshes"][mesh]["primitives"][b.primitive]["attributes"];
            for (name, values) in &written[&accessor] {
                attributes[name] = json!(values);
            }
            self.counts.vertices += shared[&accessor].len() as u64;
            self.counts.bound += shared[&accessor].iter().filter(|(b, _)| b.coord[0] >= 0.0).count() as u64;
        }
    }

    /// The joints of vertices and their weights, if any of them is on a piece that blends and has joints.
    fn joints(&mut self, list: &Shared, skin: &Skin) -> Vec<(String, usize)> {
        let blends = |b: &Binding| b.blend < 1.0 || skin.blending.iter().any(|piece| b.coord[0] == *piece as f32);
        if !list.iter().any(|(b, v)| blends(b) && skin.trace.joints(*v).is_some()) {
            return Vec::new();
        }
        let nothing: Vec<Influence> =
            (0..skin.trace.sets).map(|n| ([0.0; 4], [if n == 0 { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0])).collect();
        let of = |n: usize| {
            let nothing = &nothing;
            list.iter().map(move |(_, v)| skin.trace.joints(*v).unwrap_or(nothing)[n])
        };
        let mut names = Vec::new();
        for n in 0..skin.trace.sets {
            names.push((numbered(JOINTS, n), self.accessor(of(n).map(|(joints, _)| joints))));
            names.push((numbered(WEIGHTS, n), self.accessor(of(n).map(|(_, weights)| weights))));
        }
        names
    }

    /// Appends vectors with an accessor of their own.
    fn accessor<const N: usize>(&mut self, values: impl Iterator<Item = [f32; N]>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let start = self.bin.len();
        self.bin.extend(values.flatten().flat_map(f32::to_le_bytes));
        let length = self.bin.len() - start;
        let view = json!({"buffer": 0, "byteLength": length, "byteOffset": start, "target": 34962});
        let view = push(&mut self.json, "bufferViews", view);
        let accessor = json!({"bufferView": view, "componentType": 5126, "count": length / (4 * N), "type": if N == 1 { "SCALAR".into() } else { format!("VEC{N}") }});
        push(&mut self.json, "accessors", accessor)
    }

    /// Removes the declaration of an extension that no node has any more.
    fn drop_instancing(&mut self) {
        let mut nodes = self.json["nodes"].as_array().into_iter().flatten();
        if nodes.any(|n| n["extensions"].get(INSTANCING).is_some()) {
            return;
        }
        for key in ["extensionsUsed", "extensionsRequired"] {
            let Some(list) = self.json.get_mut(key).and_then(Value::as_array_mut) else { continue };
            list.retain(|name| name != INSTANCING);
            if list.is_empty() {
                remove(&mut self.json, key);
            }
        }
    }

    /// The bytes of the GLB file. Errors if it is larger than the container allows.
    pub fn into_bytes(mut self) -> Result<Vec<u8>> {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        container(self.json.to_string().into_bytes(), &self.bin)
    }
}

const INSTANCING: &str = "EXT_mesh_gpu_instancing";
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn is_bound(vertices: &[(u32, Binding)]) -> bool {
    vertices.iter().any(|v| v.1 != UNBOUND)
}

/// Appends to a list, which is made if there is none; returns the index.
pub(super) fn push(json: &mut Value, list: &str, item: Value) -> usize {
    if let Some(items) = json.get_mut(list).and_then(Value::as_array_mut) {
        items.push(item);
        return items.len() - 1;
    }
    json[list] = json!([item]);
    0
}

fn remove(json: &mut Value, key: &str) {
    json.as_object_mut().and_then(|o| o.remove(key));
}
