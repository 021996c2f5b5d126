//! The elastic sheet that carries a cloth of a material in place of springs, as [`crate::Material`] makes it.

use super::Cloth;

/// The membrane of a cloth.
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// Two entries a texel, the triangles of the cell of which it is the upper left corner: with `Q` the inverse of the
    /// rest shape (two sides from the first corner as columns, weft and warp as rows \[m\]), its rows one after the other
    /// \[1/m\]; weft is `side Q00 + other side Q10`. 0 means no triangle. Where determinants are above 0 the cell is divided
    /// from upper left to lower right, into upper left, upper right, lower right, and upper left, lower right, lower
    /// left; where they are below 0 all corners are one further on in this circle.
    pub cells: Vec<[f32; 4]>,
    /// One over the stiffness along the weft, along the warp, and in shear \[m/N\].
    pub soft: [f32; 3],
    /// The numbers that it was made of.
    pub woven: Woven,
}

/// The numbers of a material that depend on the grid once they are applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Woven {
    /// Along the warp, along the weft, and in shear \[N/m\].
    pub stiffness: [f64; 3],
    /// \[N m\].
    pub bend: f64,
    /// \[kg/m^2\].
    pub density: f64,
}

/// Bending of a cloth: at each particle the moment `m = sum of weight (x_other - x)` over the eight springs around it,
/// and the energy `m^2 / (2 compliance)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bending {
    /// Weights of the springs stored at a texel: right, down, down-right, up-right. The Laplacian of a linear function is
    /// 0 inside of a flat sheet, however its grid is distorted.
    pub weights: Vec<[f32; 4]>,
    /// Compliance \[m/N\]: area over stiffness. 0 where there is no moment, as on a border. Duplicates hold that of the
    /// whole point.
    pub compliance: Vec<f32>,
}

impl Bending {
    /// For each particle a bound \[1/kg\] on what a multiplier of 1 at all points of the same sign does to the moment
    /// there: with compliance / dt^2 no less than this, no step overshoots.
    pub fn bounds(&self, cloth: &Cloth) -> Vec<f32> {
        let same = cloth.points();
        let mut edges = Vec::with_capacity(4 * self.weights.len());
        for (g, grid) in cloth.grids().iter().enumerate() {
            for local in 0..grid.texels() {
                let k = grid.first as usize + local;
                for d in 0..4 {
                    let weight = f64::from(self.weights[k][d]);
                    if let (Some(other), true) = (cloth.neighbour(g, local, d), weight != 0.0) {
                        edges.push((same[k] as usize, same[other] as usize, weight));
                    }
                }
            }
        }
        // Rows of the Laplacian: the sum of magnitudes off the diagonal, and the diagonal.
        let (mut off, mut diagonal) = (vec![0.0; same.len()], vec![0.0; same.len()]);
        for (a, b, w) in &edges {
            [*a, *b].iter().for_each(|k| (off[*k] += w.abs(), diagonal[*k] += w).0);
        }
        let row: Vec<f64> = off.iter().zip(&diagonal).map(|(o, d): (&f64, &f64)| o + d.abs()).collect();
        let moves = |k: usize| row[k] / f64::from(cloth.mass(k));
        let mut bound: Vec<f64> = diagonal.iter().enumerate().map(|(k, d): (usize, &f64)| d.abs() * moves(k)).collect();
        for (a, b, w) in &edges {
            bound[*a] += w.abs() * moves(*b);
            bound[*b] += w.abs() * moves(*a);
        }
        same.iter().map(|k| bound[*k as usize] as f32).collect()
    }
}

impl Cloth {
    pub(crate) fn membrane(&self) -> Option<&Membrane> {
        self.membrane.as_deref()
    }

    pub(crate) fn bending(&self) -> Option<&Bending> {
        self.bending.as_deref()
    }
}
