//! A glTF file as one JSON text and one run of bytes: outside buffers and images come in, compressed geometry is decoded.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use serde_json::{Value, json};

use super::accessor::Accessors;
use super::buffers::Buffers;
use super::document::Document;
use super::findings::Findings;
use super::nodes::Forest;
use super::rehang::rehang;
use super::source::{self, Source};
use super::{ImportOptions, draco, glb, malformed, sniff, stand};
use crate::error::{Error, Result};

/// A file without references to others.
pub(crate) struct Embedded {
    /// The JSON of the file; its one buffer is `bin`.
    pub json: Value,
    /// The bytes of the buffer.
    pub bin: Vec<u8>,
    /// Images that could not be read, which are a white pixel now.
    pub lost_images: Vec<String>,
}

/// A PNG of one white pixel.
const WHITE: [u8; 69] = [
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0, 144, 119, 83,
    222, 0, 0, 0, 12, 73, 68, 65, 84, 120, 218, 99, 248, 255, 255, 63, 0, 5, 254, 2, 254, 51, 18, 149, 20, 0, 0, 0, 0,
    73, 69, 78, 68, 174, 66, 96, 130,
];

/// Extensions of compression, which are gone afterwards.
const PACKED: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Reads a glTF file that was imported with these options; `None` for an OBJ file. Errors if the file is not the one that was imported,
/// or a buffer cannot be read.
pub(crate) fn embed(path: &Path, options: &ImportOptions, imported: &Source) -> Result<Option<Embedded>> {
    let bytes = source::read_capped(path, options.max_bytes)?;
    if source::sha256(&bytes) != imported.sha256 {
        return Err(malformed(path, "file", "it was changed while it was read", "build the bundle again"));
    }
    let (text, bin) = match sniff::sniff(path, &bytes)? {
        sniff::Format::Obj => return Ok(None),
        sniff::Format::Glb => {
            let chunks = glb::split(path, &bytes)?;
            (chunks.json, chunks.bin)
        }
        sniff::Format::Gltf => (&bytes[..], None),
    };
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let resolver = |name: &str| source::read_beside(&folder, name, options.max_bytes);
    let doc = Document::parse(path, text, &mut Source::default())?;
    let buffers = Buffers::new(&doc, bin, &resolver, options.max_bytes);
    let max_count = options.max_vertices.max(options.max_triangles.saturating_mul(3));
    let accessors = Accessors { doc: &doc, buffers: &buffers, max_count };
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let end = text.iter().rposition(|&b| b != 0).map_or(0, |p| p + 1);
    let json: Value =
        serde_json::from_slice(&text[..end]).map_err(|e| malformed(path, "JSON", e.to_string(), "export it again"))?;
    let forest = Forest::new(&doc)?;
    let standing = stand::standing(&accessors, &forest, &forest.placed(&doc, &mut Findings::default())?);
    let mut out = Writer { json, bin: Vec::new(), accessors, options, drawn: HashMap::new(), lost: Vec::new() };
    out.decode_draco()?;
    out.pack_views()?;
    out.take_images()?;
    out.finish();
    rehang(&mut out.json, &standing);
    Ok(Some(Embedded { json: out.json, bin: out.bin, lost_images: out.lost }))
}

/// The file under way.
struct Writer<'a> {
    json: Value,
    bin: Vec<u8>,
    accessors: Accessors<'a>,
    options: &'a ImportOptions,
    /// Draco streams that are decoded, by accessor: the view that it comes from.
    drawn: HashMap<usize, u64>,
    lost: Vec<String>,
}

/// The elements of a list of the JSON.
fn items<'a>(json: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> {
    json.get_mut(name).and_then(Value::as_array_mut).into_iter().flatten()
}

