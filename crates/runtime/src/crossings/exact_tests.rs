//! Pairs of triangles: named cases, parry3d and clipping in floating-point numbers as judges, and invariance.

use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::Triangle;

use super::super::depth::depth;
use super::super::tests::{Random, facet};
use super::*;

const GROUND: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

#[test]
fn named_cases() {
    use Meeting::{Apart, Crossing, Touching};
    let cases: [(&str, [[f32; 3]; 3], Meeting); 16] = [
        ("through the face", [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 9.0, 1.0]], Crossing),
        ("through an edge", [[1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 0.5]], Crossing),
        ("above", [[1.0, 1.0, 1.0], [1.0, 2.0, 1.0], [2.0, 1.0, 1.5]], Apart),
        ("planes meet elsewhere", [[9.0, 9.0, -1.0], [9.0, 9.0, 1.0], [9.0, 8.0, 1.0]], Apart),
        ("the line of the planes is parted", [[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [4.0, 4.0, 0.5]], Apart),
        ("a corner on the face", [[1.0, 1.0, 0.0], [1.0, 2.0, 1.0], [2.0, 1.0, 1.0]], Touching),
        ("a corner on an edge", [[1.0, 0.0, 0.0], [1.0, -2.0, 1.0], [2.0, -1.0, 1.0]], Touching),
        ("a corner on a corner", [[4.0, 0.0, 0.0], [5.0, -2.0, 1.0], [6.0, -1.0, -1.0]], Touching),
        ("an edge on the face", [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 3.0]], Touching),
        ("an edge across an edge", [[1.0, -1.0, -1.0], [1.0, 1.0, 1.0], [1.0, -2.0, 3.0]], Touching),
        ("an edge on an edge", [[-1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 0.0, 2.0]], Touching),
        ("in the plane, overlapping", [[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 9.0, 0.0]], Crossing),
        ("in the plane, inside", [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]], Crossing),
        ("in the plane, edge on edge", [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, -2.0, 0.0]], Touching),
        ("in the plane, corner on edge", [[2.0, 2.0, 0.0], [3.0, 3.0, 0.0], [3.0, 4.0, 0.0]], Touching),
        ("in the plane, apart", [[3.0, 3.0, 0.0], [4.0, 3.0, 0.0], [3.0, 4.0, 0.0]], Apart),
    ];
    for (name, corners, expected) in cases {
        for turned in turns(corners) {
            let (a, b) = (facet(GROUND, 0), facet(turned, 10));
            assert_eq!([meet(&a, &b), meet(&b, &a)], [expected; 2], "{name}");
        }
    }
}

#[test]
fn corners_and_edges_in_common_do_not_count() {
    use Meeting::{Apart, Crossing, Touching};
    // Corner 0 of the ground is that of both.
    let by_corner: [(&str, [[f32; 3]; 2], Meeting); 7] = [
        ("beside it", [[-1.0, 0.0, 0.0], [0.0, -1.0, 1.0]], Apart),
        ("in the plane, beside it", [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], Apart),
        ("in the plane, over it", [[5.0, 1.0, 0.0], [1.0, 5.0, 0.0]], Crossing),
        ("through the face", [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0]], Crossing),
        ("planes meet on the other side", [[-1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]], Apart),
        ("an edge on the face", [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0]], Touching),
        ("an edge on an edge", [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0]], Touching),
    ];
    for (name, [p, q], expected) in by_corner {
        for corners in turns([GROUND[0], p, q]) {
            let a = facet(GROUND, 0);
            let mut b = facet(corners, 10);
            let k = corners.iter().position(|c| *c == GROUND[0]).unwrap();
            b.names[k] = 0;
            assert_eq!([meet(&a, &b), meet(&b, &a)], [expected; 2], "{name}");
        }
    }
    let by_edge = [
        ("folded", [1.0, 1.0, 1.0], Apart),
        ("flat", [1.0, -1.0, 0.0], Apart),
        ("folded flat", [1.0, 1.0, 0.0], Crossing),
    ];
    for (name, p, expected) in by_edge {
        let (a, mut b) = (facet(GROUND, 0), facet([GROUND[1], GROUND[0], p], 10));
        b.names = [1, 0, 12];
        assert_eq!([meet(&a, &b), meet(&b, &a)], [expected; 2], "{name}");
    }
    // Two triangles of the same corners lie on one another wherever these are.
    let twin = Facet { corners: [0, 2, 1].map(|k| facet(GROUND, 0).corners[k]), names: [0, 2, 1] };
    assert_eq!(meet(&facet(GROUND, 0), &twin), Meeting::Double);
}

