//! Moves a solid so that its surface lies nearest to samples, by the method of Levenberg and Marquardt.

use nalgebra::{DMatrix, DVector};

use super::samples::Sample;
use super::shape::{Kind, Shape, guess};
use super::solid::Solid;

/// Step of the differences that stand for derivatives, as a share of the size of the points.
const STEP: f64 = 1e-6;
/// A step that brings less than this share is the last one.
const GAIN: f64 = 1e-4;

/// The solid of one of `kinds` with the least errors at the samples, in the sense of least squares; none without samples of the
/// surface.
pub(super) fn best(kinds: &[Kind], samples: &[Sample]) -> Option<Solid> {
    let surface: Vec<_> = samples.iter().filter(|s| s.is_on_surface()).map(|s| s.point).collect();
    let fits = kinds.iter().filter_map(|kind| {
        let solid = refined(&guess(*kind, &surface)?, samples, 40);
        Some((kind.handicap() * error(&solid, samples), solid))
    });
    fits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, solid)| solid)
}

/// Root of the mean square error at the samples \[m\].
pub(super) fn error(solid: &Solid, samples: &[Sample]) -> f64 {
    let mut errors = Vec::new();
    errors_at(&Shape::of(solid), samples, &mut errors);
    (square(&errors) / samples.len().max(1) as f64).sqrt()
}

fn errors_at(shape: &Shape, samples: &[Sample], out: &mut Vec<f64>) {
    shape.distances(samples, out);
    out.iter_mut().zip(samples).for_each(|(d, s)| *d = s.error(*d));
}

fn square(errors: &[f64]) -> f64 {
    errors.iter().map(|d| d * d).sum()
}

/// The solid after at most `rounds` steps. Its sum of squares never grows. O(rounds x samples x numbers^2).
pub(super) fn refined(solid: &Solid, samples: &[Sample], rounds: usize) -> Solid {
    let mut shape = Shape::of(solid);
    let (mut now, mut moved) = (Vec::new(), Vec::new());
    errors_at(&shape, samples, &mut now);
    let size = extent(samples);
    let mut damping = 1e-3;
    if samples.is_empty() || size <= 0.0 || !square(&now).is_finite() {
        return *solid;
    }
    for _ in 0..rounds {
        let (gradient, normal) = normal_equations(&shape, samples, &now, size);
        let mut gained = None;
        while gained.is_none() && damping < 1e9 {
            let mut damped = normal.clone();
            (0..damped.nrows()).for_each(|k| damped[(k, k)] += damping * (normal[(k, k)] + 1e-9 * normal.trace()));
            let step = damped.cholesky().map(|c| c.solve(&-&gradient));
            let mut next = shape.clone();
            step.iter().flat_map(|s| s.iter()).zip(&mut next.numbers).for_each(|(s, x)| *x += s);
            errors_at(&next, samples, &mut moved);
            let (before, after) = (square(&now), square(&moved));
            if step.is_some() && after < before {
                gained = Some(1.0 - after / before);
                // From here on rotations are small again.
                shape = Shape::of(&next.solid());
                damping = (damping * 0.2).max(1e-9);
            } else {
                damping *= 5.0;
            }
        }
        errors_at(&shape, samples, &mut now);
        if gained.is_none_or(|g| g < GAIN) {
            break;
        }
    }
    shape.solid()
}

fn normal_equations(shape: &Shape, samples: &[Sample], now: &[f64], size: f64) -> (DVector<f64>, DMatrix<f64>) {
    let count = shape.numbers.len();
    let mut slopes = DMatrix::zeros(samples.len(), count);
    let mut moved = Vec::new();
    for k in 0..count {
        // A centre is a length; rotations and logarithms have none.
        let step = if k < 3 { STEP * size } else { STEP };
        let mut other = shape.clone();
        other.numbers[k] += step;
        errors_at(&other, samples, &mut moved);
        moved.iter().zip(now).enumerate().for_each(|(i, (m, n))| slopes[(i, k)] = (m - n) / step);
    }
    let residual = DVector::from_column_slice(now);
    (slopes.tr_mul(&residual), slopes.tr_mul(&slopes))
}

fn extent(samples: &[Sample]) -> f64 {
    let side = |k: usize| {
        let all = || samples.iter().map(|s| s.point[k]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}
