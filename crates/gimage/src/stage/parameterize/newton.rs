//! Projected Newton on the symmetric Dirichlet energy, boundary fixed, no flips.
//!
//! Per-triangle Hessians are made positive semi-definite with their closed-form eigensystem (Smith, de Goes, Kim 2019,
//! "Analytic Eigensystems for Isotropic Distortion Energies"); the step is cut to 90 % of the first flip
//! (Smith, Schaefer 2015) and then by Armijo's rule. One symbolic factorisation serves all steps.

use rayon::prelude::*;

use super::distortion::{CHUNK, Rest, energy, jacobian, planar};
use super::system::System;

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Largest number of steps; 0..; more is closer to the minimum.
    pub steps: usize,
    /// Work past `steps`, in steps times triangles; it is spent only while a step lowers the energy by over 1 % of what it
    /// is above an isometry's.
    pub further: u64,
    /// Stop when a step lowers the energy by less than this share of what it is above an isometry's; larger stops sooner.
    pub tolerance: f64,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { steps: 60, further: 2_000_000, tolerance: 1e-5 }
    }
}

/// Record of the minimiser's work. Energies are NaN where no step was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonRecord {
    /// Steps taken.
    pub steps: usize,
    /// Mean energy before, 4 = isometry.
    pub start: f64,
    /// Mean energy after.
    pub end: f64,
    /// It ended because a step was small enough, not because the steps ran out or no descent was found.
    pub converged: bool,
    /// It ended at the cap of work while the energy still fell by over 1 % a step.
    pub capped: bool,
}

/// A step that lowers the energy by more than this share of what it is above an isometry's is worth another.
const FALLING: f64 = 0.01;

/// The energy of one triangle to second order, the Hessian projected, in blocks of 2 x 2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// For each corner.
    pub gradient: [[f64; 2]; 3],
    /// For each corner with itself.
    pub own: [[f64; 4]; 3],
    /// Rows of the first and columns of the second of the corners (0, 1), (0, 2), (1, 2).
    pub pair: [[f64; 4]; 3],
}

/// [`Local`] of a triangle whose corners are at `p`.
#[inline]
pub(super) fn local(rest: &Rest, p: [[f64; 2]; 3]) -> Local {
    let j = jacobian(rest, p);
    // J is a scaled rotation plus a scaled reflection (half-sums and half-differences): s1, s2 = q +- r, and both parts
    // share the singular vectors, so that the modes need no angles.
    let (e, f, g, h) = ((j[0] + j[3]) * 0.5, (j[0] - j[3]) * 0.5, (j[2] + j[1]) * 0.5, (j[2] - j[1]) * 0.5);
    let (q, r) = ((e * e + h * h).sqrt(), (f * f + g * g).sqrt());
    let det = j[0] * j[3] - j[1] * j[2];
    let s1 = q + r;
    let s2 = det / s1;
    let (e, h) = (e / q, h / q);
    let (f, g) = if r > 0.0 { (f / r, g / r) } else { (1.0, 0.0) };
    let w = 2.0 * rest.weight;
    let (i1, i2) = (1.0 / s1, 1.0 / s2);
    let (c1, c2) = (i1 * i1 * i1, i2 * i2 * i2);
    let (d1, d2) = (s1 - c1, s2 - c2);
    // Eigenvalues: the two scalings, the twist (the only one that can be negative), the flip.
    let lambda = [1.0 + 3.0 * c1 * i1, 1.0 + 3.0 * c2 * i2, ((d1 + d2) / (s1 + s2)).max(0.0), {
        1.0 + (s1 * s1 + s1 * s2 + s2 * s2) * c1 * c2
    }];
    // U diag(1, 0) V^T, U diag(0, 1) V^T, and the antisymmetric and symmetric mixes of the two, of unit norm.
    const R: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let modes = [
        [0.5 * (e + f), 0.5 * (g - h), 0.5 * (h + g), 0.5 * (e - f)],
        [0.5 * (e - f), 0.5 * (-h - g), 0.5 * (h - g), 0.5 * (e + f)],
        [-h * R, -e * R, e * R, -h * R],
        [-g * R, f * R, f * R, g * R],
    ];
    // Each mode pulled back to the corners: (mode g_k), a 2-vector for each corner.
    let pull = |m: [f64; 4], g: [f64; 2]| [m[0] * g[0] + m[1] * g[1], m[2] * g[0] + m[3] * g[1]];
    let mut gradient = [[0.0; 2]; 3];
    let mut pulled = [[[0.0; 2]; 3]; 4];
    for k in 0..3 {
        for m in 0..4 {
            pulled[m][k] = pull(modes[m], rest.g[k]);
        }
        for c in 0..2 {
            gradient[k][c] = w * (d1 * pulled[0][k][c] + d2 * pulled[1][k][c]);
        }
    }
    let scaled: [_; 4] = std::array::from_fn(|m| pulled[m].map(|p| p.map(|x| w * lambda[m] * x)));
    let block = |a: usize, b: usize| {
        let mut block = [0.0; 4];
        for m in 0..4 {
            let (x, y) = (scaled[m][a], pulled[m][b]);
            block[0] += x[0] * y[0];
            block[1] += x[0] * y[1];
            block[2] += x[1] * y[0];
            block[3] += x[1] * y[1];
        }
        block
    };
    Local { gradient, own: [block(0, 0), block(1, 1), block(2, 2)], pair: [block(0, 1), block(0, 2), block(1, 2)] }
}

