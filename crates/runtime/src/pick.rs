//! The first cloth that a ray meets.

#[cfg(feature = "gpu")]
mod ticket;

#[cfg(feature = "gpu")]
pub(crate) use ticket::Answer;
#[cfg(feature = "gpu")]
pub use ticket::PickTicket;

use crate::cloth::Cloth;
use crate::cpu::body::view;
use crate::cpu::pick_nearest;
use crate::error::{Error, Result, check};
use crate::handle::ClothHandle;
use crate::number::real::Real;

/// A point of cloth on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the cloth when the search was made.
    pub cloth: usize,
    /// Handle of the cloth; `None` from [`pick`], which knows of no stepper.
    pub handle: Option<ClothHandle>,
    /// Index of the grid: the piece of the bundle.
    pub grid: usize,
    /// Column and row of the quad's upper left texel.
    pub texel: [u32; 2],
    /// Which triangle of the quad: the bit of [`crate::ClothBuffers::holes`].
    pub triangle: u32,
    /// Its particles, among those of the cloth.
    pub particles: [u32; 3],
    /// Weights of the particles, of sum 1. As much as 2e-6 outside of 0 to 1 on an edge.
    pub barycentric: [f32; 3],
    /// Where the particles are \[m\].
    pub corners: [[f32; 3]; 3],
    /// From the origin of the ray \[m\].
    pub distance: f32,
}

impl Hit {
    /// The point itself \[m\].
    pub fn point(&self) -> [f32; 3] {
        [0, 1, 2].map(|c| (0..3).map(|n| self.barycentric[n] * self.corners[n][c]).sum())
    }
}

/// Finds the nearest triangle of one cloth on the ray from `origin` \[m\] along `direction` (of any length but 0), from either
/// side; `positions` as [`crate::Stepper::positions`] or read back, `holes` as [`crate::Stepper::holes`]. Costs a look at every
/// triangle. `cloth` of the hit is 0. Errors on lists of the wrong length, numbers that are not finite and no direction.
pub fn pick(
    cloth: &Cloth,
    positions: &[[f32; 4]],
    holes: Option<&[u32]>,
    origin: [f32; 3],
    direction: [f32; 3],
) -> Result<Option<Hit>> {
    let expected = cloth.len();
    for (what, found) in [("positions", positions.len()), ("holes", holes.map_or(expected, <[u32]>::len))] {
        if found != expected {
            return Err(Error::Length { cloth: cloth.name().into(), what, found, expected });
        }
    }
    let direction = unit(origin, direction)?;
    let holes = holes.unwrap_or(&[]);
    let candidates = (cloth.grids().iter())
        .flat_map(|g| crate::cpu::pick::run(view(positions, holes, g), g.first, origin, direction));
    let Some(best) = pick_nearest::run(candidates) else { return Ok(None) };
    let grids: Vec<_> = cloth.grids().iter().map(|g| (g.first, g.width)).collect();
    let mut hit = place(&grids, best.code, best.distance, best.weights);
    let grid = &cloth.grids()[hit.grid];
    let corners = view(positions, &[], grid).quad(hit.texel[0] as usize, hit.texel[1] as usize).1;
    hit.particles = corners[hit.triangle as usize].map(|k| grid.first + k as u32);
    hit.corners = hit.particles.map(|k| crate::number::real::xyz(positions[k as usize]));
    Ok(Some(hit))
}

pub(crate) fn unit(origin: [f32; 3], direction: [f32; 3]) -> Result<[f32; 3]> {
    for x in [origin, direction].as_flattened() {
        check("a number of a ray", f64::from(*x), "finite", |_| true)?;
    }
    let length = direction.iter().map(|x| x.get().powi(2)).sum::<f64>().sqrt();
    check("the length of a ray's direction", length, "above 0", |l| l > 0.0)?;
    Ok(direction.map(|x| (x.get() / length) as f32))
}

fn place(grids: &[(u32, u32)], code: u32, distance: f32, [v, w]: [f32; 2]) -> Hit {
    let k = code / 2;
    let grid = grids.partition_point(|g| g.0 <= k).saturating_sub(1);
    let (first, width) = grids.get(grid).copied().unwrap_or((0, 1));
    let texel = [(k - first) % width, (k - first) / width];
    let barycentric = [1.0 - v - w, v, w];
    Hit {
        cloth: 0,
        handle: None,
        grid,
        texel,
        triangle: code % 2,
        particles: [0; 3],
        barycentric,
        corners: [[0.0; 3]; 3],
        distance,
    }
}
