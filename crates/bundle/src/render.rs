//! `render.glb`: the mesh of the source, whose vertices are bound to the pieces.
//!
//! A reader of what this project writes: triangles, their attributes and base colours. Nothing in the file is trusted.

mod accessor;
mod check;
mod glb;
mod matrix;
mod nodes;
mod primitive;
mod uv_transform;
mod wrap;

use serde_json::Value;

use crate::error::{Error, Result};

pub(crate) use check::check_render;
pub use primitive::{RenderPrimitive, is_binding, numbered};
pub use uv_transform::UvTransform;
pub use wrap::{Wrap, texture_image};

/// The name of the file.
pub const RENDER_FILE: &str = "render.glb";
/// The attribute of vertices with piece, u and v.
pub const COORD: &str = "_GIMAGE_COORD";
/// The attribute of vertices with the offset from the surface.
pub const OFFSET: &str = "_GIMAGE_OFFSET";
/// The attribute of vertices with four joints of the skeleton of the bundle, as whole floats; further sets are numbered from 1.
pub const JOINTS: &str = "_GIMAGE_JOINTS";
/// The attribute of vertices with the weights of these joints.
pub const WEIGHTS: &str = "_GIMAGE_WEIGHTS";
/// The attribute of vertices with a share, 0 to 1, that multiplies the blend of their points of the surface.
pub const BLEND: &str = "_GIMAGE_BLEND";
/// Largest size of the file in bytes: 2 GiB.
pub const MAX_RENDER_BYTES: u64 = 2 << 30;

/// A parsed `render.glb`.
pub struct RenderFile<'a> {
    json: Value,
    bin: &'a [u8],
}

/// How a material draws the base of a surface; the fields of glTF's `pbrMetallicRoughness` that a picture needs.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderMaterial {
    /// Its name, empty if it has none.
    pub name: String,
    /// Linear red, green, blue and alpha, which multiply the texture.
    pub base_color: [f32; 4],
    /// The image of the base colour, an index for [`RenderFile::image`].
    pub base_image: Option<usize>,
    /// The set of texture coordinates of that image.
    pub base_set: usize,
    /// How that image goes on along u and v.
    pub base_wrap: [Wrap; 2],
    /// From texture coordinates of the mesh to those of that image: [`UvTransform::IDENTITY`] without `KHR_texture_transform`.
    pub base_transform: UvTransform,
    /// Alpha below which a pixel is not drawn, for the alpha mode `MASK`.
    pub cutoff: Option<f32>,
    /// Whether the alpha mode is `BLEND`.
    pub blends: bool,
    /// Whether both sides are drawn.
    pub double_sided: bool,
}

impl Default for RenderMaterial {
    fn default() -> Self {
        RenderMaterial {
            name: String::new(),
            base_color: [1.0; 4],
            base_image: None,
            base_set: 0,
            base_wrap: [Wrap::Repeat; 2],
            base_transform: UvTransform::IDENTITY,
            cutoff: None,
            blends: false,
            double_sided: false,
        }
    }
}

impl<'a> RenderFile<'a> {
    /// Reads the container and its JSON. Errors on a damaged container.
    pub fn parse(bytes: &'a [u8]) -> Result<Self> {
        let (json, bin) = glb::split(bytes)?;
        let json = serde_json::from_slice(json).map_err(|e| damaged("JSON", e.to_string()))?;
        Ok(RenderFile { json, bin })
    }

    /// The triangles of the scene: a primitive per node and primitive of its mesh, bound or not, in the order of the nodes. Points and lines
    /// are left out. Errors on the first accessor, node or index that is not as glTF demands.
    pub fn primitives(&self) -> Result<Vec<RenderPrimitive>> {
        primitive::all(self)
    }

    /// A material of the file; the default one for an index that does not exist.
    pub fn material(&self, index: Option<usize>) -> RenderMaterial {
        let material = index.and_then(|m| self.json["materials"].get(m)).unwrap_or(&Value::Null);
        let default = RenderMaterial::default();
        let base = &material["pbrMetallicRoughness"];
        let texture = &base["baseColorTexture"];
        let factor = |k: usize| base["baseColorFactor"][k].as_f64().map_or(default.base_color[k], |x| x as f32);
        let mode = material["alphaMode"].as_str().unwrap_or("OPAQUE");
        let moved = &texture["extensions"]["KHR_texture_transform"];
        let set = &moved["texCoord"];
        let source = texture["index"].as_u64().and_then(|t| self.json["textures"].get(t as usize));
        RenderMaterial {
            name: material["name"].as_str().unwrap_or_default().into(),
            base_color: std::array::from_fn(factor),
            base_image: source.and_then(texture_image),
            base_set: set.as_u64().or(texture["texCoord"].as_u64()).unwrap_or(0) as usize,
            base_wrap: source.map_or([Wrap::Repeat; 2], |texture| Wrap::of(&self.json, texture)),
            base_transform: UvTransform::of(moved),
            cutoff: (mode == "MASK").then(|| material["alphaCutoff"].as_f64().unwrap_or(0.5) as f32),
            blends: mode == "BLEND",
            double_sided: material["doubleSided"].as_bool().unwrap_or(false),
        }
    }

    /// The name of an image, else its number.
    pub fn image_name(&self, index: usize) -> String {
        let name = self.json["images"][index]["name"].as_str().filter(|name| !name.is_empty());
        name.map_or(format!("image {index}"), String::from)
    }

    /// The bytes of an image file in the file: PNG or JPEG, or another format that an extension of the file has; `None` where there is none.
    pub fn image(&self, index: usize) -> Option<&'a [u8]> {
        let view = self.json["images"].get(index)?["bufferView"].as_u64()?;
        self.view(view as usize).ok().map(|v| v.0)
    }
}

/// The error of a damaged file.
pub(crate) fn damaged(element: impl Into<String>, problem: impl Into<String>) -> Error {
    Error::Render { element: element.into(), problem: problem.into() }
}

#[cfg(test)]
mod tests;