impl Writer<'_> {
    /// Appends bytes with a view of their own, and returns its index.
    fn push(&mut self, data: &[u8]) -> usize {
        let view = append(&mut self.bin, data);
        let views = self.json["bufferViews"].as_array_mut();
        match views {
            Some(list) => list.push(view),
            None => self.json["bufferViews"] = json!([view]),
        }
        self.json["bufferViews"].as_array().map_or(0, |list| list.len() - 1)
    }

    /// Writes every Draco stream as plain accessors.
    fn decode_draco(&mut self) -> Result<()> {
        let doc = self.accessors.doc;
        for m in 0..doc.root.meshes.len() {
            for p in 0..doc.root.meshes[m].primitives.len() {
                let primitive = self.json["meshes"][m]["primitives"][p].clone();
                let header = &primitive["extensions"]["KHR_draco_mesh_compression"];
                if header.is_object() {
                    let element = format!("mesh {m} `{}`, primitive {p}", doc.mesh_name(m));
                    self.decode(&primitive, header, &element, (m, p))?;
                }
            }
        }
        Ok(())
    }

    fn decode(&mut self, primitive: &Value, header: &Value, element: &str, (m, p): (usize, usize)) -> Result<()> {
        let doc = self.accessors.doc;
        let bad = |problem: String| doc.bad(element, format!("Draco compression: {problem}"));
        let view = header["bufferView"].as_u64().ok_or_else(|| bad("it names no buffer view".into()))?;
        let decoded = {
            let data = self.accessors.buffers.view(view as usize)?.bytes;
            draco::decode(data, self.options.max_vertices, self.options.max_triangles).map_err(bad)?
        };
        let (count, order) = (decoded.vertex_count(), decoded.indices());
        for (name, id) in header["attributes"].as_object().into_iter().flatten() {
            let Some(index) = primitive["attributes"][name].as_u64().map(|a| a as usize) else { continue };
            if !self.has_accessor(index) {
                continue;
            }
            let values = id.as_u64().and_then(|id| decoded.attribute(u32::try_from(id).ok()?));
            let (width, values) = values.ok_or_else(|| bad(format!("its stream has no attribute {id}")))?;
            let component = self.json["accessors"][index]["componentType"].as_u64().unwrap_or(5126);
            let (data, stride) = encode(&values, width, component);
            let bounds = (name == "POSITION").then(|| bounds(&values, width));
            let written = self.place(index, view, &data, (count, component));
            self.json["meshes"][m]["primitives"][p]["attributes"][name] = json!(written);
            let view = self.aim(written, 34962);
            if let Some(stride) = stride {
                self.json["bufferViews"][view]["byteStride"] = json!(stride);
            }
            if let Some((lo, hi)) = bounds {
                self.json["accessors"][written]["min"] = json!(lo);
                self.json["accessors"][written]["max"] = json!(hi);
            }
        }
        let wide = count > usize::from(u16::MAX);
        let data: Vec<u8> = match wide {
            true => order.iter().flat_map(|v| v.to_le_bytes()).collect(),
            false => order.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
        };
        let component = if wide { 5125 } else { 5123 };
        let index = match primitive["indices"].as_u64() {
            Some(index) if self.has_accessor(index as usize) => index as usize,
            _ => self.accessor(json!({"type": "SCALAR"})),
        };
        let written = self.place(index, view, &data, (order.len(), component));
        self.aim(written, 34963);
        let target = &mut self.json["meshes"][m]["primitives"][p];
        target["indices"] = json!(written);
        target.as_object_mut().and_then(|t| t.remove("mode"));
        Ok(())
    }

    fn has_accessor(&self, index: usize) -> bool {
        self.json["accessors"].get(index).is_some()
    }

    /// States what the view of an accessor is for, and returns its index.
    fn aim(&mut self, accessor: usize, target: u32) -> usize {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().unwrap_or(0) as usize;
        self.json["bufferViews"][view]["target"] = json!(target);
        view
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        let list = self.json["accessors"].as_array_mut();
        let Some(list) = list else {
            self.json["accessors"] = json!([accessor]);
            return 0;
        };
        list.push(accessor);
        list.len() - 1
    }

    /// Gives an accessor these bytes, or a copy of it if another stream has given it others. Returns its index.
    fn place(&mut self, index: usize, stream: u64, data: &[u8], (count, component): (usize, u64)) -> usize {
        let index = match self.drawn.get(&index) {
            Some(&first) if first == stream => return index,
            Some(_) => self.accessor(self.json["accessors"][index].clone()),
            None => index,
        };
        self.drawn.insert(index, stream);
        let view = self.push(data);
        let accessor = &mut self.json["accessors"][index];
        // Bounds are those of the values before they were compressed.
        for key in ["byteOffset", "max", "min", "sparse"] {
            accessor.as_object_mut().and_then(|a| a.remove(key));
        }
        accessor["bufferView"] = json!(view);
        accessor["count"] = json!(count);
        accessor["componentType"] = json!(component);
        index
    }

    /// Copies the views of the file; views that overlap stay so.
    fn pack_views(&mut self) -> Result<()> {
        let doc = self.accessors.doc;
        // Streams of Draco are not copied: their views take the first decoded bytes, so that no index changes.
        let streams = self.streams();
        let mut ranges: BTreeMap<(u64, u64), u64> = BTreeMap::new();
        for (k, view) in doc.root.buffer_views.iter().enumerate() {
            if streams.contains(&k) || is_packed(&self.json["bufferViews"][k]) {
                continue;
            }
            let start = view.byte_offset.map_or(0, |o| o.0);
            let end = ranges.entry((view.buffer.value() as u64, start)).or_default();
            *end = (*end).max(start.saturating_add(view.byte_length.0));
        }
        // Ranges that overlap or touch are copied as one.
        let mut spans: Vec<(u64, u64, u64)> = Vec::new();
        for ((buffer, start), end) in ranges {
            match spans.last_mut() {
                Some((b, _, last)) if *b == buffer && start <= *last => *last = end.max(*last),
                _ => spans.push((buffer, start, end)),
            }
        }
        let mut places = Vec::with_capacity(spans.len());
        for &(buffer, start, end) in &spans {
            let data =
                self.accessors.buffers.range(buffer as usize, start, end - start, &format!("buffer {buffer}"))?;
            // As aligned as it was.
            let at = self.bin.len().next_multiple_of(4) + (start % 4) as usize;
            self.bin.resize(at, 0);
            self.bin.extend_from_slice(data);
            places.push(at as u64);
        }
        for (k, view) in doc.root.buffer_views.iter().enumerate() {
            let entry = &self.json["bufferViews"][k];
            if streams.contains(&k) {
                // One byte: no accessor reads it, and a view must not be empty.
                self.json["bufferViews"][k] = append(&mut self.bin, &[0; 4]);
            } else if is_packed(entry) {
                let (data, stride) = {
                    let view = self.accessors.buffers.view(k)?;
                    (view.bytes.to_vec(), view.stride)
                };
                let mut new = append(&mut self.bin, &data);
                let is_vertices = entry["target"] == json!(34962) || entry.get("byteStride").is_some();
                if let Some(stride) = stride.filter(|_| is_vertices) {
                    new["byteStride"] = json!(stride);
                }
                for key in ["target", "name", "extras"] {
                    if let Some(value) = entry.get(key) {
                        new[key] = value.clone();
                    }
                }
                self.json["bufferViews"][k] = new;
            } else {
                let (buffer, start) = (view.buffer.value() as u64, view.byte_offset.map_or(0, |o| o.0));
                let span = spans.partition_point(|s| (s.0, s.1) <= (buffer, start)).saturating_sub(1);
                let offset = places[span] + (start - spans[span].1);
                self.json["bufferViews"][k]["byteOffset"] = json!(offset);
                self.json["bufferViews"][k]["buffer"] = json!(0);
            }
        }
        Ok(())
    }

    /// The views of Draco streams.
    fn streams(&self) -> Vec<usize> {
        let primitives = self.json["meshes"].as_array().into_iter().flatten().flat_map(|m| m["primitives"].as_array());
        let view = |p: &Value| p["extensions"]["KHR_draco_mesh_compression"]["bufferView"].as_u64();
        primitives.flatten().filter_map(view).map(|v| v as usize).collect()
    }

    /// Takes in images that the file names by URI. An image that cannot be read becomes a white pixel.
    fn take_images(&mut self) -> Result<()> {
        let count = self.json["images"].as_array().map_or(0, Vec::len);
        for k in 0..count {
            let Some(uri) = self.json["images"][k]["uri"].as_str().map(String::from) else { continue };
            let element = format!("image {k}");
            let bytes = match self.accessors.buffers.file(&uri, &element) {
                Ok(bytes) => bytes,
                Err(error @ Error::TooLarge { .. }) => return Err(error),
                Err(error) => {
                    self.lost.push(error.to_string());
                    WHITE.to_vec()
                }
            };
            let kind = match &bytes[..] {
                [0xff, 0xd8, ..] => "image/jpeg",
                [0xab, b'K', b'T', b'X', ..] => "image/ktx2",
                [b'R', b'I', b'F', b'F', ..] => "image/webp",
                _ => "image/png",
            };
            let view = self.push(&bytes);
            let image = &mut self.json["images"][k];
            image.as_object_mut().and_then(|i| i.remove("uri"));
            image["bufferView"] = json!(view);
            image["mimeType"] = json!(kind);
        }
        Ok(())
    }

    /// Removes what is left of the compression, and states the one buffer.
    fn finish(&mut self) {
        for mesh in items(&mut self.json, "meshes") {
            for primitive in items(mesh, "primitives") {
                drop_extensions(primitive);
            }
        }
        for key in ["extensionsUsed", "extensionsRequired"] {
            let list = self.json.get_mut(key).and_then(Value::as_array_mut);
            let Some(list) = list else { continue };
            list.retain(|name| !name.as_str().is_some_and(|n| PACKED.contains(&n)));
            if list.is_empty() {
                self.json.as_object_mut().and_then(|o| o.remove(key));
            }
        }
    }
}