/// The largest step along `d` before a triangle loses its area.
fn step_to_flip(triangles: &[[u32; 3]], uv: &[[f64; 2]], d: &[[f64; 2]]) -> f64 {
    triangles
        .par_chunks(CHUNK)
        .map(|chunk| {
            chunk.iter().fold(f64::INFINITY, |best, &t| {
                let (p, q) = (planar(uv, t), planar(d, t));
                let e = |x: [[f64; 2]; 3], k: usize| [x[k][0] - x[0][0], x[k][1] - x[0][1]];
                let (u1, u2, v1, v2) = (e(p, 1), e(p, 2), e(q, 1), e(q, 2));
                let c0 = u1[0] * u2[1] - u1[1] * u2[0];
                let c1 = u1[0] * v2[1] - u1[1] * v2[0] + v1[0] * u2[1] - v1[1] * u2[0];
                let c2 = v1[0] * v2[1] - v1[1] * v2[0];
                let discriminant = c1 * c1 - 4.0 * c2 * c0;
                if discriminant < 0.0 {
                    return best;
                }
                let q = -0.5 * (c1 + discriminant.sqrt().copysign(c1));
                [q / c2, c0 / q].into_iter().filter(|t| *t > 0.0).fold(best, f64::min)
            })
        })
        .reduce(|| f64::INFINITY, f64::min)
}

/// Minimises the mean symmetric Dirichlet energy over the vertices that `system` leaves free, from a flip-free `uv`.
/// Every accepted step lowers the energy and keeps all triangles positively oriented, so `uv` is flip-free on return.
pub(crate) fn minimise(
    system: &mut System,
    rest: &[Rest],
    triangles: &[[u32; 3]],
    uv: &mut Vec<[f64; 2]>,
    options: &NewtonOptions,
) -> NewtonRecord {
    if options.steps == 0 {
        return NewtonRecord { steps: 0, start: f64::NAN, end: f64::NAN, converged: false, capped: false };
    }
    let mut now = energy(rest, triangles, uv);
    // The energy of an isometry: a flat piece must get there, not only near it.
    let least: f64 = 4.0 * rest.iter().map(|r| r.weight).sum::<f64>();
    let mut record = NewtonRecord { steps: 0, start: now, end: now, converged: false, capped: false };
    if !now.is_finite() || system.unknowns() == 0 {
        record.converged = now.is_finite();
        return record;
    }
    let mut last_gain = 0.0;
    loop {
        if record.steps >= options.steps {
            let further = (record.steps - options.steps) as u64 * triangles.len() as u64;
            record.capped = last_gain > FALLING && further >= options.further && options.further > 0;
            if last_gain <= FALLING || further >= options.further {
                break;
            }
        }
        let found = if triangles.len() > CHUNK {
            let locals: Vec<_> =
                rest.par_iter().zip(triangles).with_min_len(CHUNK).map(|(r, &t)| local(r, planar(uv, t))).collect();
            system.newton_direction(locals.into_iter())
        } else {
            system.newton_direction(rest.iter().zip(triangles).map(|(r, &t)| local(r, planar(uv, t))))
        };
        let Some((direction, slope)) = found else {
            // At an isometry there is no direction to go.
            record.converged = now - least <= 1e-12 * least;
            break;
        };
        let mut step = (0.9 * step_to_flip(triangles, uv, &direction)).min(1.0);
        let mut next = None;
        for _ in 0..40 {
            let trial: Vec<[f64; 2]> =
                uv.iter().zip(&direction).map(|(p, d)| [p[0] + step * d[0], p[1] + step * d[1]]).collect();
            let e = energy(rest, triangles, &trial);
            if e <= now + 1e-4 * step * slope && super::distortion::flips(triangles, &trial) == 0 {
                next = Some((trial, e));
                break;
            }
            step *= 0.5;
        }
        let Some((trial, e)) = next else {
            // No descent left in f64: at the minimum for all that can be told.
            record.converged = slope.abs() < 1e-6 * now;
            break;
        };
        *uv = trial;
        record.steps += 1;
        record.end = e;
        let gain = (now - e) / (now - least).max(1e-14 * now);
        now = e;
        // Near the minimum steps converge quadratically: while they do, the last digits cost next to nothing.
        let quadratic = gain < 0.02 * last_gain && gain > 1e-13;
        if gain < options.tolerance && step > 0.3 && !quadratic {
            record.converged = true;
            break;
        }
        last_gain = gain;
    }
    record
}

#[cfg(test)]
mod tests {
    use super::super::distortion::density;
    use super::*;
    use proptest::prelude::*;

