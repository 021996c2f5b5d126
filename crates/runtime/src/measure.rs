//! Measures of a cloth in motion, in f64, in one pass over the particles.

use crate::cloth::{Cloth, Rest};
use crate::number::real::Real;

/// Figures of one cloth at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Largest |length / rest length - 1| of the springs to the right and down.
    pub stretch_max: f64,
    /// Mean of the same.
    pub stretch_mean: f64,
    /// Kinetic energy \[J\].
    pub kinetic: f64,
    /// Potential energy \[J\] in gravity, 0 at the origin.
    pub potential: f64,
    /// Centre of mass \[m\].
    pub center: [f64; 3],
}

/// Measures positions `now` and `before`, `dt` \[s\] apart, under `gravity` \[m/s^2\]. Particles behind the end of one of the lists are left out. O(n).
pub fn measure<T: Real>(cloth: &Cloth, now: &[[T; 4]], before: &[[T; 4]], dt: f64, gravity: [f32; 3]) -> Measures {
    let at = |k: usize| now[k].map(Real::get);
    let mut out = Measures::default();
    let (mut springs, mut mass) = (0.0, 0.0);
    let there = |k: usize| k < now.len().min(before.len()) && cloth.inverse_mass(k) >= 0.0;
    for (g, grid) in cloth.grids().iter().enumerate() {
        for k in grid.range().filter(|k| there(*k)) {
            let (p, was, m) = (at(k), before[k].map(Real::get), f64::from(cloth.mass(k)));
            let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>();
            out.kinetic += m * sum(&|c| 0.5 * ((p[c] - was[c]) / dt).powi(2));
            out.potential -= m * sum(&|c| f64::from(gravity[c]) * p[c]);
            mass += m;
            (0..3).for_each(|c| out.center[c] += m * p[c]);
            let width = grid.width as usize;
            let (i, local) = ((k - grid.range().start) % width, k - grid.range().start);
            let inside = [i + 1 < width, local + width < grid.texels()];
            for (d, other) in [(0, k + 1), (1, k + width)] {
                let length = f64::from(match cloth.rest() {
                    Rest::None => 0.0,
                    Rest::Constant(r) => r[g][d],
                    Rest::Image(r) => r[k][d],
                });
                if inside[d] && length > 0.0 && there(other) {
                    let q = at(other);
                    let stretch = (sum(&|c| (p[c] - q[c]).powi(2)).sqrt() / length - 1.0).abs();
                    out.stretch_max = out.stretch_max.max(stretch);
                    out.stretch_mean += stretch;
                    springs += 1.0;
                }
            }
        }
    }
    out.stretch_mean /= f64::max(springs, 1.0);
    out.center = out.center.map(|c| c / f64::max(mass, f64::MIN_POSITIVE));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_that_are_too_short_leave_particles_out() {
        let cloth = crate::Flat::square("sheet", 4).cloth().unwrap();
        let all: Vec<[f32; 4]> = cloth.positions().iter().map(|p| [1.1 * p[0], p[1], p[2], 1.0]).collect();
        let of = |now: usize, before: usize| measure(&cloth, &all[..now], &all[..before], 0.01, [0.0, -9.81, 0.0]);
        assert_eq!(of(0, 16), Measures::default());
        assert_eq!(of(16, 0), Measures::default());
        // The first row has springs to the right alone, each a tenth too long.
        let row = of(4, 16);
        assert!((row.stretch_mean - 0.1).abs() < 1e-6 && (row.stretch_max - 0.1).abs() < 1e-6, "{row:?}");
        assert!(of(16, 16).stretch_mean < 0.06);
    }
}
