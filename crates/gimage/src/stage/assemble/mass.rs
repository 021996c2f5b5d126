//! The mass of each particle, lumped from the area of surface that it represents.

use crate::base::grid::Grid;
use crate::base::order::percentile;
use crate::base::vec3::{cross, norm, sub};
use crate::error::{Error, Result};
use crate::options::{Range, stage_options};

stage_options! {
    /// Options of [`mass`].
    #[derive(Copy)]
    pub struct MassOptions of "mass" {
        /// Mass per area of the cloth.
        pub density: f64 = 0.15 => "density" ["kg/m2"] Range::Above(0.0);
    }
}

/// Particle masses \[kg\].
#[derive(Clone, Debug, PartialEq)]
pub enum Masses {
    /// The same at every texel.
    Constant(f32),
    /// One a texel; duplicates carry the mass of the whole surface point, bit-equal.
    Image(Vec<f32>),
}

impl Masses {
    /// The mass of texel `k`; 0 outside of the image.
    pub fn at(&self, k: usize) -> f32 {
        match self {
            Self::Constant(m) => *m,
            Self::Image(image) => image.get(k).copied().unwrap_or_default(),
        }
    }

    /// How evenly mass is spread over the surface points of an image: the 99th percentile over the 1st, 1 if all are
    /// alike. O(n log n).
    pub fn spread(&self, grid: &Grid) -> f64 {
        let representative = grid.representative();
        let points = (0..representative.len()).filter(|&k| representative[k] as usize == k);
        let mut masses: Vec<f32> = points.map(|k| self.at(k)).collect();
        match (percentile(&mut masses, 0.01), percentile(&mut masses, 0.99)) {
            (Some(low), Some(high)) if low > 0.0 => high / low,
            _ => 1.0,
        }
    }
}

/// The lightest and the heaviest particle \[kg\] that 32-bit floats hold with all their digits, and whose inverse is finite.
const RANGE: [f64; 2] = [f32::MIN_POSITIVE as f64, f32::MAX as f64];

/// Whether particles of this mass \[kg\] can be stored; `area` \[m2\] is that of the surface they make up. Errors name what
/// to change.
fn in_range(mass: f64, area: f64, density: f64) -> Result<()> {
    if (RANGE[0]..=RANGE[1]).contains(&mass) {
        return Ok(());
    }
    let [mass, area, density, least, most] = [mass, area, density, RANGE[0], RANGE[1]].map(crate::base::words::number);
    Err(Error::Option {
        option: "density".into(),
        problem: format!(
            "{area} m2 of cloth at {density} kg/m2 has particles of {mass} kg, and 32-bit floats hold {least} to {most} kg"
        ),
        hint: "give the metres in one unit of the file with --unit, or another --density".into(),
    })
}

/// Whether a garment of this area \[m2\] can have masses that are stored, whatever its number of texels: asked before any
/// image is made. Errors where the mean particle is out of range in an image of the fewest texels and of the most.
pub(crate) fn check_mean(area: f64, options: &MassOptions) -> Result<()> {
    let mean = |texels: u32| in_range(area * options.density / f64::from(texels), area, options.density);
    mean(4).or_else(|_| mean(gimage_bundle::MAX_PARTICLES))
}

/// No particle is lighter than this share of the mean: one without an area, where the image has collapsed, would have
/// no finite inverse mass.
const LIGHTEST: f64 = 1e-3;

