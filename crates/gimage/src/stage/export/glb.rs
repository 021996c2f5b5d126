//! The writer of GLB files: the binary chunk with its views and accessors, and the container.

use serde_json::{Map, Value, json};

use crate::error::{Error, Result};

/// Types of the components of an accessor, by glTF's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Component {
    /// One byte, 0 to 255.
    U8 = 5121,
    /// Two bytes, 0 to 65,535.
    U16 = 5123,
    /// Four bytes, a whole number.
    U32 = 5125,
    /// Four bytes, a 32-bit float.
    F32 = 5126,
}

/// The kind of data in a buffer view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Target {
    /// Attributes of vertices.
    Vertices = 34962,
    /// Indices of vertices.
    Indices = 34963,
}

/// The binary chunk of a GLB file, and the views and accessors that point into it.
///
/// ```
/// use gimage::export::glb::{BinaryChunk, Component, Target};
/// use serde_json::json;
///
/// let mut chunk = BinaryChunk::default();
/// let bounds = json!({"min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]});
/// let position = chunk.floats(&[[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], bounds);
/// let indices = chunk.push(&[0, 1, 2], Some(Target::Indices), 3, "SCALAR", Component::U8, json!({}));
/// let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
/// let file = chunk.file(json!({"asset": {"version": "2.0"}, "meshes": [{"primitives": [primitive]}]}))?;
/// assert_eq!(&file[..4], b"glTF");
/// # Ok::<(), gimage::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct BinaryChunk {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl BinaryChunk {
    /// Appends an array with a view of its own, and returns its accessor. `kind` is glTF's name of an element (`"VEC3"`), of
    /// which there are `count`; the fields of `more` go into the accessor.
    pub fn push(
        &mut self,
        data: &[u8],
        target: Option<Target>,
        count: usize,
        kind: &str,
        component: Component,
        more: Value,
    ) -> usize {
        let view = self.view(data);
        if let Some(target) = target {
            self.views[view]["target"] = json!(target as u32);
        }
        let mut accessor = json!({"bufferView": view, "componentType": component as u32, "count": count, "type": kind});
        for (name, value) in more.as_object().into_iter().flatten() {
            accessor[name] = value.clone();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends bytes with a view of their own and no accessor, such as an image, and returns the view.
    pub fn view(&mut self, data: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteLength": data.len(), "byteOffset": self.bytes.len()}));
        self.bytes.extend_from_slice(data);
        self.views.len() - 1
    }

    /// Appends an attribute of 1 to 4 floats per vertex, and returns its accessor.
    pub fn floats<const N: usize>(&mut self, data: &[[f32; N]], more: Value) -> usize {
        const { assert!(N >= 1 && N <= 4) };
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let bytes: Vec<u8> = data.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.push(&bytes, Some(Target::Vertices), data.len(), kind, Component::F32, more)
    }

    /// The file: `root` with the buffer, its views and accessors, keys in order. Errors where it is too large for GLB.
    pub fn file(mut self, mut root: Value) -> Result<Vec<u8>> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        // glTF has no empty arrays.
        if !self.bytes.is_empty() {
            root["buffers"] = json!([{"byteLength": self.bytes.len()}]);
            root["bufferViews"] = self.views.into();
            root["accessors"] = self.accessors.into();
        }
        container(sorted(root).to_string().into_bytes(), &self.bytes)
    }
}

/// The bounds of positions, for their accessor. Infinite without any.
pub fn bounds(positions: &[[f32; 3]]) -> Value {
    let side = |f: fn(f32, f32) -> f32, from: f32| [0, 1, 2].map(|k| positions.iter().map(|p| p[k]).fold(from, f));
    json!({"max": side(f32::max, f32::NEG_INFINITY), "min": side(f32::min, f32::INFINITY)})
}

/// The same value with keys in order, whichever map type serde_json was built with.
fn sorted(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut pairs: Vec<(String, Value)> = map.into_iter().map(|(key, value)| (key, sorted(value))).collect();
            pairs.sort_by(|a, b| a.0.cmp(&b.0));
            Value::Object(Map::from_iter(pairs))
        }
        Value::Array(list) => Value::Array(list.into_iter().map(sorted).collect()),
        other => other,
    }
}

/// The GLB header and its chunks; an empty binary chunk is left out.
fn container(mut text: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunks: &[(&[u8], &[u8; 4])] = &[(&text, b"JSON"), (binary, b"BIN\0")];
    let chunks = &chunks[..if binary.is_empty() { 1 } else { 2 }];
    let total = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
    let length = u32::try_from(total).map_err(|_| Error::TooLarge {
        what: "the GLB file".into(),
        need: format!("{total} bytes"),
        limit: format!("{} bytes", u32::MAX),
        hint: "write an OBJ file instead".into(),
    })?;
    let mut out = Vec::with_capacity(total);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length.to_le_bytes());
    for (bytes, kind) in chunks {
        out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        out.extend_from_slice(*kind);
        out.extend_from_slice(bytes);
    }
    Ok(out)
}