/// All orders of the corners.
fn turns(t: [[f32; 3]; 3]) -> [[[f32; 3]; 3]; 6] {
    [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]].map(|order| order.map(|k| t[k]))
}

fn parry(t: &Facet) -> Triangle {
    let [a, b, c] = t.corners.map(|p| Vector::new(p[0], p[1], p[2]));
    Triangle::new(a, b, c)
}

#[test]
fn parry_agrees_on_random_pairs() {
    let (mut random, mut crossing) = (Random::new(1), 0);
    for _ in 0..40_000 {
        let mut triangle = |first| facet([0; 3].map(|_| [0; 3].map(|_| random.next() as f32)), first);
        let (a, b) = (triangle(0), triangle(10));
        let still = Pose::identity();
        let expected = query::intersection_test(&still, &parry(&a), &still, &parry(&b)).unwrap().intersecting;
        let found = meet(&a, &b);
        let apart = query::distance(&still, &parry(&a), &still, &parry(&b)).unwrap().distance;
        // Pairs that meet by less than rounding are not for parry to judge.
        let sure = if expected { depth(&a.corners, &b.corners) > 1e-9 } else { apart > 1e-9 };
        assert!(!sure || (found == Meeting::Crossing) == expected, "{a:?} {b:?}: {found:?}");
        crossing += usize::from(found == Meeting::Crossing);
    }
    assert!((4_000..36_000).contains(&crossing), "{crossing}");
}

/// Clips a flat polygon by the inner sides of a triangle's edges in its plane.
fn clipped(polygon: Vec<Point>, t: &[Point; 3], normal: Point) -> Vec<Point> {
    (0..3).fold(polygon, |polygon, k| {
        let edge = minus(t[(k + 1) % 3], t[k]);
        let inside = |p: &Point| dot(cross(normal, edge), minus(*p, t[k]));
        let mut kept = Vec::new();
        for (n, p) in polygon.iter().enumerate() {
            let q = &polygon[(n + 1) % polygon.len()];
            let (s, r) = (inside(p), inside(q));
            if s >= 0.0 {
                kept.push(*p);
            }
            if s * r < 0.0 {
                kept.push([0, 1, 2].map(|c| p[c] + (q[c] - p[c]) * s / (s - r)));
            }
        }
        kept
    })
}

/// Whether interiors share a point, in floating-point numbers: right for coordinates that are small whole numbers.
fn judge(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let normal = |t: &[Point; 3]| cross(minus(t[1], t[0]), minus(t[2], t[0]));
    let (n, m) = (normal(a), normal(b));
    let line = cross(n, m);
    if line == [0.0; 3] {
        if dot(n, minus(b[0], a[0])) != 0.0 {
            return false;
        }
        let rest = clipped(a.to_vec(), b, m);
        let area =
            (2..rest.len()).map(|k| dot(n, cross(minus(rest[k - 1], rest[0]), minus(rest[k], rest[0])))).sum::<f64>();
        return area.abs() > 1e-9;
    }
    let interval = |t: &[Point; 3], n: Point, p: Point| {
        let sides = t.map(|c| dot(n, minus(c, p)));
        let mut ends = Vec::new();
        for k in 0..3 {
            let (s, r) = (sides[k], sides[(k + 1) % 3]);
            if s * r < 0.0 {
                let (x, y) = (dot(line, t[k]), dot(line, t[(k + 1) % 3]));
                ends.push(x + (y - x) * s / (s - r));
            }
            if s == 0.0 {
                ends.push(dot(line, t[k]));
            }
        }
        let both = sides.iter().any(|s| *s > 0.0) && sides.iter().any(|s| *s < 0.0);
        both.then(|| ends.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], e| [l.min(*e), h.max(*e)]))
    };
    let (Some(of_a), Some(of_b)) = (interval(a, m, b[0]), interval(b, n, a[0])) else { return false };
    of_a[1].min(of_b[1]) - of_a[0].max(of_b[0]) > 1e-9
}

