//! Closest points of two features (C. Ericson, "Real-Time Collision Detection", 2005, section 5.1), as the way between them.

use crate::number::real::{V3, add, cross, dot, scale, sub};

/// From a point to the closest point of a triangle \[m\].
pub fn to_triangle(p: V3<f64>, [a, b, c]: [V3<f64>; 3]) -> V3<f64> {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return sub(a, p);
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return sub(b, p);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return sub(add(a, scale(ab, d1 / (d1 - d3))), p);
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return sub(c, p);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return sub(add(a, scale(ac, d2 / (d2 - d6))), p);
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0 {
        return sub(add(b, scale(sub(c, b), e / (e + f))), p);
    }
    // Inside, the way is along the normal, which rounding turns least.
    let normal = cross(ab, ac);
    let square = dot(normal, normal);
    if square > 0.0 { scale(normal, -dot(ap, normal) / square) } else { sub(a, p) }
}

/// From an edge to the closest point of another one \[m\].
pub fn to_edge([p1, q1]: [V3<f64>; 2], [p2, q2]: [V3<f64>; 2]) -> V3<f64> {
    let (d1, d2, r) = (sub(q1, p1), sub(q2, p2), sub(p1, p2));
    let (a, e, f) = (dot(d1, d1), dot(d2, d2), dot(d2, r));
    let (c, b) = (dot(d1, r), dot(d1, d2));
    let denominator = a * e - b * b;
    // Of edges that are nearly parallel every point will do.
    let mut s = if denominator > 1e-12 * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = if e > 0.0 { (b * s + f) / e } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = if a > 0.0 { ((b * t - c) / a).clamp(0.0, 1.0) } else { 0.0 };
    }
    sub(add(p2, scale(d2, t)), add(p1, scale(d1, s)))
}
