//! The nearest point of a triangle mesh: the one module that names parry.
//!
//! The tree and its traversal are parry's. The distance to one triangle is computed here, as the best of its face and
//! its three sides: a region test on a needle can name the wrong side, the least of four points on it cannot.

use crate::frame::{Frame, usable_corners, used_positions};
use crate::vec3::{add, cross, dot, norm, scale, sub};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::PointQuery;
use rayon::prelude::*;

/// A point of a mesh nearest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The point \[m\].
    pub point: [f64; 3],
    /// The index of a triangle it lies on.
    pub triangle: u32,
    /// Its weights at the corners of that triangle, which add to 1.
    pub barycentric: [f64; 3],
    /// How far it is \[m\].
    pub distance: f64,
}

/// A mesh made ready for queries. Triangles with indices out of range or coordinates that are not finite are left out.
pub struct Closest {
    frame: Frame,
    tree: Bvh,
    corners: Vec<[[f64; 3]; 3]>,
    ids: Vec<u32>,
    sliver: Vec<bool>,
}

/// What a triangle without an area adds to its distance, in units of the mesh's size, to lose ties against neighbours
/// that have a normal.
const SLIVER_COST: f64 = 1e-12;

impl Closest {
    /// Builds the tree, O(n log n).
    pub fn new(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let frame = Frame::around(used_positions(positions, triangles));
        let (corners, ids) = usable_corners(&frame, positions, triangles);
        let vector = |p: [f64; 3]| Vector::new(p[0], p[1], p[2]);
        let boxes = corners.iter().map(|c| {
            let (a, b, c) = (vector(c[0]), vector(c[1]), vector(c[2]));
            Aabb::new(a.min(b).min(c), a.max(b).max(c))
        });
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
        let sliver = corners
            .iter()
            .map(|&[a, b, c]| {
                let (ab, ac) = (sub(b, a), sub(c, a));
                norm(cross(ab, ac)) <= 1e-12 * dot(ab, ab).max(dot(ac, ac))
            })
            .collect();
        Self { frame, tree, corners, ids, sliver }
    }

    /// Whether there is nothing to find.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The nearest point; `None` if the mesh is empty or `p` not finite. Among equally near triangles the choice is
    /// arbitrary but always the same.
    pub fn project(&self, p: [f64; 3]) -> Option<Nearest> {
        if !p.iter().all(|x| x.is_finite()) {
            return None;
        }
        // Far beyond the mesh the squares would overflow; the answer does not change out there.
        let q = self.frame.inward(p).map(|x| x.clamp(-1e100, 1e100));
        let at = Vector::new(q[0], q[1], q[2]);
        let (leaf, (_, (weights, gap))) = self.tree.find_best(
            f64::MAX,
            |node, _| node.aabb().distance_to_local_point(at, true),
            |leaf, _| {
                let k = leaf as usize;
                let (weights, gap) = nearest_on_triangle(q, &self.corners[k]);
                Some((gap + if self.sliver[k] { SLIVER_COST } else { 0.0 }, (weights, gap)))
            },
        )?;
        let point = blend(&self.corners[leaf as usize], weights);
        Some(Nearest {
            point: self.frame.outward(point),
            triangle: self.ids[leaf as usize],
            barycentric: weights,
            distance: gap * self.frame.size,
        })
    }

    /// [`Closest::project`] for many points, in their order whatever the number of threads.
    pub fn project_all(&self, points: &[[f64; 3]]) -> Vec<Option<Nearest>> {
        points.par_iter().map(|&p| self.project(p)).collect()
    }
}

fn blend(corners: &[[f64; 3]; 3], w: [f64; 3]) -> [f64; 3] {
    add(add(scale(corners[0], w[0]), scale(corners[1], w[1])), scale(corners[2], w[2]))
}