fn is_packed(view: &Value) -> bool {
    PACKED[1..].iter().any(|name| view["extensions"][*name].is_object())
}

fn drop_extensions(element: &mut Value) {
    let Some(object) = element.as_object_mut() else { return };
    if let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) {
        PACKED.iter().for_each(|name| _ = extensions.remove(*name));
        if extensions.is_empty() {
            object.remove("extensions");
        }
    }
}

/// Appends bytes on a whole word; returns their view.
fn append(bin: &mut Vec<u8>, data: &[u8]) -> Value {
    bin.resize(bin.len().next_multiple_of(4), 0);
    let view = json!({"buffer": 0, "byteLength": data.len(), "byteOffset": bin.len()});
    bin.extend_from_slice(data);
    view
}

/// Values in the type of an accessor, and the stride if elements are not whole words.
fn encode(values: &[f32], width: usize, component: u64) -> (Vec<u8>, Option<usize>) {
    let size = match component {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    };
    let stride = (width * size).next_multiple_of(4);
    let mut out = Vec::with_capacity(values.len() / width.max(1) * stride);
    for element in values.chunks(width.max(1)) {
        for &x in element {
            match component {
                5120 => out.extend((x as i8).to_le_bytes()),
                5121 => out.push(x as u8),
                5122 => out.extend((x as i16).to_le_bytes()),
                5123 => out.extend((x as u16).to_le_bytes()),
                5125 => out.extend((x as u32).to_le_bytes()),
                _ => out.extend(x.to_le_bytes()),
            }
        }
        out.resize(out.len().next_multiple_of(4), 0);
    }
    (out, (stride != width * size).then_some(stride))
}

fn bounds(values: &[f32], width: usize) -> (Vec<f32>, Vec<f32>) {
    let of = |k: usize| values.iter().skip(k).step_by(width.max(1)).copied();
    let least = |k| of(k).fold(f32::INFINITY, f32::min);
    let most = |k| of(k).fold(f32::NEG_INFINITY, f32::max);
    ((0..width).map(least).collect(), (0..width).map(most).collect())
}
