//! From a material to the numbers of a cloth.

use std::sync::Arc;

use super::Material;
use super::cell::{Cell, P2, cells, cross, sub};
use super::membrane::triangles;
use super::plate::Plate;
use crate::cloth::{Cloth, Membrane, Woven};
use crate::error::{Result, check};

/// A particle is no lighter than this share of the mean: one without an area would have no finite inverse mass.
const LIGHTEST: f64 = 1e-3;

impl Cloth {
    /// Makes the cloth of a material: masses, damping, friction, the membrane and bending come from it, and thickness where
    /// it has one. The rest shape is that of the rest lengths, and flat: a garment bends from panels that lie on a table, also across its
    /// seams. The warp runs along v of the texture coordinates where the cloth has any ([`Cloth::set_grain`]), else
    /// along the columns of the grid.
    ///
    /// Costs about a microsecond per particle. Its settings may be changed afterwards; rest lengths may not. Errors on
    /// numbers out of range.
    pub fn set_material(&mut self, material: &Material) -> Result<()> {
        material.check()?;
        let same = self.points();
        let mut plate = Plate::new(self.len());
        let mut membrane = vec![[0.0; 4]; 2 * self.len()];
        for grid in 0..self.grids().len() {
            let all: Vec<Cell> = cells(self, grid, &same).collect();
            let usual = self.grain().map_or(0.0, |uv| usual_scale(&all, uv));
            for cell in &all {
                let warp = self.grain().and_then(|uv| warp_by(cell, uv, usual));
                let [c, s] = cell.axes();
                let k = 2 * cell.corners[0];
                membrane[k..k + 2].copy_from_slice(&triangles(cell, warp.unwrap_or([-s, c])));
                plate.add(cell, &same);
            }
        }
        self.set_masses(masses(&plate, self, &same, material.density)?)?;
        let soft = [material.weft, material.warp, material.shear].map(|k| (1.0 / k) as f32);
        let Material { warp, weft, shear, bend, density, .. } = *material;
        let woven = Woven { stiffness: [warp, weft, shear], bend, density };
        self.membrane = Some(Arc::new(Membrane { cells: membrane, soft, woven }));
        self.damping = material.damping as f32;
        self.thickness = material.thickness.map(|t| t as f32).or(self.thickness);
        self.friction = material.friction as f32;
        self.exact = true;
        self.bending = (material.bend > 0.0).then(|| Arc::new(plate.bending(&same, material.bend)));
        Ok(())
    }

    /// Gives every texel texture coordinates that run along the fabric: v along the warp, u across it. `None`: the
    /// columns of the grid are the warp. Errors unless there is one for each texel. To be called before
    /// [`Cloth::set_material`]; the first texture coordinates of a bundle are taken over.
    pub fn set_grain(&mut self, uv: Option<Vec<[f32; 2]>>) -> Result<()> {
        if let Some(uv) = &uv {
            let whole = |n: f64| n == self.len() as f64;
            check("the number of texture coordinates", uv.len() as f64, "one per texel", whole)?;
        }
        self.keep_grain(uv);
        Ok(())
    }
}

fn masses(plate: &Plate, cloth: &Cloth, same: &[u32], density: f64) -> Result<Vec<f32>> {
    let points = (0..same.len()).filter(|k| same[*k] as usize == *k && cloth.particles()[*k].exists());
    let (count, sum) = points.fold((0usize, 0.0), |(n, sum), k| (n + 1, sum + plate.area[k]));
    check("the area of a cloth that gets a material [m^2]", sum, "above 0; give it rest lengths", |a| a > 0.0)?;
    let least = LIGHTEST * sum / count as f64;
    Ok(same.iter().map(|k| (plate.area[*k as usize].max(least) * density) as f32).collect())
}

/// Texture coordinates of a cell as two steps, and the same steps in the plane.
fn steps(cell: &Cell, uv: &[[f32; 2]]) -> ([P2; 2], [P2; 2]) {
    let k: Vec<usize> = cell.around().collect();
    let at = |k: usize| uv[cell.corners[k]].map(f64::from);
    // Diagonals of four corners, sides of three.
    let [a, b, c, d] = if k.len() == 4 { [k[2], k[0], k[3], k[1]] } else { [k[1], k[0], k[2], k[0]] };
    ([sub(at(a), at(b)), sub(at(c), at(d))], [sub(cell.at[a], cell.at[b]), sub(cell.at[c], cell.at[d])])
}

/// The median of texture areas against areas.
fn usual_scale(all: &[Cell], uv: &[[f32; 2]]) -> f64 {
    let mut scales: Vec<f64> = (all.iter())
        .map(|cell| {
            let (u, x) = steps(cell, uv);
            (cross(u[0], u[1]) / cross(x[0], x[1])).abs()
        })
        .collect();
    scales.sort_by(f64::total_cmp);
    scales.get(scales.len() / 2).copied().unwrap_or(0.0)
}

/// The direction of v in the plane of a cell; none where texture coordinates jump inside of it or tell nothing.
fn warp_by(cell: &Cell, uv: &[[f32; 2]], usual: f64) -> Option<P2> {
    let (u, x) = steps(cell, uv);
    let det = cross(u[0], u[1]);
    let scale = (det / cross(x[0], x[1])).abs();
    if !(scale > 0.25 * usual && scale < 4.0 * usual) {
        return None;
    }
    // A step along v is this much of either step: u must come to 0.
    let (p, q) = (-u[1][0] / det, u[0][0] / det);
    let along = [p * x[0][0] + q * x[1][0], p * x[0][1] + q * x[1][1]];
    let size = along[0].hypot(along[1]);
    let stretched = size * size * usual;
    (0.1..10.0).contains(&stretched).then(|| [along[0] / size, along[1] / size])
}
