//! The writer of GLB files: the binary chunk with its views and accessors, and the container.

use serde_json::{Map, Value, json};

use super::packed::{EXTENSION, Packed};
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
    /// Bytes before `bytes`, taken by [`BinaryChunk::drain`]; a multiple of 4.
    drained: usize,
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    is_packed: bool,
    /// Bytes of the buffer that readers make of compressed views.
    unpacked: usize,
}

impl BinaryChunk {
    /// A chunk whose views are compressed with `EXT_meshopt_compression`, which a reader has to know. Vectors of floats are rounded by at most 2^-17
    /// of their largest component, and the corners of triangles may be turned; all else is exact.
    pub fn packed() -> Self {
        BinaryChunk { is_packed: true, ..BinaryChunk::default() }
    }

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
        let view = match self.pack(data, target, kind, component) {
            Some(packed) => self.packed_view(packed, target),
            None => self.view(data, target),
        };
        let accessor = json!({"bufferView": view, "componentType": component as u32, "count": count, "type": kind});
        self.accessor(accessor, more)
    }

    /// An array, compressed exactly; `None` where it is not compressed.
    fn pack(&self, data: &[u8], target: Option<Target>, kind: &str, component: Component) -> Option<Packed> {
        let words = || data.chunks_exact(4).map(|b| b.first_chunk().map_or(0, |b| u32::from_le_bytes(*b)));
        let packed = match (self.is_packed, component, target) {
            (true, Component::U32, Some(Target::Indices)) => Packed::triangles(&words().collect::<Vec<_>>(), 4)?,
            (true, Component::F32, _) => {
                let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|name| *name == kind)? + 1;
                Packed::elements(data, 4 * width)?
            }
            _ => return None,
        };
        (packed.bytes.len() < data.len()).then_some(packed)
    }

    /// Appends a compressed view, and returns it.
    fn packed_view(&mut self, packed: Packed, target: Option<Target>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.unpacked = self.unpacked.next_multiple_of(4);
        let mut view = json!({
            "buffer": 1,
            "byteLength": packed.length(),
            "byteOffset": self.unpacked,
            "extensions": packed.extension(self.drained + self.bytes.len()),
        });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.unpacked += packed.length();
        self.bytes.extend_from_slice(&packed.bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends vectors, rounded if the chunk is compressed; returns the view, and the bounds of what a reader gets.
    fn vectors<const N: usize>(&mut self, data: &[[f32; N]], target: Option<Target>) -> (usize, Option<Value>) {
        let packed = if self.is_packed { Packed::floats(data) } else { None };
        match packed.filter(|(packed, _)| packed.bytes.len() < packed.length()) {
            Some((packed, rounded)) => {
                let limit = |f: fn(f32, f32) -> f32, from: f32| {
                    let sides = (0..N).map(|k| rounded.iter().map(|v| v[k]).fold(from, f));
                    sides.collect::<Vec<f32>>()
                };
                let bounds = json!({"max": limit(f32::max, f32::NEG_INFINITY), "min": limit(f32::min, f32::INFINITY)});
                (self.packed_view(packed, target), Some(bounds))
            }
            None => (self.view(&little_endian(data), target), None),
        }
    }

    /// Appends an array of 32-bit floats in threes of which few are not 0: `values` at ascending `indices` of `count` elements. Returns its
    /// accessor, which has at least one entry.
    pub fn sparse(&mut self, (indices, values): (&[u32], &[[f32; 3]]), count: usize, more: Value) -> usize {
        let (indices, values) = if indices.is_empty() { (&[0][..], &[[0.0; 3]][..]) } else { (indices, values) };
        // The widths of indices that glTF has.
        let largest = indices.last().copied().unwrap_or(0);
        let (bytes, component) = match largest {
            0..=0xff => (indices.iter().map(|k| *k as u8).collect(), Component::U8),
            0x100..=0xffff => (indices.iter().flat_map(|k| (*k as u16).to_le_bytes()).collect(), Component::U16),
            _ => (indices.iter().flat_map(|k| k.to_le_bytes()).collect::<Vec<u8>>(), Component::U32),
        };
        let width = bytes.len() / indices.len();
        let packed = if self.is_packed && width > 1 { Packed::sequence(indices, width) } else { None };
        let at = match packed.filter(|packed| packed.bytes.len() < bytes.len()) {
            Some(packed) => self.packed_view(packed, None),
            None => self.view(&bytes, None),
        };
        let (of, bounds) = self.vectors(values, None);
        let sparse = json!({
            "count": values.len(),
            "indices": {"bufferView": at, "componentType": component as u32},
            "values": {"bufferView": of},
        });
        let kind = Component::F32 as u32;
        // All other elements are 0.
        let widened = bounds.filter(|_| more["max"].is_array()).map(|bounds| {
            let side = |key: &str, f: fn(f64, f64) -> f64| {
                let from = |k: usize| bounds[key][k].as_f64().unwrap_or(0.0);
                (0..3).map(|k| if values.len() < count { f(from(k), 0.0) } else { from(k) }).collect::<Vec<f64>>()
            };
            json!({"max": side("max", f64::max), "min": side("min", f64::min)})
        });
        let accessor = json!({"componentType": kind, "count": count, "sparse": sparse, "type": "VEC3"});
        self.accessor(accessor, widened.unwrap_or(more))
    }

    /// Appends an array as a view, and returns it.
    pub fn view(&mut self, data: &[u8], target: Option<Target>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteLength": data.len(), "byteOffset": self.drained + self.bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.bytes.extend_from_slice(data);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends an accessor without data of its own, and returns it.
    pub(super) fn bare(&mut self, accessor: Value) -> usize {
        self.accessor(accessor, Value::Null)
    }

    fn accessor(&mut self, mut accessor: Value, more: Value) -> usize {
        for (name, value) in more.as_object().into_iter().flatten() {
            accessor[name] = value.clone();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends an attribute of 1 to 4 floats per vertex, and returns its accessor.
    pub fn floats<const N: usize>(&mut self, data: &[[f32; N]], more: Value) -> usize {
        const { assert!(N >= 1 && N <= 4) };
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let (view, bounds) = self.vectors(data, Some(Target::Vertices));
        let bounds = bounds.filter(|_| more["max"].is_array());
        let kind =
            json!({"bufferView": view, "componentType": Component::F32 as u32, "count": data.len(), "type": kind});
        self.accessor(kind, bounds.unwrap_or(more))
    }

    /// Takes the bytes so far, for a caller that writes them elsewhere: they are those of the chunk after all bytes taken before.
    pub fn drain(&mut self) -> Vec<u8> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.drained += self.bytes.len();
        std::mem::take(&mut self.bytes)
    }

    /// The file: `root` with the buffer, its views and accessors, keys in order. Errors where it is too large for GLB, and where bytes
    /// were taken by [`BinaryChunk::drain`].
    pub fn file(self, root: Value) -> Result<Vec<u8>> {
        if self.drained > 0 {
            return Err(Error::Internal("bytes of a GLB file that lie elsewhere".into()));
        }
        let (mut file, rest) = self.ends(root)?;
        file.extend_from_slice(&rest);
        Ok(file)
    }

    /// The bytes before and after those that [`BinaryChunk::drain`] has given. Errors as [`BinaryChunk::file`].
    pub fn ends(mut self, mut root: Value) -> Result<(Vec<u8>, Vec<u8>)> {
        let rest = self.drain();
        // glTF has no empty arrays.
        if self.drained > 0 {
            root["buffers"] = json!([{"byteLength": self.drained}]);
            if self.unpacked > 0 {
                push(&mut root["buffers"], fallback(self.unpacked));
                for key in ["extensionsUsed", "extensionsRequired"] {
                    push(&mut root[key], EXTENSION.into());
                }
            }
            root["bufferViews"] = self.views.into();
            root["accessors"] = self.accessors.into();
        }
        Ok((head(sorted(root).to_string().into_bytes(), self.drained)?, rest))
    }
}

/// Appends to a list, which is made if there is none.
pub(super) fn push(list: &mut Value, item: Value) {
    match list.as_array_mut() {
        Some(items) => items.push(item),
        None => *list = json!([item]),
    }
}

/// The buffer without data that readers unpack compressed views to.
fn fallback(bytes: usize) -> Value {
    json!({"byteLength": bytes, "extensions": {EXTENSION: {"fallback": true}}})
}

fn little_endian<const N: usize>(data: &[[f32; N]]) -> Vec<u8> {
    data.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
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

/// The GLB header and its chunks; an empty binary chunk is left out. Errors if the file is too large for GLB.
pub(crate) fn container(text: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>> {
    let mut out = head(text, binary.len())?;
    out.extend_from_slice(binary);
    Ok(out)
}

/// The GLB header, the chunk of JSON, and the header of a binary chunk of `binary` bytes; an empty one is left out.
fn head(mut text: Vec<u8>, binary: usize) -> Result<Vec<u8>> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 20 + text.len() + if binary > 0 { 8 + binary } else { 0 };
    let length = u32::try_from(total).map_err(|_| too_large(total as u64))?;
    let mut out = Vec::with_capacity(28 + text.len());
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length.to_le_bytes());
    out.extend_from_slice(&(text.len() as u32).to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    if binary > 0 {
        out.extend_from_slice(&(binary as u32).to_le_bytes());
        out.extend_from_slice(b"BIN\0");
    }
    Ok(out)
}

/// The error of a file of `bytes`, which GLB has no room for.
pub(super) fn too_large(bytes: u64) -> Error {
    Error::TooLarge {
        what: "the GLB file".into(),
        need: format!("{bytes} bytes"),
        limit: format!("{} bytes", u32::MAX),
        hint: "write another kind of file, or less".into(),
    }
}
