//! The appearance of cloths and colliders, and where they are seen from.

mod camera;
mod framing;

pub use camera::{Camera, View};
pub use framing::Framing;

use std::collections::HashMap;

use gimage_bundle::{Bundle, MapKind};

use crate::cloth::Grid;
use crate::handle::{ClothHandle, ClothRef};

/// How a cloth is drawn. Colours are sRGB, 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The side that the normals point to.
    pub front: [f32; 3],
    /// The other side.
    pub back: [f32; 3],
    /// Texture coordinates, one pair per particle; `None` needs no buffer.
    pub uv: Option<Vec<[f32; 2]>>,
    /// Tiles in one unit of the texture coordinates, and how much darker every other tile is, 0 to 1. Without
    /// coordinates there is no pattern.
    pub checker: [f32; 2],
}

/// Colours of the first cloths.
const COLORS: [[f32; 3]; 4] = [[0.72, 0.20, 0.22], [0.14, 0.42, 0.62], [0.85, 0.62, 0.20], [0.30, 0.52, 0.34]];

impl Look {
    /// A plain colour; the back is a paler one.
    pub fn plain(front: [f32; 3]) -> Self {
        let back = front.map(|c| 0.55 * c + 0.3);
        Look { front, back, uv: None, checker: [0.0; 2] }
    }

    /// Default look of the cloth of an index.
    pub fn of(index: usize) -> Self {
        Look::plain(COLORS[index % COLORS.len()])
    }

    /// How far apart texture coordinates of one triangle may be; further ones lie on two sides of a texture's seam.
    pub(crate) fn jump(&self, grids: &[Grid]) -> f32 {
        let Some(uv) = &self.uv else { return 0.0 };
        let mut steps = Vec::new();
        for grid in grids {
            let width = grid.width as usize;
            let inner = grid.range().filter(|k| (k - grid.first as usize) % width + 1 < width);
            steps.extend(inner.map(|k| (uv[k + 1][0] - uv[k][0]).abs().max((uv[k + 1][1] - uv[k][1]).abs())));
        }
        let middle = steps.len() / 2;
        if steps.is_empty() { 0.0 } else { 4.0 * *steps.select_nth_unstable_by(middle, f32::total_cmp).1 }
    }
}

/// The looks of the cloths of a stepper. The look of an index is for the cloth that has it when cloths are drawn, unless the cloth has
/// a look by its handle.
#[derive(Default)]
pub(crate) struct Looks {
    by_index: HashMap<usize, Look>,
    by_handle: HashMap<ClothHandle, Look>,
}

impl Looks {
    pub fn set(&mut self, cloth: ClothRef, look: Look) {
        match cloth {
            ClothRef::Index(index) => self.by_index.insert(index, look),
            ClothRef::Handle(handle) => self.by_handle.insert(handle, look),
        };
    }

    /// Forgets cloths that are gone.
    #[cfg(feature = "gpu")]
    pub fn keep(&mut self, handles: &[ClothHandle]) {
        self.by_handle.retain(|handle, _| handles.binary_search(handle).is_ok());
    }

    /// The look of a cloth.
    pub fn of(&self, index: usize, handle: ClothHandle) -> Look {
        let given = self.by_handle.get(&handle).or_else(|| self.by_index.get(&index));
        given.cloned().unwrap_or_else(|| Look::of(index))
    }
}

/// How all colliders are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidLook {
    /// sRGB, 0 to 1.
    pub color: [f32; 3],
    /// How far \[m\] within its shape a collider is drawn. Default 0.004, because cloth lies right on the surface.
    pub inset: f32,
}

impl Default for SolidLook {
    fn default() -> Self {
        SolidLook { color: [0.58, 0.60, 0.65], inset: 0.004 }
    }
}

/// The texture coordinates of a bundle, one pair per particle; `None` if no piece has any. Pieces without have (0, 0).
pub fn uv_of(bundle: &Bundle) -> Option<Vec<[f32; 2]>> {
    let mut all = Vec::new();
    let mut any = false;
    for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
        let image = bundle.image(index, &MapKind::Uv(0));
        any |= image.is_some();
        let pair = |k: usize| image.and_then(|i| i.at(k).get(..2)?.try_into().ok()).unwrap_or([0.0; 2]);
        all.extend((0..piece.width as usize * piece.height as usize).map(pair));
    }
    any.then_some(all)
}
