//! Stitches of a coarser image: between the coarse texels around their two ends.

use std::collections::BTreeMap;

use super::Map;
use crate::cloth::{Cloth, Stitch};

impl Map {
    /// The stitches of the fine cloth, one per coarse particle at most: that of the fine particle which the coarse one is, or the first of
    /// those around it. Lengths are those of the coarse image.
    pub fn stitches(&self, fine: &Cloth, coarse: &Cloth) -> Vec<Stitch> {
        let mut found: BTreeMap<u32, (bool, Stitch)> = BTreeMap::new();
        for (stitch, thread) in fine.stitches().iter().zip(fine.sewing().into_iter().flat_map(|s| &s.threads)) {
            let Some(particle) = self.main(stitch.particle) else { continue };
            let exact = self.samples[particle as usize] == stitch.particle;
            let Some(stitch) =
                self.carried(fine, coarse, thread).map(|s| Stitch { particle, piece: stitch.piece, ..s })
            else {
                continue;
            };
            let stitch = Stitch { distance: length(coarse, &stitch), ..stitch };
            let best = found.entry(particle).or_insert((exact, stitch));
            if exact && !best.0 {
                *best = (exact, stitch);
            }
        }
        found.into_values().map(|(_, stitch)| stitch).collect()
    }

    /// The coarse particle that counts most in a fine one.
    fn main(&self, k: u32) -> Option<u32> {
        let parts = self.stencils[k as usize].parts();
        parts.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|(k, _)| k as u32)
    }

    /// The point of a stitch on the coarse grid, in the triangle of the corner that is nearest to it.
    fn carried(&self, fine: &Cloth, coarse: &Cloth, thread: &crate::cloth::Thread) -> Option<Stitch> {
        let [s, t] = thread.inner;
        let shares = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let mut at = [0.0f32; 3];
        for (k, share) in thread.ends.iter().zip(shares) {
            (0..3).for_each(|c| at[c] += share * fine.positions()[*k as usize][c]);
        }
        let nearest = (0..4).max_by(|a, b| shares[*a].total_cmp(&shares[*b]).then(b.cmp(a)))?;
        let stencil = self.stencils[thread.ends[nearest] as usize].at_place(at, |k| coarse.positions()[k]);
        let first = stencil.parts().next()?.0 as u32;
        let grid = coarse.grids().iter().find(|g| g.range().contains(&(first as usize)))?;
        let mut uv = [0.0f32; 2];
        for (k, share) in stencil.parts() {
            let k = (k as u32).checked_sub(grid.first)?;
            let place = [(k % grid.width) as f32, (k / grid.width) as f32];
            let sides = [grid.width - 1, grid.height - 1];
            (0..2).for_each(|c| uv[c] += share * place[c] / sides[c] as f32);
        }
        Some(Stitch { particle: 0, piece: 0, at: uv.map(|x| x.clamp(0.0, 1.0)), distance: 0.0 })
    }
}

/// Distance of the two ends of a stitch at the start \[m\].
fn length(cloth: &Cloth, stitch: &Stitch) -> f32 {
    let Some(grid) = cloth.grids().get(stitch.piece as usize) else { return 0.0 };
    let place = gimage_bundle::Place::of(grid.width, grid.height, stitch.at);
    let from = cloth.positions()[stitch.particle as usize];
    let mut way = from.map(|x| -f64::from(x));
    for (k, share) in place.corners(grid.width).into_iter().zip(place.shares()) {
        let p = cloth.positions()[(grid.first + k) as usize];
        (0..3).for_each(|c| way[c] += f64::from(share) * f64::from(p[c]));
    }
    way.iter().map(|x| x * x).sum::<f64>().sqrt() as f32
}
