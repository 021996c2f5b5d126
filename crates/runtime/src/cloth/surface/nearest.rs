//! The nearest point of a triangle.

use crate::number::real::{Real, V3, add, dot, scale, sub};

/// Where on a triangle a point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum On {
    Face,
    /// Between this corner and the next one.
    Side(u8),
    Corner(u8),
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Spot<T> {
    pub triangle: u32,
    /// Its weights at the corners, of sum 1.
    pub weights: V3<T>,
    /// Its squared distance \[m^2\].
    pub distance2: T,
    pub on: On,
}

/// The point of a triangle that is nearest to `p`.
///
/// C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
#[inline]
pub fn on_triangle<T: Real>(p: V3<T>, triangle: u32, [a, b, c]: [V3<T>; 3]) -> Spot<T> {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let spot = |weights: V3<T>, on: On| {
        let at = add(add(scale(a, weights[0]), scale(b, weights[1])), scale(c, weights[2]));
        let d = sub(p, at);
        Spot { triangle, weights, distance2: dot(d, d), on }
    };
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= zero && d2 <= zero {
        return spot([one, zero, zero], On::Corner(0));
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= zero && d4 <= d3 {
        return spot([zero, one, zero], On::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= zero && d1 >= zero && d3 <= zero {
        let v = d1 / (d1 - d3);
        return spot([one - v, v, zero], On::Side(0));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= zero && d5 <= d6 {
        return spot([zero, zero, one], On::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= zero && d2 >= zero && d6 <= zero {
        let w = d2 / (d2 - d6);
        return spot([one - w, zero, w], On::Side(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= zero && d4 - d3 >= zero && d5 - d6 >= zero {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return spot([zero, one - w, w], On::Side(1));
    }
    let all = one / (va + vb + vc);
    let (v, w) = (vb * all, vc * all);
    spot([one - v - w, v, w], On::Face)
}
