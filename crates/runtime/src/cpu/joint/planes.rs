//! Twin of shaders/part/planes.wgsl: the half-space that keeps a particle, of one of two features, on its side.
//!
//! As in [`crate::cpu::truncation`] (planes.rs), but in f32: all numbers are differences to a particle of the pair, and a particle gets a bound of its own
//! way. Let s be the largest distance of the four particles from the first one. Rounding changes a height by less than 3e-7 s, so that
//! [`PLANE_ERROR`] of s, which is left free beside each plane, keeps the features apart in exact arithmetic. A normal counts by the gap that it leaves
//! between the particles, however it was found: a wrong one leaves none. Features that are nearer than [`TOUCH`] of s touch, and pass one another as
//! they do where they cross. No step that begins with a larger gap ends with such a one.

use super::Lists;
use crate::levels::safe::{GAP_SHARE, PLANE_ERROR, TOUCH};
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, xyz};

/// The bound that keeps a particle apart from a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound<T> {
    /// Nothing: the features cross, or touch.
    Free,
    /// `normal . way <= most` for its way in the round.
    Plane { normal: V3<T>, most: T },
    /// The particle stays where it is.
    Still,
}

/// The way from a point, which is 0, to the closest point of a triangle \[m\] (C. Ericson, "Real-Time Collision Detection", 2005, section 5.1).
fn to_triangle<T: Real>([a, b, c]: [V3<T>; 3]) -> V3<T> {
    let zero = T::of(0.0);
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (d1, d2) = (zero - dot(ab, a), zero - dot(ac, a));
    if d1 <= zero && d2 <= zero {
        return a;
    }
    let (d3, d4) = (zero - dot(ab, b), zero - dot(ac, b));
    if d3 >= zero && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= zero && d1 >= zero && d3 <= zero && d1 > d3 {
        return add(a, scale(ab, d1 / (d1 - d3)));
    }
    let (d5, d6) = (zero - dot(ab, c), zero - dot(ac, c));
    if d6 >= zero && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= zero && d2 >= zero && d6 <= zero && d2 > d6 {
        return add(a, scale(ac, d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= zero && e >= zero && f >= zero && e + f > zero {
        return add(b, scale(sub(c, b), e / (e + f)));
    }
    let normal = cross(ab, ac);
    let square = dot(normal, normal);
    if square > zero { scale(normal, dot(a, normal) / square) } else { a }
}

/// The way from an edge that begins at 0 to the closest point of another one.
fn to_edge<T: Real>(q1: V3<T>, [p2, q2]: [V3<T>; 2]) -> V3<T> {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let clamp = |x: T| x.max(zero).min(one);
    let d2 = sub(q2, p2);
    let (a, e, f) = (dot(q1, q1), dot(d2, d2), zero - dot(d2, p2));
    let (c, b) = (zero - dot(q1, p2), dot(q1, d2));
    let denominator = a * e - b * b;
    // Of edges that are nearly parallel any point will do.
    let mut s = if denominator > T::of(1e-6) * a * e { clamp((b * f - c * e) / denominator) } else { zero };
    let mut t = if e > zero { (b * s + f) / e } else { zero };
    if t < zero || t > one {
        t = clamp(t);
        s = if a > zero { clamp((b * t - c) / a) } else { zero };
    }
    sub(add(p2, scale(d2, t)), scale(q1, s))
}

/// The sides of two features along a normal: how far the first one reaches, and where the second one begins.
fn sides<T: Real>(normal: V3<T>, at: &[V3<T>; 4], first: usize) -> [T; 2] {
    let (mut high, mut low) = (T::of(-f64::from(f32::MAX)), T::of(f64::from(f32::MAX)));
    for (n, p) in at.iter().enumerate() {
        let side = dot(normal, *p);
        if n < first { high = high.max(side) } else { low = low.min(side) }
    }
    [high, low]
}

/// The bound that keeps the particle `who` of four on its side in a round: two edges of two, or a vertex and a triangle. `floor`: least gap \[m\].
pub fn bound<T: Real>(lists: &Lists<T>, (four, edges, who): ([usize; 4], bool, usize), floor: T) -> Bound<T> {
    let (zero, one) = (T::of(0.0), T::of(1.0));
    let origin = xyz(lists.bases[four[0]]);
    let at = four.map(|k| sub(xyz(lists.bases[k]), origin));
    let size = at.iter().map(|p| dot(*p, *p)).fold(zero, T::max).sqrt();
    let first = if edges { 2 } else { 1 };
    let way = if edges { to_edge(at[1], [at[2], at[3]]) } else { to_triangle([at[1], at[2], at[3]]) };
    let far = dot(way, way).sqrt();
    if far <= size * T::of(TOUCH) {
        return Bound::Free;
    }
    let mut normal = scale(way, one / far);
    let mut sides_of = sides(normal, &at, first);
    if sides_of[1] - sides_of[0] < T::of(0.5) * far {
        // Rounding may turn a short way; the normal of both edges, or of the triangle, is better then.
        let other = if edges { cross(at[1], sub(at[3], at[2])) } else { cross(sub(at[2], at[1]), sub(at[3], at[1])) };
        let long = dot(other, other).sqrt();
        if long > zero {
            let sign = if dot(other, at[2]) < zero { zero - one } else { one };
            let other = scale(other, sign / long);
            let found = sides(other, &at, first);
            if found[1] - found[0] > sides_of[1] - sides_of[0] {
                (normal, sides_of) = (other, found);
            }
        }
    }
    let [high, low] = sides_of;
    let gap = low - high;
    if gap <= size * T::of(TOUCH) {
        return Bound::Still;
    }
    let slack = gap - gap.min(floor.max(T::of(1.0 - GAP_SHARE) * gap));
    // The side that moves towards the other gets more of it; a pin all that it needs.
    let (mut moves, mut must) = ([zero; 2], [zero; 2]);
    for (n, k) in four.into_iter().enumerate() {
        let (side, sign) = if n < first { (0, one) } else { (1, zero - one) };
        let step = sign * dot(normal, xyz(lists.ways[k]));
        moves[side] = moves[side].max(step);
        if lists.ways[k][3] <= zero {
            // Another particle of the feature may be the nearest one.
            let behind = if side == 0 { high - dot(normal, at[n]) } else { dot(normal, at[n]) - low };
            must[side] = must[side].max(step - behind);
        }
    }
    let even = T::of(0.05) * gap;
    let share = slack * (moves[0] + even) / (moves[0] + moves[1] + T::of(2.0) * even);
    let share = share.max(must[0]).min((slack - must[1]).max(zero)).min(slack);
    let height = dot(normal, at[who]);
    let room = size * T::of(PLANE_ERROR);
    if who < first {
        Bound::Plane { normal, most: high + share - height - room }
    } else {
        Bound::Plane { normal: scale(normal, zero - one), most: height - low + slack - share - room }
    }
}
