//! For how many steps the forces of air on triangles stand.
//!
//! They change with the air, which moves with the particles within a frame, and with the velocity and the direction of the triangles, which
//! change little in the time of a short step; and they cost more than all springs of a step.

use super::World;
use crate::cloth::Cloth;
use crate::cpu::body::view;
use crate::cpu::neighbours::View;
use crate::number::real::{cross, dot, sub, with_w};
use crate::options::Solver;
use crate::wind::{Wind, WindForce};

/// Longest time \[s\] and most steps for which forces stand. docs/solvers.md has the error, measured on a flag.
const MAX_S: f64 = 1.0 / 240.0;
const MAX_STEPS: u32 = 8;
/// Share of its velocity against the air that a particle may lose in that time; from 2 on the forces would feed the motion.
const MAX_LOSS: f64 = 0.6;
/// Speed \[m/s\] of cloth that is counted beside that of the wind.
const OWN_SPEED: f64 = 10.0;

impl World {
    /// Steps of a cloth from one with forces of air on triangles to the next. The first step of a frame is one.
    pub fn hold(&self, cloth: usize) -> u32 {
        let Some(wind) = self.scene.wind.filter(|_| self.control.options.solver == Solver::Xpbd) else { return 1 };
        let WindForce::Triangles { density, drag, lift } = wind.force else { return 1 };
        let exposed = *self.runs[cloth].exposed.get_or_init(|| exposed(&self.scene.cloths[cloth]));
        let pressure = 0.5 * f64::from(density) * f64::from(drag + lift) * (speed(&wind) + OWN_SPEED);
        steps(self.control.clock.dt, pressure * exposed)
    }
}

/// Steps of `dt` \[s\] for cloth that air slows at a rate \[1/s\].
fn steps(dt: f64, rate: f64) -> u32 {
    let longest = MAX_S.min(MAX_LOSS / rate);
    // Rounding must not decide.
    ((longest / dt * (1.0 + 1e-9)) as u32).clamp(1, MAX_STEPS)
}

fn speed(wind: &Wind) -> f64 {
    wind.velocity.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt()
}

/// The largest area of a particle over its mass \[m^2/kg\], pinned particles included: they may be freed.
fn exposed(cloth: &Cloth) -> f64 {
    let weight = |k: usize| if cloth.particles()[k].exists() { 1.0 / cloth.mass(k) } else { -1.0 };
    let texel = |k: usize| with_w(cloth.positions()[k], weight(k));
    let now: Vec<[f32; 4]> = (0..cloth.len()).map(texel).collect();
    let mut most = 0.0f64;
    for grid in cloth.grids() {
        let view = view(&now, &[], grid);
        for (j, i) in (0..grid.height as usize).flat_map(|j| (0..grid.width as usize).map(move |i| (j, i))) {
            most = most.max(area(view, i, j) / 3.0 * f64::from(view.now[j * view.width + i][3]));
        }
    }
    most
}

/// Area \[m^2\] of the triangles of a particle.
fn area(view: View<f32>, i: usize, j: usize) -> f64 {
    let k = j * view.width + i;
    let mut sum = 0.0;
    if view.now[k][3] > 0.0 {
        let at = view.at(k);
        view.triangles(i, j, |a, b| {
            let normal = cross(sub(view.at(a), at), sub(view.at(b), at));
            sum += 0.5 * f64::from(dot(normal, normal)).sqrt();
        });
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn forces_stand_for_a_short_time_and_less_on_light_cloth() {
        // 60 frames per second.
        let dt = |substeps: u32| 1.0 / f64::from(60 * substeps);
        for (substeps, expected) in [(1, 1), (7, 1), (8, 2), (15, 3), (16, 4), (24, 6), (32, 8), (1000, 8)] {
            assert_eq!(steps(dt(substeps), 50.0), expected, "{substeps}");
            assert_eq!(steps(dt(substeps), 0.0), expected, "{substeps}");
        }
        assert_eq!(steps(dt(24), 250.0), 3);
        assert_eq!(steps(dt(24), 600.0), 1);
        assert_eq!(steps(dt(96), 250.0), 8);
        assert_eq!(steps(dt(24), f64::INFINITY), 1);
    }

    #[test]
    fn exposure_is_area_by_mass() {
        let mut cloth = builtin("s1", 9).unwrap().cloths.remove(0);
        let at = |k: usize| cloth.positions()[k];
        let side = |a: usize, b: usize| {
            let d = sub(at(b), at(a));
            f64::from(dot(d, d)).sqrt()
        };
        // In the middle a third of six triangles, each half a cell; all masses are the same.
        let expected = side(40, 41) * side(40, 49) / f64::from(cloth.mass(40));
        assert!((exposed(&cloth) / expected - 1.0).abs() < 1e-5, "{} {expected}", exposed(&cloth));
        let free = exposed(&cloth);
        (0..81).for_each(|k| cloth.set_pinned(k, true).unwrap());
        assert_eq!(exposed(&cloth), free);
    }
}
