//! Whether two triangles cross or touch, decided by exact signs.
//!
//! Coordinates are f32 values in f64: no product of the predicates overflows, and none that matters underflows.

use robust::{Coord, Coord3D, orient2d, orient3d};

/// A point, of coordinates that are f32 values \[m\].
pub type Point = [f64; 3];

/// A triangle with an area.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Its corners.
    pub corners: [Point; 3],
    /// Names of its corners: equal numbers are one corner.
    pub names: [u32; 3],
}

/// How two triangles lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meeting {
    /// They share at most the corners and the edge that they have in common.
    Apart,
    /// They share other points, but none inside both.
    Touching,
    /// Their interiors share a point.
    Crossing,
    /// They have all corners in common.
    Double,
}

/// How two triangles with an area lie.
pub fn meet(a: &Facet, b: &Facet) -> Meeting {
    if a.names.iter().all(|name| b.names.contains(name)) {
        return Meeting::Double;
    }
    let of_a = sides(a, b);
    if apart(a, b, of_a) {
        return Meeting::Apart;
    }
    let of_b = sides(b, a);
    if apart(b, a, of_b) {
        return Meeting::Apart;
    }
    let crossing = if of_a == [0.0; 3] {
        overlap(&a.corners, &b.corners)
    } else {
        through(of_a) && through(of_b) && intervals_overlap((&a.corners, of_a), (&b.corners, of_b))
    };
    if crossing {
        Meeting::Crossing
    } else if touch(a, b) {
        Meeting::Touching
    } else {
        Meeting::Apart
    }
}

/// Whether three points lie on a line.
pub fn on_a_line(corners: &[Point; 3]) -> bool {
    (0..3).all(|axis| turn(corners, axis) == 0.0)
}

/// Positive where `p` is on the side of the plane that sees the triangle turn counter-clockwise, negative on the other side, 0 in the plane.
fn side([a, b, c]: [&Point; 3], p: &Point) -> f64 {
    // The predicate takes its longest way for points of a plane; that of two axes, as of flat cloth at rest, is known at a glance.
    if (0..3).any(|k| a[k] == p[k] && b[k] == p[k] && c[k] == p[k]) {
        return 0.0;
    }
    let point = |p: &Point| Coord3D { x: p[0], y: p[1], z: p[2] };
    -orient3d(point(a), point(b), point(c), point(p))
}

/// On which sides of the plane of `b` the corners of `a` are.
fn sides(a: &Facet, b: &Facet) -> [f64; 3] {
    let plane = b.corners.each_ref();
    // The predicate takes its longest way for a point of the plane.
    [0, 1, 2].map(|k| if b.names.contains(&a.names[k]) { 0.0 } else { side(plane, &a.corners[k]) })
}

/// Whether the corners of `a` that `b` does not have are strictly on one side of the plane of `b`.
fn apart(a: &Facet, b: &Facet, of_a: [f64; 3]) -> bool {
    let own = |k: &usize| !b.names.contains(&a.names[*k]);
    let all = |test: fn(f64) -> bool| (0..3).filter(own).all(|k| test(of_a[k]));
    (0..3).any(|k| own(&k)) && (all(|s| s > 0.0) || all(|s| s < 0.0))
}

/// Whether corners lie strictly on both sides of a plane.
fn through(sides: [f64; 3]) -> bool {
    sides.iter().any(|s| *s > 0.0) && sides.iter().any(|s| *s < 0.0)
}

/// The corners of a triangle from the one that is alone on its side of a plane, and that side. The others are on the other side or in the plane.
fn alone_first((corners, sides): (&[Point; 3], [f64; 3])) -> ([&Point; 3], f64) {
    let positive = sides.iter().filter(|s| **s > 0.0).count() == 1;
    let first = sides.iter().position(|s| if positive { *s > 0.0 } else { *s < 0.0 }).unwrap_or(0);
    ([0, 1, 2].map(|k| &corners[(first + k) % 3]), sides[first])
}

