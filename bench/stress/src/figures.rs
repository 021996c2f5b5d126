//! Figures measured of a cloth, in f64.

use gimage_runtime::{Cloth, Compliance, Rest};

pub type V3 = [f64; 3];

/// Masses and springs of a cloth of one grid, ready to be measured often.
pub struct Gauge {
    pub mass: Vec<f64>,
    free: Vec<bool>,
    /// Ends, rest length \[m\], compliance \[m/N\]; the structural ones first.
    springs: Vec<(usize, usize, f64, f64)>,
    structural: usize,
    /// Of each structural spring the longest structural one at its ends \[m\].
    longest: Vec<f64>,
    gravity: V3,
    /// Weight times the longer side \[J\].
    pub scale: f64,
}

impl Gauge {
    pub fn new(cloth: &Cloth, gravity: [f32; 3]) -> Self {
        let width = cloth.grids()[0].width as usize;
        let length = |k: usize, d: usize| match cloth.rest() {
            Rest::None => 0.0,
            Rest::Constant(r) => f64::from(r[0][d]),
            Rest::Image(r) => f64::from(r[k][d]),
        };
        let soft = |k: usize, d: usize| match &cloth.compliance {
            Compliance::None => 0.0,
            Compliance::Constant(c) => f64::from(*c),
            Compliance::Image(c) => f64::from(c[k][d]),
        };
        let mut springs = Vec::new();
        for d in 0..4 {
            for k in 0..cloth.len() {
                let (right, down, up) = (k % width + 1 < width, k + width < cloth.len(), k >= width);
                let other = match d {
                    0 if right => k + 1,
                    1 if down => k + width,
                    2 if right && down => k + width + 1,
                    3 if right && up => k + 1 - width,
                    _ => continue,
                };
                if length(k, d) > 0.0 {
                    springs.push((k, other, length(k, d), soft(k, d)));
                }
            }
        }
        let structural = springs.iter().filter(|(a, b, ..)| b - a.min(b) == 1 || b - a.min(b) == width).count();
        let mut around = vec![0f64; cloth.len()];
        for &(a, b, rest, _) in &springs[..structural] {
            (around[a], around[b]) = (around[a].max(rest), around[b].max(rest));
        }
        let longest = springs[..structural].iter().map(|&(a, b, ..)| around[a].max(around[b])).collect();
        let mass: Vec<f64> = (0..cloth.len()).map(|k| f64::from(cloth.mass(k))).collect();
        let free: Vec<bool> = (0..cloth.len()).map(|k| cloth.inverse_mass(k) > 0.0).collect();
        let gravity = gravity.map(f64::from);
        let weight = free.iter().zip(&mass).filter(|m| *m.0).map(|m| m.1).sum::<f64>() * norm(gravity);
        let side: f64 = springs.iter().filter(|s| s.0 < width && s.1 == s.0 + 1).map(|s| s.2).sum();
        Gauge { mass, free, springs, structural, longest, gravity, scale: weight * side }
    }

    /// Of the structural springs the length / rest length - 1 that is farthest from 0, with its sign.
    pub fn stretch(&self, p: &[V3]) -> f64 {
        let of = |(a, b, rest, _): &(usize, usize, f64, f64)| distance(p[*a], p[*b]) / rest - 1.0;
        let farther = |a: f64, b: f64| if b.abs() > a.abs() || b.is_nan() { b } else { a };
        self.springs[..self.structural].iter().map(of).fold(0.0, farther)
    }

    /// As [`Gauge::stretch`], but a difference in length is put in proportion to the longest spring at either end, where
    /// that is longer: a fine spring between coarse ones is held no better than they are.
    pub fn stretch_of_longest(&self, p: &[V3]) -> f64 {
        let of = |(k, (a, b, rest, _)): (usize, &(usize, usize, f64, f64))| {
            (distance(p[*a], p[*b]) - rest) / self.longest[k]
        };
        let farther = |a: f64, b: f64| if b.abs() > a.abs() || b.is_nan() { b } else { a };
        self.springs[..self.structural].iter().enumerate().map(of).fold(0.0, farther)
    }

    /// Mean square speed \[m^2/s^2\] between two frames.
    pub fn speed2(&self, p: &[V3], q: &[V3], seconds: f64) -> f64 {
        p.iter().zip(q).map(|(a, b)| (distance(*a, *b) / seconds).powi(2)).sum::<f64>() / p.len() as f64
    }

    /// Momentum \[kg m/s\].
    pub fn momentum(&self, p: &[V3], q: &[V3], seconds: f64) -> V3 {
        [0, 1, 2].map(|c| (0..p.len()).map(|k| self.mass[k] * (q[k][c] - p[k][c]) / seconds).sum())
    }

    /// Momentum \[kg m/s\] that all would have, were they to move one way.
    pub fn bustle(&self, p: &[V3], q: &[V3], seconds: f64) -> f64 {
        (0..p.len()).map(|k| self.mass[k] * distance(p[k], q[k]) / seconds).sum()
    }

    /// Energy \[J\]: of motion and gravity in the middle of the step from `before` to `now`, where they belong together
    /// in Verlet's scheme, and of springs at its end, as in the implicit steps of XPBD.
    pub fn energy(&self, now: &[V3], before: &[V3], dt: f64) -> f64 {
        let mut sum = 0.0;
        let middle = |k: usize| [0, 1, 2].map(|c| 0.5 * (now[k][c] + before[k][c]));
        for k in (0..now.len()).filter(|k| self.free[*k]) {
            sum += self.mass[k] * (0.5 * (distance(now[k], before[k]) / dt).powi(2) - dot(self.gravity, middle(k)));
        }
        for &(a, b, rest, soft) in self.springs.iter().filter(|s| s.3 > 0.0) {
            sum += 0.5 / soft * (distance(now[a], now[b]) - rest).powi(2);
        }
        sum
    }
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

pub fn distance(a: V3, b: V3) -> f64 {
    norm([0, 1, 2].map(|c| a[c] - b[c]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{N, hanging};

    #[test]
    fn a_cloth_twice_its_size_is_stretched_by_as_much() {
        let gauge = Gauge::new(&hanging(1.0).unwrap(), [0.0, -9.81, 0.0]);
        let at = |by: f64| {
            let of = |k: usize| [by * (k % N) as f64 / 16.0, -((k / N) as f64) / 16.0, 0.0];
            (0..N * N).map(of).collect::<Vec<_>>()
        };
        assert!(gauge.stretch(&at(1.0)).abs() < 1e-6 && (gauge.stretch(&at(2.0)) - 1.0).abs() < 1e-6);
        assert!((gauge.stretch(&at(0.1)) + 0.9).abs() < 1e-6);
        assert!((gauge.scale - 9.81 * 0.2 * 287.0 / 289.0).abs() < 1e-5);
        // At rest there is energy of gravity alone.
        let free = 9.81 * 0.2 / 289.0 * (0..N).map(|j| if j == 0 { 0.0 } else { j as f64 / 16.0 * 17.0 }).sum::<f64>();
        assert!((gauge.energy(&at(1.0), &at(1.0), 1e-3) + free).abs() < 1e-5);
        assert_eq!(gauge.springs.len() - gauge.structural, 2 * 16 * 16);
    }
}
