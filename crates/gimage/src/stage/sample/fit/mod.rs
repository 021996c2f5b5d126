//! Least squares instead of point samples: texels move off the surface so that the triangles between them come closest.
//!
//! All texels, the duplicates of a seam point as one, minimise over the surface S
//! `int_S |X - P|^2 + mu w |dX - dP|^2`, where X is the piecewise linear surface the image stands for (each texel quad
//! split by its shorter diagonal), P the original and d the gradient in texel units. Distance along the surface is not an
//! error, so P and dP slide along it to where X was in the round before (the iterated point-to-plane fit of Chen, Medioni
//! 1992, majorised so that every round is one scalar system); rounds are extrapolated (Nesterov 1983). That lets texels
//! settle on folds. The second term holds the normals; its weight w falls with the angle between X and the surface, so
//! that facets of one plane stay flat although a fold beside them cannot be matched. All integrals are exact: the mesh is
//! clipped against the texel triangles and every term is quadratic on a fragment. Texels of the garment's own boundary do
//! not slide: its curves and corners stay.

mod clip;
mod facet;
mod patch;
mod restrain;

use rayon::prelude::*;

use crate::base::least_squares::{Normal, Part};
use crate::base::vec3::{cross, norm, sub};
use crate::stage::cut::disk::Disk;
use clip::{Cells, MappedDisk, Patches, SLICE, SLICES, clipped, slices};

pub(crate) use clip::clip;
pub(crate) use restrain::restrain;

/// How the texels are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Weight of the gradient term, 0..1; larger keeps normals truer and distance less.
    pub gradient: f64,
    /// How far the target slides along the surface with the fit, 0..1: only the distance across it counts if 1.
    pub slip: f64,
    /// Angle between normals at which the gradient term counts half \[rad\]: folds hold less than flat parts.
    pub sharp: f64,
    /// Rounds of the fit, 1..; more is closer.
    pub rounds: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { gradient: 0.3, slip: 0.9, sharp: 0.05, rounds: 5 }
    }
}

/// How near the solve of a round comes, as a share of where it began: the next round moves the target anyway.
const NEAR: f64 = 0.1;

/// Above this share of the area turned over, that is how the image of a shell thinner than texels looks: nothing is held.
const MOST_TURNED: f64 = 0.005;

/// How firmly the garment's own boundary is held to where it was sampled, as a share of what pulls at it: beyond a
/// boundary there is no surface that would hold it.
const RIM: f64 = 1.0;

/// Structure of the image that the fit keeps.
pub(crate) struct Image<'a> {
    pub columns: usize,
    pub rows: usize,
    /// Texels that are one point: members stay bit-identical.
    pub rings: &'a [Vec<u32>],
    /// Texels on the surface's own boundary: their curves and corners stay.
    pub rim: &'a [bool],
}

/// Moves `points` (row by row) to the least-squares fit. `uv` is the flip-free map in texel units. `false` (and no change)
/// if the solve breaks down. O(triangles + texels) for the integrals, O(texels) for each of some tens of
/// conjugate-gradient steps a round.
pub(crate) fn fit(
    disk: &Disk,
    uv: &[[f64; 2]],
    points: &mut [[f64; 3]],
    image: &Image<'_>,
    options: &FitOptions,
) -> bool {
    let &Image { columns, rows, rings, rim } = image;
    if columns < 3 || rows < 3 {
        return true;
    }
    // Work around the middle of the piece: a garment far from the origin loses nothing.
    let n = disk.positions.len().max(1) as f64;
    let centre = disk.positions.iter().fold([0.0; 3], |m, p| [0, 1, 2].map(|c| m[c] + p[c] / n));
    let mut local: Vec<[f64; 3]> = points.iter().map(|p| sub(*p, centre)).collect();
    let corners = |t: [u32; 3]| t.map(|v| sub(disk.positions[v as usize], centre));
    let area: f64 = disk.triangles.iter().map(|&t| triangle_area(corners(t))).sum();
    let texel = (area / ((columns - 1) * (rows - 1)) as f64).sqrt();
    let mapped = MappedDisk { disk, uv, centre, texel };
    // Texels move little, and with them the diagonals: one clipping serves all rounds.
    let image = Cells { columns, rows: rows - 1, points: &local };
    let patches: Vec<Patches> = slices(disk, uv, rows - 1)
        .par_iter()
        .enumerate()
        .map(|(slice, triangles)| clipped(mapped, triangles, image, slice))
        .collect();
    let (mut all, mut over) = (0.0, 0.0);
    for (patch, parts) in patches.iter().flat_map(Patches::iter) {
        let (area, turned) = patch.turned(parts, &local, columns);
        (all, over) = (all + area, over + turned);
    }
    let hold = over <= MOST_TURNED * all;
    let sampled = local.clone();
    let mut before = local.clone();
    let mut normal = Normal::new(columns, rows, SLICE * SLICES);
    for _ in 0..options.rounds {
        for (x, b) in local.iter_mut().zip(&mut before) {
            let last = *x;
            (0..3).for_each(|c| x[c] += x[c] - b[c]);
            *b = last;
        }
        normal.clear();
        normal.parts().zip(patches.par_chunks(SLICES)).for_each(|(part, band)| {
            pulp::Arch::new().dispatch(Round { part, band, points: &local, rim, options: (options, hold) });
        });
        normal.join();
        normal.hold(rim, &sampled, RIM);
        if !normal.solve(&mut local, rings, NEAR) {
            return false;
        }
    }
    for (p, l) in points.iter_mut().zip(&local) {
        *p = crate::base::vec3::add(*l, centre);
    }
    true
}

