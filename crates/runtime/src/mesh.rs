//! The triangles of a cloth, for renderers of meshes.

use crate::cloth::Cloth;
use crate::cpu::indices::{self, PER_TEXEL};
use crate::cpu::neighbours::View;

impl Cloth {
    /// The triangles of all grids, three particles each, counter-clockwise seen from the front, the side that normals point to. In
    /// the order of the quads, grid by grid; a quad of four particles has two triangles, one of three has one. Without
    /// cuts: [`crate::Stepper::indices`] has those that are left. One pass over the texels.
    ///
    /// Duplicates of a seam point are particles of their own, which move alike, so that the mesh closes and texture
    /// coordinates may differ on the two sides.
    pub fn indices(&self) -> Vec<u32> {
        self.indices_left(&[])
    }

    /// As [`Cloth::indices`], without the triangles that a cut has taken away: `holes` as [`crate::Stepper::holes`], or read back from
    /// [`crate::ClothBuffers::holes`], one per particle; empty for cloth that is whole.
    pub fn indices_left(&self, holes: &[u32]) -> Vec<u32> {
        indices::triangles(&self.all_indices(holes))
    }

    /// Six indices per texel, as shaders/indices.wgsl writes them; `holes` are the triangles that are cut away.
    pub(crate) fn all_indices(&self, holes: &[u32]) -> Vec<u32> {
        let now: Vec<[f32; 4]> = (0..self.len()).map(|k| [0.0, 0.0, 0.0, self.inverse_mass(k)]).collect();
        let mut all = vec![0; PER_TEXEL * self.len()];
        for g in self.grids() {
            let range = g.range();
            let holes = holes.get(range.clone()).unwrap_or(&[]);
            let view = View { now: &now[range.clone()], width: g.width as usize, holes };
            indices::run(view, g.first, &mut all[PER_TEXEL * range.start..PER_TEXEL * range.end]);
        }
        all
    }
}
