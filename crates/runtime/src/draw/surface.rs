//! Surfaces that the host moves, such as the body of a character: triangles beside cloths and colliders.

use std::collections::BTreeSet;
use std::sync::Arc;

use gimage_bundle::Wrap;

use super::raster::decoded;
use super::texture::Texture;

/// A triangle that the host places, lit from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Corners \[m\], counter-clockwise seen from the front.
    pub corners: [[f32; 3]; 3],
    /// Normals of the corners, of any length.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates of the corners (v down).
    pub uv: [[f32; 2]; 3],
    /// Linear colours of the corners, which multiply the paint; red, green, blue and alpha.
    pub colors: [[f32; 4]; 3],
    /// Index of its paint; an index without a paint is drawn white.
    pub paint: usize,
}

/// The colour of facets. A pixel is `color` times the texture times the colour of the corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint {
    /// Linear red, green, blue and alpha.
    pub color: [f32; 4],
    /// Sampled per pixel, bilinear, in the level whose pixels are nearest to one per sample of the picture: [`super::Software`] takes one
    /// level per triangle, [`super::Draw`] one per pixel.
    pub texture: Option<Arc<Texture>>,
    /// How the texture goes on along u and v.
    pub wrap: [Wrap; 2],
    /// The effect of alpha.
    pub alpha: Alpha,
}

/// The effect of a pixel's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Nothing.
    Opaque,
    /// Samples with an alpha below this one are not drawn.
    Mask(f32),
    /// Alpha is the share of the samples that are drawn, by an ordered dither of 4 x 4 pixels with 4 samples each: no order of triangles is needed.
    Blend,
}

impl Paint {
    /// One opaque colour, sRGB, 0 to 1.
    pub fn plain(color: [f32; 3]) -> Self {
        let [r, g, b] = color.map(decoded);
        Paint { color: [r, g, b, 1.0], texture: None, wrap: [Wrap::Repeat; 2], alpha: Alpha::Opaque }
    }
}

impl Default for Paint {
    fn default() -> Self {
        Paint::plain([1.0; 3])
    }
}

/// Parts of a scene that are left out of pictures, as a surface stands for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hidden {
    /// Indices of colliders.
    pub colliders: BTreeSet<usize>,
    /// Indices of cloths.
    pub cloths: BTreeSet<usize>,
}

/// Triangles as shaders/draw_surface.wgsl reads them: position and u, normal and v, colour of each corner, and the paint, of which there are a
/// number; a facet without one has the number after the last.
#[cfg(feature = "gpu")]
pub(super) fn rows(facets: &[Facet], paints: usize) -> Vec<[[f32; 4]; 10]> {
    let four = |[x, y, z]: [f32; 3], w: f32| [x, y, z, w];
    let row = |f: &Facet| {
        let mut row = [[0.0; 4]; 10];
        for c in 0..3 {
            let [u, v] = f.uv[c];
            row[3 * c] = four(f.corners[c], u);
            row[3 * c + 1] = four(f.normals[c], v);
            row[3 * c + 2] = f.colors[c];
        }
        row[9][0] = f.paint.min(paints) as f32;
        row
    };
    facets.iter().map(row).collect()
}