#[test]
fn pairs_in_special_places_agree_with_judges() {
    let (mut random, mut found) = (Random::new(5), [0; 3]);
    let mut tried = 0;
    while tried < 60_000 {
        let mut triangle = |first| facet([0; 3].map(|_| [0; 3].map(|_| (4.0 * random.next()).floor() as f32)), first);
        let (a, b) = (triangle(0), triangle(10));
        if on_a_line(&a.corners) || on_a_line(&b.corners) {
            continue;
        }
        tried += 1;
        let still = Pose::identity();
        let near = query::distance(&still, &parry(&a), &still, &parry(&b)).unwrap().distance < 1e-6;
        let expected = match (judge(&a.corners, &b.corners), near) {
            (true, _) => Meeting::Crossing,
            (false, true) => Meeting::Touching,
            (false, false) => Meeting::Apart,
        };
        let meeting = meet(&a, &b);
        assert_eq!((meeting, meet(&b, &a)), (expected, expected), "{a:?} {b:?}");
        found[meeting as usize] += 1;
        // Corners in common make touching pairs apart, and nothing else.
        let mut named = b;
        for (name, p) in named.names.iter_mut().zip(&b.corners) {
            if let Some(k) = a.corners.iter().position(|q| p == q) {
                *name = a.names[k];
            }
        }
        let common = meet(&a, &named);
        if a.names.iter().all(|name| named.names.contains(name)) {
            assert_eq!((common, meet(&named, &a)), (Meeting::Double, Meeting::Double));
            continue;
        }
        assert_eq!(common == Meeting::Crossing, expected == Meeting::Crossing, "{a:?} {named:?}");
        assert!(common != Meeting::Touching || expected == Meeting::Touching);
    }
    assert!(found.iter().all(|count| *count > 5_000), "{found:?}");
}

#[test]
fn order_and_exact_motion_change_nothing() {
    let mut random = Random::new(9);
    for round in 0..4_000 {
        // Multiples of 2^-10 or of 1, which moves below keep exactly.
        let (range, unit) = if round % 2 == 0 { (1024.0, 1.0 / 1024.0) } else { (4.0, 1.0) };
        let mut corner = || [0; 3].map(|_| (range * random.next()).floor() as f32 * unit);
        let (t, u) = ([0; 3].map(|_| corner()), [0; 3].map(|_| corner()));
        let (a, b) = (facet(t, 0), facet(u, 10));
        if on_a_line(&a.corners) || on_a_line(&b.corners) {
            continue;
        }
        let (expected, deep) = (meet(&a, &b), depth(&a.corners, &b.corners));
        let moves: [fn([f32; 3]) -> [f32; 3]; 6] = [
            |p| [p[1], p[2], p[0]],
            |p| [p[1], p[0], p[2]],
            |p| [-p[0], p[1], p[2]],
            |p| [p[0] + 1000.0, p[1] - 512.0, p[2] + 0.5],
            |p| p.map(|x| x * 2.0_f32.powi(-120)),
            |p| p.map(|x| x * 2.0_f32.powi(115)),
        ];
        for (n, change) in moves.iter().enumerate() {
            for (v, w) in turns(t).into_iter().zip(turns(u)) {
                let (a, b) = (facet(v.map(change), 0), facet(w.map(change), 10));
                assert_eq!([meet(&a, &b), meet(&b, &a)], [expected; 2], "{round}, {n}: {t:?} {u:?}");
                if n < 4 && expected == Meeting::Crossing {
                    let moved = depth(&a.corners, &b.corners);
                    assert!((moved - deep).abs() < 1e-9, "{round}, {n}: {moved} {deep}");
                }
            }
        }
    }
}

#[test]
fn a_pair_moved_apart_by_its_depth_no_longer_crosses() {
    let a = facet(GROUND, 0);
    let upright = |z: f32| facet([[1.0, 1.0, z], [2.0, 1.0, 5.0], [1.5, 1.5, 5.0]], 10);
    let found = depth(&a.corners, &upright(-0.25).corners);
    assert!((found - 0.25).abs() < 1e-12, "{found}");
    assert_eq!(meet(&a, &upright(0.0)), Meeting::Touching);
    let mut random = Random::new(21);
    let mut tried = 0;
    while tried < 300 {
        let mut triangle = |first| facet([0; 3].map(|_| [0; 3].map(|_| random.next() as f32)), first);
        let (a, b) = (triangle(0), triangle(10));
        if meet(&a, &b) != Meeting::Crossing {
            continue;
        }
        tried += 1;
        let deep = depth(&a.corners, &b.corners);
        // No shorter move in any of many directions suffices.
        for _ in 0..100 {
            let v = [0; 3].map(|_| random.next() - 0.5);
            let scale = 0.99 * deep / dot(v, v).sqrt();
            let moved = b.corners.map(|p| [0, 1, 2].map(|c| f64::from((p[c] + scale * v[c]) as f32)));
            assert_eq!(meet(&a, &Facet { corners: moved, ..b }), Meeting::Crossing, "{a:?} {b:?} {deep}");
        }
    }
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|c| a[c] - b[c])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

fn cross(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
}