/// Weights of the nearest point of a triangle, and its distance.
pub(crate) fn nearest_on_triangle(p: [f64; 3], t: &[[f64; 3]; 3]) -> ([f64; 3], f64) {
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    let mut offer = |w: [f64; 3]| {
        let gap = norm(sub(blend(t, w), p));
        if gap < best.1 {
            best = (w, gap);
        }
    };
    let (ab, ac, ap) = (sub(t[1], t[0]), sub(t[2], t[0]), sub(p, t[0]));
    let n = cross(ab, ac);
    let nn = dot(n, n);
    if nn > 0.0 {
        let (v, w) = (dot(cross(ap, ac), n) / nn, dot(cross(ab, ap), n) / nn);
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            offer([1.0 - v - w, v, w]);
        }
    }
    for k in 0..3 {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let side = sub(b, a);
        let (along, length2) = (dot(sub(p, a), side), dot(side, side));
        let s = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        let mut w = [0.0; 3];
        w[k] = 1.0 - s;
        w[(k + 1) % 3] = s;
        offer(w);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vec3::distance;
    use proptest::prelude::*;

    type P = [f64; 3];

    fn brute(p: P, positions: &[P], triangles: &[[u32; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| nearest_on_triangle(p, &t.map(|v| positions[v as usize])).1)
            .fold(f64::INFINITY, f64::min)
    }

    /// Parry's own answer for one triangle, by regions.
    fn parry(p: P, t: &[P; 3]) -> f64 {
        let v = |p: P| Vector::new(p[0], p[1], p[2]);
        parry3d_f64::shape::Triangle::new(v(t[0]), v(t[1]), v(t[2])).distance_to_local_point(v(p), true)
    }

    fn point() -> impl Strategy<Value = P> {
        prop::array::uniform3(-1.0..1.0f64)
    }

    proptest! {
        #[test]
        fn one_triangle_agrees_with_parry(t in prop::array::uniform3(point()), p in point()) {
            let (w, gap) = nearest_on_triangle(p, &t);
            prop_assert!((gap - parry(p, &t)).abs() < 1e-9, "{gap}");
            prop_assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && w.iter().all(|&x| x >= 0.0));
        }

        #[test]
        fn a_mesh_agrees_with_brute_force(
            positions in prop::collection::vec(point(), 12),
            triangles in prop::collection::vec(prop::array::uniform3(0u32..12), 1..40),
            queries in prop::collection::vec(point(), 20),
            exponent in -20i32..20, far in -1e3..1e3f64,
        ) {
            let s = 10f64.powi(exponent);
            let place = |p: &P| p.map(|x| s * (x + far));
            let positions: Vec<P> = positions.iter().map(place).collect();
            let queries: Vec<P> = queries.iter().map(place).collect();
            let all = Closest::new(&positions, &triangles).project_all(&queries);
            for (q, n) in queries.iter().zip(all) {
                let n = n.unwrap();
                prop_assert!((n.distance - brute(*q, &positions, &triangles)).abs() < 1e-9 * s);
                prop_assert!((distance(n.point, *q) - n.distance).abs() < 1e-9 * s);
                let t = triangles[n.triangle as usize].map(|v| positions[v as usize]);
                prop_assert!(distance(blend(&t, n.barycentric), n.point) < 1e-9 * s);
            }
        }
    }

    #[test]
    fn needles_and_points_are_found() {
        let needle = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-17, 0.0]];
        let c = Closest::new(&needle, &[[0, 1, 2], [0, 0, 0], [0, 1, 9]]);
        let n = c.project([0.25, 1.0, 0.0]).unwrap();
        assert!((n.distance - 1.0).abs() < 1e-12 && (n.point[0] - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_sliver_loses_ties() {
        let p = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for t in [[[0, 1, 2], [0, 1, 3]], [[0, 1, 3], [0, 1, 2]]] {
            let n = Closest::new(&p, &t).project([0.5, -1.0, 0.0]).unwrap();
            assert_eq!(t[n.triangle as usize], [0, 1, 3]);
        }
    }

    #[test]
    fn nothing_is_found_in_nothing() {
        assert!(Closest::new(&[], &[]).project([0.0; 3]).is_none());
        let bad = [[f64::NAN; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(Closest::new(&bad, &[[0, 1, 2]]).is_empty());
        let c = Closest::new(&bad, &[[0, 1, 2], [1, 2, 3]]);
        assert!(c.project([f64::INFINITY, 0.0, 0.0]).is_none());
        assert_eq!(c.project([1e300, 0.0, 0.0]).unwrap().triangle, 1);
    }
}
