//! Closed tubes.

use std::f32::consts::TAU;

use gimage_runtime::{Cloth, Grid, Mass, Particle, Parts, Rest};

use super::Failure;

/// A tube around y, from y = 0 down, with its front outside.
pub struct Tube<'a> {
    pub name: &'a str,
    /// Particles around; the last column has the duplicates of the first one.
    pub around: u32,
    pub rows: u32,
    /// Half axes along x and z \[m\].
    pub radii: [f32; 2],
    /// \[m\]
    pub length: f32,
}

/// Makes its cloth, of 0.2 kg/m2, with springs as long as at the start.
pub fn tube(of: &Tube) -> Result<Cloth, Failure> {
    let Tube { around, rows, radii, length, .. } = *of;
    let (mut positions, mut particles) = (Vec::new(), Vec::new());
    for j in 0..rows {
        for i in 0..around {
            let (s, c) = (TAU * (i % (around - 1)) as f32 / (around - 1) as f32).sin_cos();
            positions.push([radii[0] * c, -length * j as f32 / (rows - 1) as f32, radii[1] * s]);
            let next = if i == 0 { Some((j + 1) * around - 1) } else { (i == around - 1).then_some(j * around) };
            particles.push(Particle::Free { next });
        }
    }
    let rest = (0..around * rows).map(|k| {
        let (i, j) = (k % around, k / around);
        let to = |there: bool, other: u32| {
            let (a, b) = (positions[k as usize], if there { positions[other as usize] } else { positions[k as usize] });
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
        };
        let (right, down) = (i + 1 < around, j + 1 < rows);
        [
            to(right, k + 1),
            to(down, k + around),
            to(right && down, k + around + 1),
            to(right && j > 0, (k + 1).saturating_sub(around)),
        ]
    });
    let rest = Rest::Image(rest.collect());
    let grids = vec![Grid { name: of.name.into(), first: 0, width: around, height: rows }];
    let mass = Mass::Constant(0.2 * TAU * (radii[0] + radii[1]) / 2.0 * length / (around * rows) as f32);
    Ok(Cloth::new(Parts { name: of.name.into(), grids, positions, particles, rest, mass })?)
}
