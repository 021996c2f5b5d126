//! How points, and the cells between them, go on until the next search.

use super::boxes::Bound;
use crate::number::real::{V3, add, dot, scale, sub};

/// Where a point is, where its drift takes it until the next search, and how far it may be from there.
#[derive(Clone, Copy)]
pub struct Way {
    pub from: V3<f64>,
    pub to: V3<f64>,
    pub reach: f64,
}

/// The drifts of a cell's points: a mean, how far they are off it, and the largest reach \[m\]; and a ball around the points.
#[derive(Clone, Copy, Default)]
pub struct Drift {
    pub mean: V3<f64>,
    pub off: f64,
    pub reach: f64,
    /// Its center where the search began, if it always moved so, and its radius when it was made.
    pub center: V3<f64>,
    pub radius: f64,
}

impl Drift {
    /// That of ways from a step to another one.
    pub fn of(corners: &[Way], [begin, end]: [f64; 2]) -> Self {
        let share = 1.0 / corners.len().max(1) as f64;
        let (mut sum, mut ways, mut reach) = ([0.0; 3], [0.0; 3], 0.0f64);
        for way in corners {
            (sum, ways) = (add(sum, way.from), add(ways, sub(way.to, way.from)));
            reach = reach.max(way.reach);
        }
        let (middle, gone) = (scale(sum, share), scale(ways, share));
        let (mut off2, mut far2) = (0.0f64, 0.0f64);
        for way in corners {
            let (off, far) = (sub(sub(way.to, way.from), gone), sub(way.from, middle));
            (off2, far2) = (off2.max(dot(off, off)), far2.max(dot(far, far)));
        }
        let steps = 1.0 / (end - begin);
        let mean = scale(gone, steps);
        let center = sub(middle, scale(mean, begin));
        Drift { mean, off: off2.sqrt() * steps, reach, center, radius: far2.sqrt() }
    }

    /// By how much features of two cells can come nearer in some steps, at most.
    pub fn near(&self, other: &Self, ahead: f64) -> f64 {
        let apart = sub(self.mean, other.mean);
        // With room for rounding.
        self.reach + other.reach + 1.000001 * ahead * (dot(apart, apart).sqrt() + self.off + other.off)
    }

    /// The way from the center of a cell to that of another one when both have gone some steps; none if their points are farther apart than
    /// `near` then.
    pub fn way(&self, other: &Self, gone: f64, near: f64) -> Option<V3<f64>> {
        let way = add(sub(other.center, self.center), scale(sub(other.mean, self.mean), gone));
        let far = 1.000001 * (self.radius + other.radius + gone * (self.off + other.off) + near);
        // NaN is left to others.
        let apart = dot(way, way) > far * far;
        (!apart).then_some(way)
    }
}

/// The box around the ways of points with their reach and half of the least gap.
pub fn around(points: &[Way], floor: f64) -> Bound {
    let (mut bound, mut reach) = (Bound::NONE, 0.0f64);
    for way in points {
        reach = reach.max(way.reach);
        for p in [way.from, way.to] {
            let p = p.map(|x| x as f32);
            bound = bound.with(&Bound { low: p, high: p });
        }
    }
    // Half of the floor would do; positions are f32, and the sum is rounded.
    let wide = (reach + floor) as f32;
    Bound { low: bound.low.map(|x| x - wide), high: bound.high.map(|x| x + wide) }
}