/// A third of each triangle around a surface point, over all of its duplicates and averaged over both ways to split a
/// quad, since where the diagonals are equally long rounding chooses; scaled so that the masses of all surface points (not
/// of all texels) add to `source_area` \[m2\] times the density; a source area that is not above 0 stands for
/// the image's own. Errors where a density is not above 0, or a mass is not one that 32-bit floats hold.
pub fn mass(grid: &Grid, source_area: f64, options: &MassOptions) -> Result<Masses> {
    options.check()?;
    let positive = |x: f64| x > 0.0 && x.is_finite();
    if !grid.is_sized() || grid.positions.is_empty() {
        return Err(Error::Internal(format!("a grid of {} x {} texels has no masses", grid.width, grid.height)));
    }
    let representative = grid.representative();
    let mut area = vec![0.0; representative.len()];
    let w = grid.width;
    let quads = (0..grid.height.saturating_sub(1)).flat_map(|j| (0..w.saturating_sub(1)).map(move |i| j * w + i));
    for a in quads {
        let [a, b, c, d] = [a, a + 1, a + w + 1, a + w].map(|k| k as u32);
        for t in [[a, b, c], [a, c, d], [a, b, d], [b, c, d]] {
            let [p, q, r] = t.map(|k| grid.stored(k));
            let sixth = norm(cross(sub(q, p), sub(r, p))) / 12.0;
            if sixth.is_finite() {
                t.iter().for_each(|&k| area[representative[k as usize] as usize] += sixth);
            }
        }
    }
    let points: Vec<usize> = (0..area.len()).filter(|&k| representative[k] as usize == k).collect();
    let mean = points.iter().map(|&k| area[k]).sum::<f64>() / points.len() as f64;
    let floor = if positive(mean) { LIGHTEST * mean } else { 1.0 };
    points.iter().for_each(|&k| area[k] = area[k].max(floor));
    let image_area: f64 = points.iter().map(|&k| area[k]).sum();
    let target = if positive(source_area) { source_area } else { image_area };
    let scale = target / image_area * options.density;
    let mean = target * options.density / points.len() as f64;
    let (low, high) = points.iter().fold((mean, mean), |(low, high), &k| {
        let mass = area[k] * scale;
        (low.min(mass), high.max(mass))
    });
    // The mean first: a NaN shows there, and not in the ends.
    for mass in [mean, low, high] {
        in_range(mass, target, options.density)?;
    }
    if points.iter().all(|&k| (area[k] * scale - mean).abs() <= 1e-6 * mean) {
        return Ok(Masses::Constant(mean as f32));
    }
    Ok(Masses::Image(representative.iter().map(|&r| (area[r as usize] * scale) as f32).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::samples::*;
    use proptest::prelude::*;

    fn total(g: &Grid, m: &Masses) -> f64 {
        let r = g.representative();
        (0..r.len()).filter(|&k| r[k] as usize == k).map(|k| f64::from(m.at(k))).sum()
    }

    #[test]
    fn spread_is_of_the_percentiles_over_surface_points() {
        let g = grid(30, 30, |i, j| [i, j, 0.0]);
        assert_eq!(Masses::Constant(2.0).spread(&g), 1.0);
        // 900 points: nine below and nine above are left out.
        let masses = (0..900)
            .map(|k| {
                if k < 9 {
                    1e-6
                } else if k < 891 {
                    1.0 + k as f32 / 890.0
                } else {
                    1e6
                }
            })
            .collect();
        let spread = Masses::Image(masses).spread(&g);
        assert!((1.97..2.0).contains(&spread), "{spread}");
    }

    #[test]
    fn masses_add_to_area_times_density() {
        for g in [grid(6, 5, |u, v| [u, v, u * v]), cylinder(9, 5, 1.0, 2.0), torus(9, 8), sphere(9, 11)] {
            let m = mass(&g, 3.0, &MassOptions { density: 0.2 }).unwrap();
            assert!((total(&g, &m) - 0.6).abs() < 1e-6);
            for ring in g.rings() {
                assert!(ring.iter().all(|&k| m.at(k as usize).to_bits() == m.at(ring[0] as usize).to_bits()));
            }
        }
    }

    #[test]
    fn inside_of_a_flat_rectangle_a_particle_has_one_texel() {
        let g = grid(5, 5, |u, v| [4.0 * u, 4.0 * v, 0.0]);
        let m = mass(&g, 16.0, &MassOptions { density: 1.0 }).unwrap();
        assert!((m.at(12) - 1.0).abs() < 1e-6 && (m.at(2) - 0.5).abs() < 1e-6);
        assert!((m.at(0) - 0.25).abs() < 1e-6 && (m.at(4) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn uniform_masses_are_constant() {
        let g = grid(2, 2, |_, _| [1.0; 3]);
        assert_eq!(mass(&g, 4.0, &MassOptions { density: 1.0 }).unwrap(), Masses::Constant(1.0));
    }

    #[test]
    fn masses_that_round_to_0_or_overflow_are_refused_with_what_to_do() {
        let sheet = |side: f64| grid(5, 5, move |u, v| [side * u, side * v, 0.0]);
        for (side, density) in [(1.0, 1e-300), (1.0, 1e-45), (1e-20, 0.15), (1.0, 1e300), (1e18, 1e30)] {
            let error = mass(&sheet(side), side * side, &MassOptions { density }).unwrap_err().to_string();
            assert!(error.contains("--unit") && error.contains("--density") && error.contains("kg"), "{error}");
            assert!(check_mean(side * side, &MassOptions { density }).is_err(), "{side} {density}");
        }
        // The lightest that is kept is what it should be, and its inverse is finite.
        for density in [1e-35, 1e38] {
            let m = mass(&sheet(1.0), 1.0, &MassOptions { density }).unwrap();
            assert!((total(&sheet(1.0), &m) / density - 1.0).abs() < 1e-6);
            assert!((0..25).all(|k| m.at(k).recip().is_finite()));
        }
        assert!(check_mean(1.0, &MassOptions::default()).is_ok());
    }

    #[test]
    fn bad_input_is_refused() {
        let g = grid(2, 2, |u, v| [u, v, 0.0]);
        for density in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(mass(&g, 1.0, &MassOptions { density }), Err(Error::Option { .. })));
        }
        assert!(mass(&Grid::default(), 1.0, &MassOptions::default()).is_err());
    }

    proptest! {
        #[test]
        fn any_surface_has_positive_masses(z in prop::collection::vec(-1.0..1.0f64, 42), collapsed in 0usize..30) {
            let mut g = grid(7, 6, |u, v| [u, v, 0.0]);
            for (p, z) in g.positions.iter_mut().zip(z) {
                p[2] = z;
            }
            let first = g.positions[0];
            g.positions[..collapsed].fill(first);
            let m = mass(&g, 2.0, &MassOptions::default()).unwrap();
            prop_assert!((0..42).all(|k| m.at(k) > 0.0));
            prop_assert!((total(&g, &m) - 0.3).abs() < 1e-6);
        }
    }
}
