//! parry3d as the judge: inside or outside, and the way out.

use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, HalfSpace};

use super::*;

const POINTS: usize = 100_000;

/// Points of a fixed sequence (an additive recurrence in three dimensions) in a cube of half side `reach`.
fn points(reach: f64) -> impl Iterator<Item = [f64; 3]> {
    let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_1];
    (0..POINTS).map(move |k| steps.map(|a| (2.0 * (k as f64 * a).fract() - 1.0) * reach))
}

/// A place and rotation that are nothing special.
fn moved(shape: Shape) -> Collider {
    let q = [0.2f32, -0.5, 0.3, 0.7];
    let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    Collider { rotation: q.map(|x| x / norm), ..Collider::new(shape, [0.1, -0.2, 0.15]) }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

/// Where a point leaves, and the normal there. The depth is the length of the way.
fn exit<T: Real>(solid: &Solid<T>, p: V3<T>) -> Option<([f64; 3], [f64; 3])> {
    let Exit { at, normal, depth } = solid.exit(p)?;
    let (at, normal) = (cast(at), cast(normal));
    assert!((distance(at, cast(p)) - depth.get()).abs() < 1e-6, "{depth:?}", depth = depth.get());
    Some((at, normal))
}

fn agrees(shape: Shape, judge: &dyn PointQuery, size: f64) {
    let collider = moved(shape);
    let (f32s, f64s) = (Solid::<f32>::new(&collider), Solid::<f64>::new(&collider));
    let [x, y, z, w] = collider.rotation.map(f64::from);
    let rotation = parry3d_f64::math::Rotation::from_xyzw(x, y, z, w);
    let [cx, cy, cz] = collider.center.map(f64::from);
    let pose = Pose::from_parts(Vector::new(cx, cy, cz), rotation);
    let mut inside = 0;
    for p in points(1.2) {
        let at: [f32; 3] = cast(p);
        let answer = judge.project_point(&pose, Vector::from_array(at.map(f64::from)), false);
        let to = answer.point.to_array();
        let exact: [f64; 3] = cast(at);
        let depth = distance(to, exact);
        for exit in [exit(&f32s, at), exit(&f64s, exact)] {
            assert!(exit.is_some() == answer.is_inside || depth < 1e-6, "{shape:?} at {at:?}, depth {depth}");
            let Some((q, n)) = exit else { continue };
            inside += 1;
            // Two ways out that are equally short are both right.
            let tie = (distance(q, exact) - depth).abs() < 1e-6
                && judge.distance_to_point(&pose, Vector::from_array(q), false) < 1e-6;
            assert!(distance(q, to) <= 1e-5 * size || tie, "{shape:?} at {at:?}: {q:?}, not {to:?}");
            assert!((dot(n, n) - 1.0).abs() < 1e-5 && dot(sub(q, exact), n) >= -1e-6, "{shape:?} at {at:?}: {n:?}");
        }
    }
    assert!(inside > POINTS / 50, "{shape:?}: only {inside} points were inside");
}

#[test]
fn parry_agrees_on_half_spaces() {
    agrees(Shape::HalfSpace, &HalfSpace::new(Vector::new(0.0, 1.0, 0.0)), 1.0);
}

#[test]
fn parry_agrees_on_spheres() {
    agrees(Shape::Sphere { radius: 0.7 }, &Ball::new(0.7), 0.7);
}

#[test]
fn parry_agrees_on_capsules() {
    agrees(Shape::Capsule { half_height: 0.4, radius: 0.3 }, &Capsule::new_y(0.4, 0.3), 0.7);
}

#[test]
fn parry_agrees_on_boxes() {
    let half = [0.5, 0.3, 0.8];
    agrees(Shape::Box { half }, &Cuboid::new(Vector::new(0.5, 0.3, 0.8)), 0.8);
}

/// The distance \[m\] of a point from the surface of the hull of two balls, negative inside: the least over all balls between them, a convex
/// function of the ball, by trisection.
fn to_hull(p: [f64; 3], half: f64, [low, high]: [f64; 2]) -> f64 {
    let at = |t: f64| distance(p, [0.0, (2.0 * t - 1.0) * half, 0.0]) - (low + t * (high - low));
    let (mut a, mut b) = (0.0, 1.0);
    for _ in 0..100 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        (a, b) = if at(c) < at(d) { (a, d) } else { (c, b) };
    }
    at(0.5 * (a + b)).min(at(0.0)).min(at(1.0))
}

/// Tapered capsules of many proportions: half height, radii.
const TAPERS: [(f32, [f32; 2]); 5] =
    [(0.4, [0.1, 0.3]), (0.3, [0.25, 0.05]), (0.11, [0.3, 0.1]), (0.5, [0.2, 0.2]), (0.2, [0.1, 0.499])];