/// Whether the open intervals overlap in which two triangles meet the line of their planes; each has corners on both sides of the other's plane.
fn intervals_overlap(a: (&[Point; 3], [f64; 3]), b: (&[Point; 3], [f64; 3])) -> bool {
    let (mut a, of_a) = alone_first(a);
    let (mut b, of_b) = alone_first(b);
    // Both first corners shall be on the positive side of the other's plane.
    if of_a < 0.0 {
        b.swap(1, 2);
    }
    if of_b < 0.0 {
        a.swap(1, 2);
    }
    side([a[0], a[1], b[0]], b[1]) < 0.0 && side([a[0], a[2], b[0]], b[2]) > 0.0
}

/// A triangle seen along an axis.
fn flat(p: &Point, axis: usize) -> Coord<f64> {
    Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] }
}

/// Positive where three points turn counter-clockwise, seen along an axis.
fn turn([a, b, c]: &[Point; 3], axis: usize) -> f64 {
    orient2d(flat(a, axis), flat(b, axis), flat(c, axis))
}

/// An axis along which a triangle with an area does not look like a line, and how it turns.
fn view(corners: &[Point; 3]) -> (usize, f64) {
    let turns = [0, 1, 2].map(|axis| turn(corners, axis));
    turns.into_iter().enumerate().find(|(_, turn)| *turn != 0.0).unwrap_or((0, 1.0))
}

/// Whether the interiors of two triangles in one plane share a point: then no edge of one has the other outside.
fn overlap(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let axis = view(a).0;
    let separates = |t: &[Point; 3], other: &[Point; 3]| {
        let sense = turn(t, axis).signum();
        (0..3).any(|k| other.iter().all(|p| sense * turn(&[t[k], t[(k + 1) % 3], *p], axis) <= 0.0))
    };
    !separates(a, b) && !separates(b, a)
}

/// Whether two triangles share a point beside the corners that they have in common.
fn touch(a: &Facet, b: &Facet) -> bool {
    let own =
        |t: &Facet, other: &Facet| -> Vec<usize> { (0..3).filter(|k| !other.names.contains(&t.names[*k])).collect() };
    let (of_a, of_b) = (own(a, b), own(b, a));
    let meets = |t: &Facet, k: usize, other: &Facet| {
        edge_meets(&t.corners[(k + 1) % 3], &t.corners[(k + 2) % 3], &other.corners)
    };
    match of_a.len() {
        3 => (0..3).any(|k| meets(a, k, b) || meets(b, k, a)),
        // Each way from the common corner to another common point leaves one of the triangles across the corner.
        2 => {
            let across = |own: &[usize]| 3 - own.iter().sum::<usize>();
            meets(a, across(&of_a), b) || meets(b, across(&of_b), a)
        }
        // Planes meet in the common edge, or the triangles lie in one plane and do not overlap.
        _ => false,
    }
}

/// Whether an edge shares a point with a triangle, each with its ends.
fn edge_meets(p: &Point, q: &Point, triangle: &[Point; 3]) -> bool {
    let plane = triangle.each_ref();
    let (of_p, of_q) = (side(plane, p), side(plane, q));
    if (of_p > 0.0 && of_q > 0.0) || (of_p < 0.0 && of_q < 0.0) {
        return false;
    }
    if of_p == 0.0 && of_q == 0.0 {
        return edge_meets_in_plane(p, q, triangle);
    }
    let around = [0, 1, 2].map(|k| side([p, q, plane[k]], plane[(k + 1) % 3]));
    !through(around)
}

/// The same for an edge in the plane of the triangle.
fn edge_meets_in_plane(p: &Point, q: &Point, t: &[Point; 3]) -> bool {
    let (axis, sense) = view(t);
    let sense = sense.signum();
    let outside = (0..3).any(|k| {
        let beside = |p: &Point| sense * turn(&[t[k], t[(k + 1) % 3], *p], axis);
        beside(p) < 0.0 && beside(q) < 0.0
    });
    let turns = t.map(|c| turn(&[*p, *q, c], axis));
    !outside && !turns.iter().all(|s| *s > 0.0) && !turns.iter().all(|s| *s < 0.0)
}

#[cfg(test)]
#[path = "exact_tests.rs"]
mod tests;
