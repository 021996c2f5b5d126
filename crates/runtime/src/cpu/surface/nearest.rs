//! The nearest point of a surface, found by walking from triangle to triangle.

use super::skinned::Skinned;
use crate::collider::surface::{BodySurface, NONE};
use crate::number::real::{Real, V3, add, dot, scale, sub};

/// Steps of a walk, and triangles around a corner that it looks at.
const STEPS: usize = 48;
const AROUND: usize = 24;

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

/// The nearest point to `p` that a walk from a triangle finds: each step goes to a neighbour that is nearer.
pub fn walk<T: Real>(surface: &BodySurface, skinned: &mut Skinned<T>, start: u32, p: V3<T>) -> Spot<T> {
    let mut spot = on_triangle(p, start, skinned.corners(surface, start));
    for _ in 0..STEPS {
        let next = match spot.on {
            On::Face => from_face(surface, skinned, &spot, p),
            On::Side(side) => beyond(surface, skinned, &spot, side.into(), p),
            On::Corner(corner) => around(surface, skinned, &spot, corner.into(), p),
        };
        match next {
            Some(nearer) => spot = nearer,
            None => break,
        }
    }
    spot
}

/// The triangle beyond a side, if it is nearer.
fn beyond<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    spot: &Spot<T>,
    side: usize,
    p: V3<T>,
) -> Option<Spot<T>> {
    let other = surface.across[spot.triangle as usize][side];
    if other == NONE {
        return None;
    }
    let found = on_triangle(p, other, skinned.corners(surface, other));
    (found.distance2 < spot.distance2).then_some(found)
}

/// The nearest of those beyond the sides of a face that hides them: where the surface is hollow, and from behind.
fn from_face<T: Real>(surface: &BodySurface, skinned: &mut Skinned<T>, spot: &Spot<T>, p: V3<T>) -> Option<Spot<T>> {
    let hollow = surface.hollow[spot.triangle as usize];
    let behind = hollow != 7 && {
        let corners = skinned.corners(surface, spot.triangle);
        dot(sub(p, corners[0]), super::face(&corners)) < T::of(0.0)
    };
    let mut best = None;
    for side in (0..3).filter(|side| behind || hollow >> side & 1 == 1) {
        let than = best.as_ref().unwrap_or(spot).distance2;
        best = beyond(surface, skinned, &Spot { distance2: than, ..*spot }, side, p).or(best);
    }
    best
}

/// The nearest triangle around a corner, if it is nearer.
fn around<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    spot: &Spot<T>,
    corner: usize,
    p: V3<T>,
) -> Option<Spot<T>> {
    let vertex = surface.triangles[spot.triangle as usize][corner];
    let mut best: Option<Spot<T>> = None;
    // One way round, and the other way too if that ends at a border.
    for way in [0, 2] {
        let mut at = spot.triangle;
        let mut closed = false;
        for _ in 0..AROUND {
            let own = surface.triangles[at as usize];
            let Some(c) = own.iter().position(|v| *v == vertex) else { break };
            let next = surface.across[at as usize][(c + way) % 3];
            if next == NONE || next == spot.triangle {
                closed = next != NONE;
                break;
            }
            at = next;
            let found = on_triangle(p, at, skinned.corners(surface, at));
            if found.distance2 < best.as_ref().unwrap_or(spot).distance2 {
                best = Some(found);
            }
        }
        if closed {
            break;
        }
    }
    best
}