#[test]
fn the_hull_of_two_balls_agrees_on_tapered_capsules() {
    for (half_height, radii) in TAPERS {
        let collider = moved(Shape::TaperedCapsule { half_height, radii });
        collider.check().unwrap();
        let (f32s, f64s) = (Solid::<f32>::new(&collider), Solid::<f64>::new(&collider));
        let [x, y, z, w] = f64s.rotation;
        let hull = |p: [f64; 3]| {
            to_hull(turn([-x, -y, -z, w], sub(p, f64s.center)), f64::from(half_height), radii.map(f64::from))
        };
        let mut inside = 0;
        for p in points(1.2).step_by(4) {
            let at: [f32; 3] = cast(p);
            let exact: [f64; 3] = cast(at);
            let depth = -hull(exact);
            for (exit, close) in [(exit(&f32s, at), 2e-6), (exit(&f64s, exact), 1e-9)] {
                assert!(
                    exit.is_some() == (depth > 0.0) || depth.abs() < close,
                    "{collider:?} at {at:?}, depth {depth}"
                );
                let Some((q, n)) = exit else { continue };
                inside += 1;
                let q: [f64; 3] = q;
                assert!(hull(q).abs() < close, "{collider:?} at {at:?}: {q:?} is {} m off the surface", hull(q));
                assert!((distance(q, exact) - depth).abs() < close, "{collider:?} at {at:?}: {q:?} is not the nearest");
                assert!(
                    (dot(n, n) - 1.0).abs() < 1e-5 && dot(sub(q, exact), n) >= -1e-6,
                    "{collider:?} at {at:?}: {n:?}"
                );
            }
        }
        assert!(inside > POINTS / 500, "{collider:?}: only {inside} points were inside");
    }
}

#[test]
fn paths_enter_a_tapered_capsule_where_they_first_meet_its_surface() {
    for (half_height, radii) in TAPERS {
        let collider = Collider::new(Shape::TaperedCapsule { half_height, radii }, [0.0; 3]);
        let (f32s, f64s) = (Solid::<f32>::new(&collider), Solid::<f64>::new(&collider));
        let hull = |p: [f64; 3]| to_hull(p, f64::from(half_height), radii.map(f64::from));
        let all: Vec<[f64; 3]> = points(1.5).take(8000).collect();
        let (mut met, mut missed) = (0, 0);
        for pair in all.chunks(2).filter(|pair| hull(pair[0]) > 1e-3) {
            let (from, path) = (pair[0], sub(pair[1], pair[0]));
            let on = |t: f64| add(from, scale(path, t));
            // The distance along the path is convex: its least value tells whether it enters, and bisection where.
            let (mut a, mut b) = (0.0, 1.0);
            for _ in 0..100 {
                let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                (a, b) = if hull(on(c)) < hull(on(d)) { (a, d) } else { (c, b) };
            }
            let deepest = 0.5 * (a + b);
            let (least, size) = (hull(on(deepest)), dot(path, path).sqrt());
            let single = f32s.entry(cast(from), cast(path)).map(|(q, n)| (cast(q), cast(n)));
            for (entry, close) in [(f64s.entry(from, path), 1e-7), (single, 1e-3)] {
                if least.abs() < close {
                    continue;
                }
                assert_eq!(
                    entry.is_some(),
                    least < 0.0,
                    "{collider:?} from {from:?} along {path:?}: {entry:?}, {least}"
                );
                let Some((q, n)) = entry else {
                    missed += 1;
                    continue;
                };
                let (mut low, mut high) = (0.0, deepest);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if hull(on(middle)) > 0.0 { low = middle } else { high = middle }
                }
                // A path that grazes the surface has no sure place on it.
                let graze = (least.abs() / size).sqrt().max(1e-3);
                let q: [f64; 3] = q;
                assert!(distance(q, on(low)) < close / graze, "{collider:?} from {from:?} along {path:?}: {q:?}");
                let n: [f64; 3] = n;
                assert!(hull(add(q, scale(n, 0.01))) > 0.0099 - close / graze, "{collider:?} at {q:?}: {n:?}");
                met += 1;
            }
        }
        assert!(met > 100 && missed > 100, "{collider:?}: {met} met, {missed} missed");
    }
}

