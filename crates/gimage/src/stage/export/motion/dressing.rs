//! The materials of a source file, with the images that they use, for the file of a motion.

use std::collections::BTreeMap;
use std::path::Path;

use gimage_bundle::texture_image;
use serde_json::{Map, Value, json};

use super::super::glb::BinaryChunk;
use crate::error::Result;
use crate::stage::import::{EXPORT_AGAIN, malformed, split_glb};

/// The textures of a material that core glTF has, by their paths.
const TEXTURES: [&[&str]; 5] = [
    &["pbrMetallicRoughness", "baseColorTexture"],
    &["pbrMetallicRoughness", "metallicRoughnessTexture"],
    &["normalTexture"],
    &["occlusionTexture"],
    &["emissiveTexture"],
];
const TRANSFORM: &str = "KHR_texture_transform";

/// Materials of pieces, and colours of positions.
#[derive(Clone, Debug, Default)]
pub struct Dressing {
    materials: Vec<Value>,
    textures: Vec<Value>,
    samplers: Vec<Value>,
    /// Media type, name and bytes.
    images: Vec<(Value, Value, Vec<u8>)>,
    extensions: Vec<String>,
    /// Index of the material of each piece.
    of_piece: Vec<usize>,
    colors: Vec<[f32; 4]>,
}

/// A material of a piece: its index in the file, and the set of texture coordinates that the piece has.
pub type Worn = (Option<usize>, usize);

impl Dressing {
    /// No material yet, and a linear colour per position of a surface, or none.
    pub fn new(colors: Vec<[f32; 4]>) -> Self {
        Dressing { colors, ..Dressing::default() }
    }

    /// Adds the materials of a GLB file for the next pieces of a surface. Each piece has one set of
    /// texture coordinates: textures that use another set are left out, and so are extensions of materials with textures of their
    /// own. A piece without a material has a grey one of two sides. Errors on a damaged container; a texture whose image is not in the
    /// file is left out.
    pub fn add_glb(&mut self, bytes: &[u8], pieces: &[Worn]) -> Result<()> {
        let path = Path::new("render.glb");
        let chunks = split_glb(path, bytes)?;
        let file: Value =
            serde_json::from_slice(chunks.json).map_err(|e| malformed(path, "JSON", e.to_string(), EXPORT_AGAIN))?;
        let mut source = Source { file: &file, bin: chunks.bin.unwrap_or_default(), textures: BTreeMap::new() };
        let mut known: BTreeMap<Worn, usize> = BTreeMap::new();
        for worn in pieces {
            let index = *known.entry(*worn).or_insert_with(|| {
                let material = source.material(*worn, self);
                self.materials.push(material);
                self.materials.len() - 1
            });
            self.of_piece.push(index);
        }
        Ok(())
    }

    /// The material of a piece.
    pub(super) fn material(&self, piece: usize) -> usize {
        self.of_piece.get(piece).copied().unwrap_or(0)
    }

    /// The colours of these positions; none if the surface has none.
    pub(super) fn colors(&self, points: &[u32]) -> Option<Vec<[f32; 4]>> {
        let color = |p: &u32| self.colors.get(*p as usize).copied().unwrap_or([1.0; 4]);
        (!self.colors.is_empty()).then(|| points.iter().map(color).collect())
    }

    /// Bytes of the images.
    pub(super) fn bytes(&self) -> u64 {
        self.images.iter().map(|image| image.2.len() as u64).sum()
    }

    /// Puts materials, textures and images into a file.
    pub(super) fn place(self, root: &mut Value, chunk: &mut BinaryChunk) {
        root["materials"] = self.materials.into();
        let image = |(kind, name, bytes): (Value, Value, Vec<u8>)| {
            let mut image = json!({"bufferView": chunk.view(&bytes, None), "mimeType": kind});
            if name.is_string() {
                image["name"] = name;
            }
            image
        };
        let images: Vec<Value> = self.images.into_iter().map(image).collect();
        for (key, list) in [("images", images), ("samplers", self.samplers), ("textures", self.textures)] {
            // glTF has no empty arrays.
            if !list.is_empty() {
                root[key] = list.into();
            }
        }
        if !self.extensions.is_empty() {
            root["extensionsUsed"] = self.extensions.into();
        }
    }
}

/// The file that materials come from, and the textures that are taken already.
struct Source<'a> {
    file: &'a Value,
    bin: &'a [u8],
    textures: BTreeMap<u64, Option<usize>>,
}

