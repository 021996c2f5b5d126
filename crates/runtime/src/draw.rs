//! Draws scenes: the vertex shader reads the buffers of the simulation, and nothing is read back.
//!
//! [`Draw`] adds draws of all cloths and colliders to the host's own render pass; [`Software`] makes the same picture
//! on the CPU. There is no index buffer: a grid of W x H texels is `(W - 1) (H - 1) 6` vertices, and the shader works
//! out which texel each one is. Hosts with a renderer of their own read [`crate::ClothBuffers`] in their own shader.

#[cfg(feature = "gpu")]
mod device;
mod flat;
mod ground;
mod mesh;
#[cfg(feature = "gpu")]
mod paints;
mod raster;
mod rows;
mod shader;
mod software;
mod surface;
mod texture;

pub use crate::look::{Camera, Framing, Look, SolidLook, View, uv_of};
#[cfg(feature = "gpu")]
pub use device::{Draw, Target};
pub use gimage_bundle::Wrap;
pub use ground::Ground;
pub use software::{SheetView, Software};
pub use surface::{Alpha, Facet, Hidden, Paint};
pub use texture::Texture;

use crate::collider::Collider;
use crate::number::real::{add, cross, scale, xyz};

/// The box around positions \[m\] of particles (w at least 0) and finite colliders: its low and high corner. `None`
/// where there is neither.
pub fn bounds(positions: &[&[[f32; 4]]], colliders: &[Collider]) -> Option<([f32; 3], [f32; 3])> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let mut take = |p: [f32; 3]| {
        low = [0, 1, 2].map(|c| low[c].min(p[c]));
        high = [0, 1, 2].map(|c| high[c].max(p[c]));
    };
    for p in positions.iter().flat_map(|list| list.iter()).filter(|p| p[3] >= 0.0) {
        take(xyz(*p));
    }
    for collider in colliders {
        let Some(half) = mesh::half_extent(&collider.shape) else { continue };
        for k in 0..8 {
            let corner = [0, 1, 2].map(|c| if k >> c & 1 == 1 { half[c] } else { -half[c] });
            take(add(turned(collider.rotation, corner), collider.center));
        }
    }
    low.iter().zip(high).all(|(l, h)| l.is_finite() && h.is_finite()).then_some((low, high))
}

/// A vector turned by a unit quaternion.
fn turned(q: [f32; 4], v: [f32; 3]) -> [f32; 3] {
    let t = scale(cross(xyz(q), v), 2.0);
    add(add(v, scale(t, q[3])), cross(xyz(q), t))
}

/// The files of every drawing shader.
#[cfg(test)]
pub(crate) fn all_files() -> Vec<&'static str> {
    shader::Variant::ALL.iter().flat_map(|v| v.files()).collect()
}
