use parry3d_f64::math::Vector;
use parry3d_f64::query::intersection_test;
use parry3d_f64::shape::Triangle;

use super::*;

/// xorshift32.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as f32 / u32::MAX as f32 * 2.0 - 1.0
    }

    fn triangle(&mut self, size: f32) -> [V3<f32>; 3] {
        let center = [self.next(), self.next(), self.next()];
        [0; 3].map(|_| center.map(|c| c + size * self.next()))
    }
}

/// Another way: triangles meet where an edge of one passes through the other.
fn pierced(p: [V3<f32>; 3], q: [V3<f32>; 3]) -> bool {
    let (p, q) = (p.map(|v| v.map(f64::from)), q.map(|v| v.map(f64::from)));
    let one = |t: [V3<f64>; 3], from: V3<f64>, to: V3<f64>| {
        let (d, e, f, s) = (sub(to, from), sub(t[1], t[0]), sub(t[2], t[0]), sub(from, t[0]));
        let h = cross(d, f);
        let (det, k) = (dot(e, h), cross(s, e));
        let (u, v, w) = (dot(s, h) / det, dot(d, k) / det, dot(f, k) / det);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&w)
    };
    (0..3).any(|n| one(p, q[n], q[(n + 1) % 3]) || one(q, p[n], p[(n + 1) % 3]))
}

#[test]
fn edges_through_faces_and_parry_agree() {
    let mut noise = Noise(7);
    let (mut met, mut near, mut near_parry) = (0, 0, 0);
    for _ in 0..20_000 {
        let (p, q) = (noise.triangle(2.0), noise.triangle(2.0));
        let shape = |t: [V3<f32>; 3]| {
            let [a, b, c] = t.map(|v| Vector::from_array(v.map(f64::from)));
            Triangle::new(a, b, c)
        };
        let pose = parry3d_f64::math::Pose::IDENTITY;
        let parry = intersection_test(&pose, &shape(p), &pose, &shape(q)).unwrap().intersecting;
        let here = meets(p, q);
        // Answers may differ only where triangles nearly touch; parry's search takes 1e-3 for touching.
        let nearly = |by: f64| meets(grown(p, 1.0 + by), q) && !meets(grown(p, 1.0 - by), q);
        assert!(here == pierced(p, q) || nearly(1e-4), "{p:?} {q:?}");
        assert!(here == parry || nearly(2e-2), "{p:?} {q:?}");
        near += u32::from(here != pierced(p, q));
        near_parry += u32::from(here != parry);
        met += u32::from(here);
    }
    assert!((2_000..18_000).contains(&met), "{met}");
    assert!(near < 10 && near_parry < 100, "{near} and {near_parry} nearly");
}

/// A triangle made larger about its centre.
fn grown<T: Real>(t: [V3<T>; 3], by: f64) -> [V3<T>; 3] {
    let m = [0, 1, 2].map(|c| (t[0][c] + t[1][c] + t[2][c]) * T::of(1.0 / 3.0));
    t.map(|v| [0, 1, 2].map(|c| m[c] + (v[c] - m[c]) * T::of(by)))
}

#[test]
fn what_f64_says_is_met_is_met_in_f32_in_any_order_of_corners() {
    let mut noise = Noise(99);
    let mut met = 0;
    for _ in 0..20_000 {
        let (p, q) = (noise.triangle(0.9), noise.triangle(0.9));
        let wide = |t: [V3<f32>; 3]| t.map(|v| v.map(f64::from));
        // Shrunk by more than the margin, so that it is truly met.
        if meets(wide(p), grown(wide(q), 1.0 - 1e-5)) {
            met += 1;
            for turned in [p, [p[1], p[2], p[0]], [p[2], p[1], p[0]], [p[0], p[2], p[1]]] {
                assert!(meets(turned, q) && meets(q, turned), "{p:?} {q:?}");
            }
        }
    }
    assert!(met > 1_000);
}

#[test]
fn a_shared_edge_that_is_met_opens_both_sides() {
    let mut noise = Noise(5);
    for _ in 0..20_000 {
        let (p, q) = (noise.triangle(0.3), noise.triangle(1.0));
        let apex = [noise.next(), noise.next(), noise.next()];
        // A triangle through a point of the edge p0 p1, exactly at its middle, meets both triangles at that edge.
        let middle = [0, 1, 2].map(|c| 0.5 * p[0][c] + 0.5 * p[1][c]);
        let cut = [sub(middle, q[0]), add_all(middle, q[0]), q[1]];
        assert!(meets(p, cut) && meets([p[1], p[0], apex], cut), "{p:?} {cut:?}");
    }
}

fn add_all(a: V3<f32>, b: V3<f32>) -> V3<f32> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[test]
fn touching_counts_and_degenerate_triangles_are_points_and_segments() {
    let t = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0f32]];
    let cases = [
        (true, "a corner on a face", [[0.2, 0.2, 0.0], [0.2, 0.2, 1.0], [0.3, 0.2, 1.0]]),
        (true, "a common corner", [[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, 1.0]]),
        (true, "a common edge", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, -1.0, 0.0]]),
        (true, "in its plane", [[0.1, 0.1, 0.0], [0.2, 0.1, 0.0], [0.1, 0.2, 0.0]]),
        (false, "beside it in its plane", [[0.6, 0.6, 0.0], [1.0, 0.6, 0.0], [0.6, 1.0, 0.0]]),
        (false, "above it", [[0.1, 0.1, 0.01], [0.2, 0.1, 0.01], [0.1, 0.2, 0.01]]),
        (true, "a segment through it", [[0.2, 0.2, -1.0], [0.2, 0.2, 1.0], [0.2, 0.2, 1.0]]),
        (false, "a segment past it", [[0.7, 0.7, -1.0], [0.7, 0.7, 1.0], [0.7, 0.7, 1.0]]),
        (true, "a point on it", [[0.2, 0.2, 0.0]; 3]),
        (false, "a point off it", [[0.2, 0.2, 0.1]; 3]),
    ];
    for (expected, name, q) in cases {
        assert_eq!((meets(t, q), meets(q, t)), (expected, expected), "{name}");
    }
}