impl Source<'_> {
    fn material(&mut self, (index, set): Worn, out: &mut Dressing) -> Value {
        let rough = json!({"baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9});
        let plain = json!({"name": "cloth", "doubleSided": true, "pbrMetallicRoughness": rough});
        let mut material = index.and_then(|m| self.file["materials"].get(m)).cloned().unwrap_or(plain);
        for path in TEXTURES {
            let (last, parents) = path.split_last().map_or(("", &[][..]), |(last, parents)| (*last, parents));
            let parent =
                parents.iter().try_fold(&mut material, |at, key| at.get_mut(*key)).and_then(Value::as_object_mut);
            let Some(parent) = parent else { continue };
            let Some(info) = parent.remove(last) else { continue };
            if let Some(info) = self.texture_info(info, set, out) {
                parent.insert(last.into(), info);
            }
        }
        if let Some(extensions) = material["extensions"].as_object() {
            let kept: Map<String, Value> =
                extensions.iter().filter(|(_, v)| !has_textures(v)).map(|(k, v)| (k.clone(), v.clone())).collect();
            kept.keys().for_each(|name| out.uses(name));
            material["extensions"] = kept.into();
        }
        if material["extensions"].as_object().is_none_or(Map::is_empty) {
            material.as_object_mut().map(|m| m.remove("extensions"));
        }
        material
    }

    /// A reference to a texture, with numbers of the new file; none if it uses another set of coordinates or has no image.
    fn texture_info(&mut self, mut info: Value, set: usize, out: &mut Dressing) -> Option<Value> {
        let moved = info["extensions"][TRANSFORM].clone();
        let own = moved["texCoord"].as_u64().or(info["texCoord"].as_u64()).unwrap_or(0);
        let index = info["index"].as_u64().filter(|_| own == set as u64)?;
        let new = match self.textures.get(&index) {
            Some(known) => *known,
            None => {
                let new = self.texture(index as usize, out);
                self.textures.insert(index, new);
                new
            }
        };
        let fields = info.as_object_mut()?;
        fields.insert("index".into(), new?.into());
        fields.remove("texCoord");
        fields.remove("extensions");
        if let Value::Object(mut moved) = moved {
            moved.remove("texCoord");
            fields.insert("extensions".into(), json!({TRANSFORM: moved}));
            out.uses(TRANSFORM);
        }
        Some(info)
    }

    fn texture(&self, index: usize, out: &mut Dressing) -> Option<usize> {
        let number = |value: &Value| value.as_u64().map(|n| n as usize);
        let texture = self.file["textures"].get(index)?;
        let image = self.file["images"].get(texture_image(texture)?)?;
        let view = self.file["bufferViews"].get(number(&image["bufferView"])?)?;
        let start = number(&view["byteOffset"]).unwrap_or(0);
        let bytes = self.bin.get(start..start.checked_add(number(&view["byteLength"])?)?)?;
        let same = |i: &(Value, Value, Vec<u8>)| i.2 == bytes;
        let place = out.images.iter().position(same).unwrap_or_else(|| {
            out.images.push((image["mimeType"].clone(), image["name"].clone(), bytes.to_vec()));
            out.images.len() - 1
        });
        // An image in another format stays where its extension has it.
        let others = texture["extensions"].as_object().filter(|_| texture["source"].is_null());
        let mut new = match others.and_then(|all| all.iter().find(|(_, of)| of["source"].is_u64())) {
            Some((name, _)) => {
                out.uses(name);
                json!({"extensions": {name.as_str(): {"source": place}}})
            }
            None => json!({"source": place}),
        };
        if let Some(sampler) = number(&texture["sampler"]).and_then(|s| self.file["samplers"].get(s)) {
            let at = out.samplers.iter().position(|s| s == sampler).unwrap_or_else(|| {
                out.samplers.push(sampler.clone());
                out.samplers.len() - 1
            });
            new["sampler"] = at.into();
        }
        out.textures.push(new);
        Some(out.textures.len() - 1)
    }
}

impl Dressing {
    fn uses(&mut self, extension: &str) {
        if !self.extensions.iter().any(|known| known == extension) {
            self.extensions.push(extension.into());
        }
    }
}

/// Whether a value refers to a texture anywhere.
fn has_textures(value: &Value) -> bool {
    match value {
        Value::Object(fields) => fields.contains_key("index") || fields.values().any(has_textures),
        Value::Array(list) => list.iter().any(has_textures),
        _ => false,
    }
}
