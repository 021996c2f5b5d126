//! Materials as paints, with their textures decoded.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use gimage::import::BaseColor;
use gimage_bundle::{UvTransform, Wrap};
use gimage_runtime::RenderMesh;
use gimage_runtime::draw::{Alpha, Paint, Texture};
use image::{ImageReader, Limits};

use crate::output::{Output, Tone};

/// Most pixels on a side of a texture, and most bytes that decoding one may take.
const MAX_SIDE: u32 = 16_384;
const MAX_BYTES: u64 = 1 << 30;
/// sRGB of what has no material, or a plain white one.
const NO_MATERIAL: [f32; 3] = [0.75; 3];

/// Paints by number.
pub struct Paints<'a> {
    out: &'a Output,
    list: Vec<Paint>,
    transforms: Vec<UvTransform>,
    /// Textures by the bytes of their files: a file and its bundle have the same images.
    textures: HashMap<Vec<u8>, Option<Arc<Texture>>>,
}

/// How a material draws the base of a surface.
struct Base<'a> {
    color: [f32; 4],
    image: Option<(&'a [u8], &'a str)>,
    wrap: [Wrap; 2],
    transform: UvTransform,
    cutoff: Option<f32>,
    blends: bool,
}

impl<'a> Paints<'a> {
    /// With one paint, number 0, for triangles without a material. Textures that cannot be decoded are reported to `out`.
    pub fn new(out: &'a Output) -> Self {
        let (list, transforms) = (vec![Paint::plain(NO_MATERIAL)], vec![UvTransform::IDENTITY]);
        Paints { out, list, transforms, textures: HashMap::new() }
    }

    /// The numbers of the paints of the parts of a mesh.
    pub fn of_mesh(&mut self, mesh: &RenderMesh) -> Vec<usize> {
        let add = |part: &gimage_runtime::RenderPart| {
            let m = &part.material;
            let image =
                m.base_image.and_then(|i| Some((mesh.images.get(i)?.as_slice(), mesh.image_names.get(i)?.as_str())));
            let (color, transform, cutoff, blends) = (m.base_color, m.base_transform, m.cutoff, m.blends);
            let (image, wrap) = (image.filter(|i| !i.0.is_empty()), m.base_wrap);
            self.add(&Base { color, image, wrap, transform, cutoff, blends })
        };
        mesh.parts.iter().map(add).collect()
    }

    /// The number of the paint of a material of a file.
    pub fn of_file(&mut self, c: &BaseColor) -> usize {
        let image = c.image.as_deref().map(|bytes| (bytes, c.image_name.as_str()));
        let color = c.factor.map(|x| x as f32);
        let (transform, cutoff, blends) = (c.transform, c.cutoff, c.blends);
        self.add(&Base { color, image, wrap: c.wrap, transform, cutoff, blends })
    }

    /// Texture coordinates of a mesh as those of the texture of a paint.
    pub fn uv(&self, paint: usize, uv: [f32; 2]) -> [f32; 2] {
        self.transforms.get(paint).map_or(uv, |transform| transform.apply(uv))
    }

    /// All paints, in the order of their numbers.
    pub fn list(&self) -> Vec<Paint> {
        self.list.clone()
    }

    fn add(&mut self, base: &Base) -> usize {
        let alpha = match (base.cutoff, base.blends) {
            (Some(cutoff), _) => Alpha::Mask(cutoff),
            (None, true) => Alpha::Blend,
            (None, false) => Alpha::Opaque,
        };
        let texture = base.image.and_then(|(bytes, name)| self.texture(bytes, name));
        // Light shows no form on plain white.
        if base.image.is_none() && base.color == [1.0; 4] && alpha == Alpha::Opaque {
            return 0;
        }
        let paint = Paint { color: base.color, texture, wrap: base.wrap, alpha };
        let known = self.list.iter().zip(&self.transforms).position(|(p, t)| same(p, &paint) && *t == base.transform);
        known.unwrap_or_else(|| {
            self.list.push(paint);
            self.transforms.push(base.transform);
            self.list.len() - 1
        })
    }

    fn texture(&mut self, bytes: &[u8], name: &str) -> Option<Arc<Texture>> {
        if let Some(known) = self.textures.get(bytes) {
            return known.clone();
        }
        let texture = decode(bytes).map(Arc::new);
        if let Err(problem) = &texture {
            let text = format!("texture '{name}': {problem}; its surfaces are drawn in the colour of their material");
            self.out.remark(Tone::Warning, "warning", &text);
        }
        let texture = texture.ok();
        self.textures.insert(bytes.to_vec(), texture.clone());
        texture
    }
}

/// Whether two paints draw the same: textures are compared by place, not by pixels.
fn same(a: &Paint, b: &Paint) -> bool {
    let texture = match (&a.texture, &b.texture) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (None, None) => true,
        _ => false,
    };
    texture && a.wrap == b.wrap && a.color == b.color && a.alpha == b.alpha
}

/// The texture of a PNG, JPEG or WebP file.
fn decode(bytes: &[u8]) -> Result<Texture, String> {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_BYTES);
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    reader.limits(limits);
    use image::ImageFormat::{Jpeg, Png, WebP};
    if !matches!(reader.format(), Some(Png | Jpeg | WebP)) {
        return Err("it is neither a PNG nor a JPEG nor a WebP".into());
    }
    let image = reader.decode().map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = image.dimensions();
    Texture::new(width, height, image.into_raw().as_chunks::<4>().0.to_vec()).map_err(|e| e.to_string())
}
