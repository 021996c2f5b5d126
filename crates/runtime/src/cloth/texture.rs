//! Texture coordinates of a cloth.

use super::{Cloth, Grid};

impl Cloth {
    /// Texture coordinates, one pair per particle: those of the bundle or of [`Cloth::set_grain`]; else (0, 0) to (1, 1) over
    /// each grid, u along its rows and v along its columns.
    pub fn uv(&self) -> Vec<[f32; 2]> {
        let side = |k: usize, n: u32| k as f32 / (n.max(2) - 1) as f32;
        let of = |g: &Grid| {
            let (width, height) = (g.width, g.height);
            let at = move |k: usize| [side(k % width as usize, width), side(k / width as usize, height)];
            (0..g.texels()).map(at)
        };
        self.grain().map_or_else(|| self.grids().iter().flat_map(of).collect(), <[_]>::to_vec)
    }
}
