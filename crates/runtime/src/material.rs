//! Materials: membrane, bending and masses in physical units, independent of the grid.
//!
//! The membrane is that of D. Baraff, A. Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 98: triangles of constant
//! strain that resist to stretch along the weft, along the warp, and to shear between the two, each by its area
//! (`membrane`). Every cell of the grid is laid out in the plane by its rest lengths and divided along its shorter
//! diagonal (`cell`), so that a distorted grid, a hole or a border changes how exact the sheet is, not how stiff. Springs
//! between neighbours cannot do that: in a cell that is long or skewed no stiffness of them, unless below 0, is that of
//! the sheet. Stretch in one direction takes nothing from the other.
//!
//! Bending is the energy of a thin plate, `bend / 2` times the integral of the squared Laplacian of position, which is
//! quadratic for a sheet that hardly stretches (`plate`): M. Bergou et al., "A Quadratic Bending Model for Inextensible
//! Surfaces", SGP 2006; the Laplacian is that of bilinear finite elements. Masses are lumped from the same cells.
//! Only the sum of the two curvatures counts, which is all there is where cloth keeps its lengths: tension sees to that but
//! for a band along free borders, some millimetres wide, that bends more easily than it should. A coarse grid bends less
//! easily, by some per cent where a fold is ten cells long. Positions are f32: a step should move what falls by more than
//! a unit in the last place, `9.81 dt^2 > 1e-7 |x|`, so cloth in very short steps belongs near the origin.
//!
//! How much fabrics yield is measured by Kawabata's tests; orders of magnitude here follow H. Wang, J. O'Brien,
//! R. Ramamoorthi, "Data-Driven Elastic Models for Cloth", SIGGRAPH 2011, and D. Clyde, J. Teran, R. Tamstorf, "Modeling
//! and Data-Driven Parameter Estimation for Woven Fabrics", SCA 2017.

mod apply;
mod cell;
mod fabric;
mod membrane;
mod plate;

use crate::error::{Result, check};

/// A fabric in physical units. [`crate::Cloth::set_material`] derives masses, a membrane and bending from it;
/// [`crate::Solver::Xpbd`] uses all of them, the classic solver only the masses and the damping.
///
/// With enough steps, motion and rest do not depend on the number of substeps, the step or the grid: for particles at a
/// distance `h`, `dt < h sqrt(density / (2 warp))` and `dt < h^2 sqrt(density / (30 bend))`. With
/// fewer, cloth is softer than it should be, never unstable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Tension along the warp for a strain of 1 \[N/m\]; default 500. Above 0, at most 1e9; larger stretches less. Jersey has 20 to 200, woven cotton 300 to 3000.
    pub warp: f64,
    /// The same along the weft \[N/m\]; default 400.
    pub weft: f64,
    /// Shear stress for a shear angle of 1 \[N/m\]; default 40. Above 0, at most 1e9; larger drapes in fewer folds.
    pub shear: f64,
    /// Bending moment a length for a curvature of 1/m \[N m\]; default 1e-5. At least 0, and 0 costs nothing; larger
    /// makes wider folds. Silk has 1e-6, shirting 1e-5, denim 1e-4, felt 1e-3.
    pub bend: f64,
    /// Mass of an area \[kg/m^2\]; default 0.15. Above 0; shirting has 0.1 to 0.2, denim 0.4.
    pub density: f64,
    /// As [`crate::Cloth::damping`] \[1/s\]; default 0.5. At least 0.
    pub damping: f64,
    /// As [`crate::Cloth::thickness`] \[m\], half the thickness of the fabric; default none: unchanged. 0 to 1. Shirting has
    /// 1e-4, denim 5e-4, felt 2e-3.
    pub thickness: Option<f64>,
    /// As [`crate::Cloth::friction`], a factor; default 1. 0 to 1e6.
    pub friction: f64,
}

impl Default for Material {
    fn default() -> Self {
        Material {
            warp: 500.0,
            weft: 400.0,
            shear: 40.0,
            bend: 1e-5,
            density: 0.15,
            damping: 0.5,
            thickness: None,
            friction: 1.0,
        }
    }
}

impl Material {
    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        check("the stiffness of the warp [N/m]", self.warp, "above 0, at most 1e9", range)?;
        check("the stiffness of the weft [N/m]", self.weft, "above 0, at most 1e9", range)?;
        check("the stiffness in shear [N/m]", self.shear, "above 0, at most 1e9", range)?;
        check("the stiffness in bending [N m]", self.bend, "0 to 1e6", |b| (0.0..=1e6).contains(&b))?;
        check("the density of a cloth [kg/m^2]", self.density, "1e-6 to 1e6", |d| (1e-6..=1e6).contains(&d))?;
        let thickness = self.thickness.unwrap_or(0.0);
        check("the thickness of a cloth [m]", thickness, "0 to 1", |t| (0.0..=1.0).contains(&t))?;
        check("the friction of a cloth", self.friction, "0 to 1e6", |f| (0.0..=1e6).contains(&f))?;
        check("the damping of a cloth [1/s]", self.damping, "at least 0", |d| d >= 0.0)
    }
}

fn range(stiffness: f64) -> bool {
    stiffness > 0.0 && stiffness <= 1e9
}

#[cfg(test)]
#[path = "material/tests.rs"]
mod tests;
