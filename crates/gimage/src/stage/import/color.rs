//! Base colours of the materials of a glTF file, for pictures: an import reads no looks.

use std::path::Path;

use gimage_bundle::{UvTransform, Wrap, texture_image};
use serde_json::Value;

use super::buffers::{data_uri, relative_path};
use super::{EXPORT_AGAIN, ImportOptions, glb, malformed, sniff, source};
use crate::error::Result;

/// The base colour of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseColor {
    /// Name of the material, as [`crate::mesh::Part::material`] has it.
    pub material: String,
    /// Linear red, green, blue and opacity, which the texture is multiplied by.
    pub factor: [f64; 4],
    /// The texture: the bytes of a PNG, JPEG or other image file. None without one, and where it cannot be read.
    pub image: Option<Vec<u8>>,
    /// The name of the texture's image, else its place in the file.
    pub image_name: String,
    /// The set of texture coordinates.
    pub tex_coord: u32,
    /// How the texture goes on along u and v.
    pub wrap: [Wrap; 2],
    /// From those coordinates to the ones of the texture.
    pub transform: UvTransform,
    /// Alpha below which a pixel is not drawn, for the alpha mode `MASK`.
    pub cutoff: Option<f32>,
    /// Whether the alpha mode is `BLEND`.
    pub blends: bool,
}

/// The base colours of all materials of a `.glb` or `.gltf` file, in its order; none of an OBJ file. O(bytes of the file and its images).
///
/// Errors if the file cannot be read or has no JSON. A texture that cannot be read is left out.
pub fn base_colors(path: &Path, options: &ImportOptions) -> Result<Vec<BaseColor>> {
    let bytes = source::read_capped(path, options.max_bytes)?;
    let (json, bin) = match sniff::sniff(path, &bytes)? {
        sniff::Format::Glb => {
            let chunks = glb::split(path, &bytes)?;
            (chunks.json, chunks.bin)
        }
        sniff::Format::Gltf => (&bytes[..], None),
        sniff::Format::Obj => return Ok(Vec::new()),
    };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|&b| b != 0).map_or(0, |p| p + 1);
    let root: Value =
        serde_json::from_slice(&json[..end]).map_err(|e| malformed(path, "JSON", e.to_string(), EXPORT_AGAIN))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let beside = |name: &str| source::read_beside(folder, name, options.max_bytes).ok();
    let color = |(index, material): (usize, &Value)| {
        let pbr = &material["pbrMetallicRoughness"];
        let texture = &pbr["baseColorTexture"];
        let moved = &texture["extensions"]["KHR_texture_transform"];
        let mode = material["alphaMode"].as_str().unwrap_or("OPAQUE");
        let factor = [0, 1, 2, 3].map(|c| pbr["baseColorFactor"][c].as_f64().unwrap_or(1.0));
        BaseColor {
            material: material["name"].as_str().map_or(format!("material {index}"), String::from),
            factor,
            image: texture["index"].as_u64().and_then(|t| image(&root, t as usize, bin, &beside)),
            image_name: image_name(&root, texture),
            tex_coord: moved["texCoord"].as_u64().or(texture["texCoord"].as_u64()).unwrap_or(0) as u32,
            wrap: texture["index"]
                .as_u64()
                .map_or([Wrap::Repeat; 2], |t| Wrap::of(&root, &root["textures"][t as usize])),
            transform: UvTransform::of(moved),
            cutoff: (mode == "MASK").then(|| material["alphaCutoff"].as_f64().unwrap_or(0.5) as f32),
            blends: mode == "BLEND",
        }
    };
    Ok(root["materials"].as_array().into_iter().flatten().enumerate().map(color).collect())
}

/// The name of the image of a texture, else its file, else its number; empty without one.
fn image_name(root: &Value, texture: &Value) -> String {
    let source = texture["index"].as_u64().and_then(|t| texture_image(&root["textures"][t as usize]));
    let Some(index) = source else { return String::new() };
    let image = &root["images"][index];
    let uri = image["uri"].as_str().filter(|uri| !uri.starts_with("data:"));
    image["name"].as_str().filter(|name| !name.is_empty()).or(uri).map_or(format!("image {index}"), String::from)
}

/// The bytes of the image of a texture.
fn image(
    root: &Value,
    texture: usize,
    bin: Option<&[u8]>,
    beside: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Option<Vec<u8>> {
    let index = |value: &Value| value.as_u64().map(|i| i as usize);
    let image = &root["images"][texture_image(&root["textures"][texture])?];
    let read = |uri: &str| match uri.strip_prefix("data:") {
        Some(rest) => data_uri(rest).ok(),
        None => beside(&relative_path(uri).ok()?),
    };
    if let Some(uri) = image["uri"].as_str() {
        return read(uri);
    }
    let view = &root["bufferViews"][index(&image["bufferView"])?];
    let buffer = index(&view["buffer"])?;
    let (from, length) = (index(&view["byteOffset"]).unwrap_or(0), index(&view["byteLength"])?);
    let within = |bytes: &[u8]| bytes.get(from..from.checked_add(length)?).map(<[u8]>::to_vec);
    match root["buffers"][buffer]["uri"].as_str() {
        Some(uri) => within(&read(uri)?),
        None => within(bin.filter(|_| buffer == 0)?),
    }
}