#[test]
fn tapered_capsules_without_a_taper_are_capsules_and_balls_in_balls_are_refused() {
    let capsule = Solid::<f32>::new(&moved(Shape::Capsule { half_height: 0.4, radius: 0.3 }));
    let tapered = Solid::<f32>::new(&moved(Shape::TaperedCapsule { half_height: 0.4, radii: [0.3; 2] }));
    for p in points(0.8).take(2000) {
        let p: [f32; 3] = cast(p);
        assert_eq!(capsule.exit(p).is_some(), tapered.exit(p).is_some());
        let (Some(Exit { at: a, .. }), Some(Exit { at: b, .. })) = (capsule.exit(p), tapered.exit(p)) else { continue };
        assert!(distance(cast(a), cast(b)) < 1e-6);
    }
    for (half_height, radii) in [(0.1, [0.3, 0.1]), (0.1, [0.1, 0.4]), (0.0, [0.1; 2]), (0.1, [f32::NAN, 0.1])] {
        assert!(Collider::new(Shape::TaperedCapsule { half_height, radii }, [0.0; 3]).check().is_err());
    }
}

/// The closest point of an ellipsoid by bisection of the same equation in f64, from `p` inside and in its frame.
fn bracketed(p: [f64; 3], radii: [f64; 3]) -> [f64; 3] {
    let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let at = |s: f64| [0, 1, 2].map(|c| radii[c] * radii[c] * p[c] / (s + radii[c] * radii[c]));
    let over = |s: f64| at(s).iter().zip(radii).map(|(q, r)| (q / r).powi(2)).sum::<f64>() > 1.0;
    let (mut low, mut high) = (-least * least, 0.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if over(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(0.5 * (low + high))
}

#[test]
fn a_bracketed_root_agrees_on_ellipsoids() {
    for radii in [[0.5, 0.3, 0.8], [0.4, 0.4, 0.9], [0.6; 3], [0.05, 0.8, 0.7]] {
        let collider = Collider::new(Shape::Ellipsoid { radii, closest: true }, [0.0; 3]);
        let (f32s, f64s) = (Solid::<f32>::new(&collider), Solid::<f64>::new(&collider));
        let (exact, size): ([f64; 3], _) = (cast(radii), f64::from(radii.iter().copied().fold(0.0, f32::max)));
        let mut inside = 0;
        for p in points(size) {
            let at: [f32; 3] = cast(p);
            let p: [f64; 3] = cast(at);
            let level = |q: [f64; 3]| (0..3).map(|c| (q[c] / exact[c]).powi(2)).sum::<f64>().sqrt();
            assert!(f64s.exit(p).is_some() == (level(p) < 1.0) || (level(p) - 1.0).abs() < 1e-12);
            assert!(f32s.exit(at).is_some() == (level(p) < 1.0) || (level(p) - 1.0).abs() * size < 1e-6);
            let (Some(Exit { at: q32, .. }), Some(Exit { at: q64, .. })) = (f32s.exit(at), f64s.exit(p)) else {
                continue;
            };
            let to = bracketed(p, exact);
            inside += 1;
            assert!(distance(q64, to) <= 1e-5 * size, "{radii:?} at {p:?}: {q64:?}, not {to:?}");
            // Where ways out are nearly equally long, rounding chooses; each must be on the surface and as short.
            let q32: [f64; 3] = cast(q32);
            let tie = (distance(q32, p) - distance(to, p)).abs() <= 1e-6 * size && (level(q32) - 1.0).abs() < 1e-6;
            assert!(distance(q32, to) <= 1e-5 * size || tie, "{radii:?} at {p:?}: {q32:?}, not {to:?}");
        }
        assert!(inside > POINTS / 50);
    }
}

#[test]
fn the_radial_rule_is_on_the_surface_and_its_error_is_known() {
    let radii = [0.5, 0.3, 0.8];
    let way = |closest| Solid::<f64>::new(&Collider::new(Shape::Ellipsoid { radii, closest }, [0.0; 3]));
    let (radial, exact) = (way(false), way(true));
    let (mut worst, mut near) = (0.0f64, 0.0f64);
    for p in points(0.8) {
        let (Some(Exit { at: a, .. }), Some(Exit { at: b, .. })) = (radial.exit(p), exact.exit(p)) else { continue };
        let level = (0..3).map(|c| (a[c] / f64::from(radii[c])).powi(2)).sum::<f64>();
        assert!((level - 1.0).abs() < 1e-9);
        worst = worst.max(distance(a, b));
        if distance(b, p) < 0.01 {
            near = near.max(distance(a, b) / distance(b, p).max(1e-4));
        }
    }
    // Deep inside the rule is far off; near the surface it errs by the depth times the slant of the ray.
    assert!((0.3..0.9).contains(&worst), "{worst}");
    assert!((0.3..1.5).contains(&near), "{near}");
}