fn triangle_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

/// The equations of a band in the widest vectors at hand. The products and sums are the same in all: nothing is fused.
struct Round<'a> {
    part: Part<'a>,
    band: &'a [Patches],
    points: &'a [[f64; 3]],
    rim: &'a [bool],
    options: (&'a FitOptions, bool),
}

impl pulp::NullaryFnOnce for Round<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        for (patch, parts) in self.band.iter().flat_map(Patches::iter) {
            patch.equations(&mut self.part, parts, self.points, self.rim, self.options);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::Grid;
    use crate::base::shapes::{self, Mapped};
    use crate::stage::measure::{MeasureOptions, measure};

    fn points(m: &Mapped) -> Vec<[f64; 3]> {
        m.samples.iter().map(|s| s.position(&m.disk)).collect()
    }

    /// The texels of every surface point that has several.
    fn rings(m: &Mapped) -> Vec<Vec<u32>> {
        let mut of_key = std::collections::BTreeMap::<_, Vec<u32>>::new();
        for (p, t) in m.texels.iter().enumerate() {
            of_key
                .entry(t.key)
                .or_default()
                .push(crate::stage::sample::resample::border_index(p as u32, m.w, m.h) as u32);
        }
        of_key.into_values().filter(|r| r.len() > 1).collect()
    }

    fn fitted(m: &Mapped) -> Vec<[f64; 3]> {
        let mut p = points(m);
        for ring in rings(m) {
            ring.iter().for_each(|&k| p[k as usize] = p[ring[0] as usize]);
        }
        let (columns, rows) = (m.w as usize + 1, m.h as usize + 1);
        let (rings, rim) = (rings(m), vec![false; columns * rows]);
        let image = Image { columns, rows, rings: &rings, rim: &rim };
        assert!(fit(&m.disk, &m.uv, &mut p, &image, &FitOptions::default()));
        p
    }

    #[test]
    fn a_flat_sheet_stays_flat_to_the_last_bit() {
        let m = shapes::mapped(&shapes::rectangle(7, 5, 1.4, 1.0), 20, 14);
        let (a, b) = (points(&m), fitted(&m));
        // In its plane texels may slide where the map bends.
        assert!(a.iter().zip(&b).all(|(p, q)| (p[2] - q[2]).abs() < 1e-12));
    }

    #[test]
    fn a_curved_patch_comes_closer() {
        let ball = shapes::sphere(96, 48);
        let s = shapes::without(&ball, |t| ball.corners(t).iter().any(|p| p[1] < 0.2));
        let m = shapes::mapped(&s, 16, 16);
        let (a, b) = (points(&m), fitted(&m));
        let quality = |p: &[[f64; 3]]| {
            let g = Grid::new(17, 17, p.to_vec());
            let options = MeasureOptions { samples: 20_000, seed: 1 };
            measure(&s.positions, &s.triangles, &g.positions, &g.triangulate(), &options).unwrap().psnr
        };
        assert!(quality(&b) > quality(&a) + 2.0, "{} {}", quality(&a), quality(&b));
    }

    #[test]
    fn duplicates_stay_one_point_to_the_last_bit() {
        let m = shapes::mapped(&shapes::torus(24, 16), 40, 40);
        let (before, after) = (points(&m), fitted(&m));
        let rings = rings(&m);
        assert!(rings.iter().any(|r| r.len() > 2));
        assert!(rings.iter().all(|r| r.iter().all(|&k| after[k as usize] == after[r[0] as usize])));
        assert!(rings.iter().any(|r| before[r[0] as usize] != after[r[0] as usize]), "seams are fitted too");
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let m = shapes::mapped(&shapes::torus(24, 16), 60, 60);
        let run = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| fitted(&m));
        assert_eq!(run(1), run(3));
    }
}