    fn energy_of(rest: &Rest, p: [[f64; 2]; 3]) -> f64 {
        rest.weight * density(jacobian(rest, p))
    }

    #[test]
    fn an_isometry_is_the_end_whether_or_not_rounding_leaves_a_direction() {
        for cells in [2, 3, 7] {
            let s = crate::base::shapes::rectangle(cells, cells, 1.0, 1.0);
            let at = |x: f64| x <= 1e-9 || x >= 1.0 - 1e-9;
            let mut uv: Vec<[f64; 2]> = s.positions.iter().map(|p| [p[0], p[1]]).collect();
            let fixed: Vec<bool> = uv.iter().map(|p| at(p[0]) || at(p[1])).collect();
            let ones = vec![1.0; uv.len()];
            let rest = super::super::distortion::rest_shapes(&s.positions, &s.triangles, &ones, 1.0);
            let mut system = System::new(&s.triangles, &fixed);
            let options = NewtonOptions::default();
            let record = minimise(&mut system, &rest, &s.triangles, &mut uv, &options);
            assert!(record.converged && (record.end - 4.0).abs() < 1e-9, "{cells}: {record:?}");
        }
    }

    #[test]
    fn steps_go_on_past_their_number_while_the_energy_falls() {
        let s = crate::base::shapes::rectangle(8, 8, 1.0, 1.0);
        let fixed = crate::base::shapes::rim(&s);
        // All that is inside lies in a billionth of the middle: some 70 steps, each 9/16 of the energy of the last.
        let place = |(p, f): (&[f64; 3], &bool)| {
            let by = if *f { 1.0 } else { 1e-9 };
            [0.45 + by * (p[0] - 0.45), 0.45 + by * (p[1] - 0.45)]
        };
        let crushed: Vec<[f64; 2]> = s.positions.iter().zip(&fixed).map(place).collect();
        let rest = super::super::distortion::rest_shapes(&s.positions, &s.triangles, &vec![1.0; crushed.len()], 1.0);
        let run = |further: u64| {
            let mut uv = crushed.clone();
            let options = NewtonOptions { steps: 20, further, ..NewtonOptions::default() };
            minimise(&mut System::new(&s.triangles, &fixed), &rest, &s.triangles, &mut uv, &options)
        };
        let all = run(2_000_000);
        assert!(all.start > 1e12 && all.steps > 20 && all.converged && !all.capped, "{all:?}");
        assert!(all.end < 4.001, "{all:?}");
        let capped = run(10 * s.triangles.len() as u64);
        assert!(capped.steps == 30 && capped.capped && !capped.converged, "{capped:?}");
        let none = run(0);
        assert!(none.steps == 20 && !none.converged, "{none:?}");
    }

    proptest! {
        #[test]
        fn gradient_and_hessian_agree_with_differences(v in proptest::collection::vec(-1.0f64..1.0, 6)) {
            let rest = Rest { g: [[-0.9, -0.6], [1.0, -0.4], [-0.1, 1.0]], weight: 0.7 };
            let base = [[0.0, 0.0], [1.0, 0.1], [0.4, 0.9]];
            let mut p = base;
            for k in 0..3 { for c in 0..2 { p[k][c] += 0.2 * v[2 * k + c]; } }
            prop_assume!(density(jacobian(&rest, p)).is_finite() && density(jacobian(&rest, p)) < 100.0);
            let Local { gradient: g, own, pair } = local(&rest, p);
            let block = |a: usize, b: usize| if a == b { own[a] } else { pair[a + b - 1] };
            let h = |a: usize, b: usize, m: usize, n: usize| {
                block(a, b)[if a <= b { 2 * m + n } else { 2 * n + m }]
            };
            let eps = 1e-5;
            for k in 0..3 { for c in 0..2 {
                let (mut a, mut b) = (p, p);
                a[k][c] += eps;
                b[k][c] -= eps;
                let d = (energy_of(&rest, a) - energy_of(&rest, b)) / (2.0 * eps);
                prop_assert!((d - g[k][c]).abs() < 1e-5 * (1.0 + d.abs()), "{} {}", d, g[k][c]);
                // Where the twist is not clamped the Hessian is exact.
                let j = jacobian(&rest, p);
                let (n2, det) = (j.iter().map(|x| x * x).sum::<f64>(), j[0] * j[3] - j[1] * j[2]);
                let (sum, prod) = ((n2 + 2.0 * det).sqrt(), det);
                let twist = 1.0 - (sum * sum - 3.0 * prod) / (prod * prod * prod) ;
                if twist > 1e-3 {
                    let (ga, gb) = (local(&rest, a).gradient, local(&rest, b).gradient);
                    for m in 0..3 { for n in 0..2 {
                        let d2 = (ga[m][n] - gb[m][n]) / (2.0 * eps);
                        let h = h(m, k, n, c);
                        prop_assert!((d2 - h).abs() < 1e-3 * (1.0 + d2.abs()), "{} {}", d2, h);
                    }}
                }
            }}
        }
    }
}
