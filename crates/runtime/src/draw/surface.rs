//! Surfaces that the host moves, such as the body of a character: triangles beside cloths and colliders.

#[cfg(feature = "gpu")]
use super::raster::decoded;

/// A triangle that the host places, lit from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Corners \[m\], counter-clockwise seen from the front.
    pub corners: [[f32; 3]; 3],
    /// Normals of the corners, of any length.
    pub normals: [[f32; 3]; 3],
    /// sRGB, 0 to 1.
    pub color: [f32; 3],
}

/// Triangles as shaders/part/drawn_surface.wgsl reads them: position, normal and linear colour of each corner.
#[cfg(feature = "gpu")]
pub(super) fn rows(facets: &[Facet]) -> Vec<[[f32; 4]; 3]> {
    let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    let row = |f: &Facet| [0, 1, 2].map(|c| [four(f.corners[c]), four(f.normals[c]), four(f.color.map(decoded))]);
    facets.iter().flat_map(row).collect()
}
