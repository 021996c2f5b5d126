//! A flat rectangle of cloth, which needs no bundle.

use super::{Cloth, Grid, Mass, Particle, Parts, Rest};
use crate::error::{Result, check};
use crate::number::real::{cross, dot};

/// A flat rectangle: texel (i, j) lies at `origin + right i / (width - 1) + down j / (height - 1)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Flat {
    /// A name for messages and dumps.
    pub name: String,
    /// Particles in a row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Where texel (0, 0) lies \[m\].
    pub origin: [f32; 3],
    /// The whole first row as a vector \[m\].
    pub right: [f32; 3],
    /// The whole first column as a vector \[m\].
    pub down: [f32; 3],
    /// Mass of the whole cloth \[kg\], distributed equally.
    pub mass: f32,
}

impl Flat {
    /// A horizontal square of 1 m x 1 m and 0.2 kg with `n` x `n` particles, along x and z from the origin.
    pub fn square(name: &str, n: u32) -> Self {
        let (right, down) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        Flat { name: name.into(), width: n, height: n, origin: [0.0; 3], right, down, mass: 0.2 }
    }

    /// Makes the cloth: structural and shear springs with the spacing of the grid as rest lengths, all particles free.
    /// Errors as [`Cloth::new`], on sides or a mass that are not above 0, and on sides that are parallel.
    pub fn cloth(&self) -> Result<Cloth> {
        let side = |v: [f32; 3]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        check("the side of a flat cloth [m]", side(self.right), "above 0", |s| s > 0.0)?;
        check("the side of a flat cloth [m]", side(self.down), "above 0", |s| s > 0.0)?;
        let (a, b) = (self.right.map(f64::from), self.down.map(f64::from));
        let normal = cross(a, b);
        let sine = dot(normal, normal).sqrt() / (side(self.right) * side(self.down));
        check("the sine of the angle between the sides of a flat cloth", sine, "above 0.001", |s| s > 1e-3)?;
        check("the mass of a flat cloth [kg]", f64::from(self.mass), "above 0", |m| m > 0.0)?;
        let grid = Grid { name: self.name.clone(), first: 0, width: self.width, height: self.height };
        // Refused by `new`, but the lists below must not be made for it.
        let count = if u64::from(self.width) * u64::from(self.height) > u64::from(gimage_bundle::MAX_PARTICLES) {
            0
        } else {
            grid.texels()
        };
        let (across, along) = (f64::from(self.width.max(2)) - 1.0, f64::from(self.height.max(2)) - 1.0);
        let position = |k: usize| {
            let (u, v) = ((k as u32 % self.width) as f64 / across, (k as u32 / self.width) as f64 / along);
            [0, 1, 2].map(|c| {
                let at = f64::from(self.origin[c]) + f64::from(self.right[c]) * u + f64::from(self.down[c]) * v;
                at as f32
            })
        };
        let (dx, dy) = (side(self.right) / across, side(self.down) / along);
        let diagonal = |sign: f64| {
            let step = [0, 1, 2].map(|c| f64::from(self.right[c]) / across + sign * f64::from(self.down[c]) / along);
            step.iter().map(|x| x * x).sum::<f64>().sqrt()
        };
        Cloth::new(Parts {
            name: self.name.clone(),
            positions: (0..count).map(position).collect(),
            particles: vec![Particle::Free { next: None }; count],
            rest: Rest::Constant(vec![[dx as f32, dy as f32, diagonal(1.0) as f32, diagonal(-1.0) as f32]]),
            mass: Mass::Constant((f64::from(self.mass) / count.max(1) as f64) as f32),
            grids: vec![grid],
        })
    }
}
