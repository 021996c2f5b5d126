//! The nearest point of a triangle mesh: the one module that names parry.
//!
//! The tree and its traversal are parry's. The distance to one triangle is computed here, as the best of its face and
//! its three sides: a region test on a needle can name the wrong side, the least of four points on it cannot.

use crate::base::frame::{Frame, usable_corners, usable_of, used_positions};
use crate::base::vec3::{add, cross, dot, norm, normalize, scale, sub};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::{PointQuery, Ray};
use rayon::prelude::*;
use std::cell::Cell;

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
    /// Unit normals; zero where the corners do not tell them surely.
    normals: Vec<[f64; 3]>,
    sliver: Vec<bool>,
}

/// Distance added for a triangle without an area, in units of the mesh's size: it loses ties against neighbours
/// that have a normal.
const SLIVER_COST: f64 = 1e-12;

/// Twice the area over the square of the longer of two sides above which a triangle's normal is sure to 1e-9.
const SURE: f64 = 1e-6;

/// More than what a sure normal can be wrong about a distance to the plane, in units of the mesh's size.
const PLANE_ERROR: f64 = 1e-8;

impl Closest {
    /// Builds the tree, O(n log n).
    pub fn new(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let frame = Frame::around(used_positions(positions, triangles));
        let (corners, ids) = usable_corners(&frame, positions, triangles);
        Self::build(frame, corners, ids)
    }

    /// As [`Closest::new`], for triangles given by the positions of their corners.
    pub(crate) fn of(triangles: &[[[f64; 3]; 3]]) -> Self {
        let frame = Frame::around(triangles.iter().flatten().copied());
        let (corners, ids) = usable_of(&frame, triangles.iter().map(|t| t.map(Some)));
        Self::build(frame, corners, ids)
    }

    fn build(frame: Frame, corners: Vec<[[f64; 3]; 3]>, ids: Vec<u32>) -> Self {
        let vector = |p: [f64; 3]| Vector::new(p[0], p[1], p[2]);
        let boxes = corners.iter().map(|c| {
            let (a, b, c) = (vector(c[0]), vector(c[1]), vector(c[2]));
            Aabb::new(a.min(b).min(c), a.max(b).max(c))
        });
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
        let flatness = |&[a, b, c]: &[[f64; 3]; 3]| {
            let (ab, ac) = (sub(b, a), sub(c, a));
            (cross(ab, ac), dot(ab, ab).max(dot(ac, ac)))
        };
        let sliver = corners.iter().map(flatness).map(|(n, side2)| norm(n) <= 1e-12 * side2).collect();
        let normal = |(n, side2): ([f64; 3], f64)| if norm(n) > SURE * side2 { normalize(n) } else { [0.0; 3] };
        let normals = corners.iter().map(flatness).map(normal).collect();
        Self { frame, tree, corners, ids, normals, sliver }
    }

    /// Whether there is nothing to find.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The nearest point; `None` if the mesh is empty or `p` not finite. Among equally near triangles the choice is
    /// arbitrary but always the same.
    pub fn project(&self, p: [f64; 3]) -> Option<Nearest> {
        self.counted(p).0
    }

    /// [`Closest::project`], and how many boxes and triangles it looked at: its cost, the same on every machine.
    pub(crate) fn counted(&self, p: [f64; 3]) -> (Option<Nearest>, u32) {
        if !p.iter().all(|x| x.is_finite()) {
            return (None, 0);
        }
        // Far beyond the mesh the squares would overflow; the answer does not change out there.
        let q = self.frame.inward(p).map(|x| x.clamp(-1e100, 1e100));
        let at = Vector::new(q[0], q[1], q[2]);
        let visits = Cell::new(0u32);
        let visit = || visits.set(visits.get().saturating_add(1));
        let found = self.tree.find_best(
            f64::MAX,
            |node, _| {
                visit();
                node.aabb().distance_to_local_point(at, true)
            },
            |leaf, best| {
                visit();
                let k = leaf as usize;
                // The plane is no farther than the triangle: where triangles overlap most end here.
                if dot(self.normals[k], sub(q, self.corners[k][0])).abs() > best * (1.0 + PLANE_ERROR) + PLANE_ERROR {
                    return None;
                }
                let (weights, gap) = nearest_on_triangle(q, &self.corners[k]);
                Some((gap + if self.sliver[k] { SLIVER_COST } else { 0.0 }, (weights, gap)))
            },
        );
        let near = found.map(|(leaf, (_, (weights, gap)))| Nearest {
            point: self.frame.outward(blend(&self.corners[leaf as usize], weights)),
            triangle: self.ids[leaf as usize],
            barycentric: weights,
            distance: gap * self.frame.size,
        });
        (near, visits.get())
    }

    /// Distance \[m\] from `p` along the unit vector `direction` to the first triangle that `is_hit` accepts, at most `most`
    /// \[m\], and that triangle; `None` also if `p` or `direction` is not finite. `is_hit` gets a triangle and its unit normal, zero for a sliver.
    /// O(log n) as a rule.
    pub fn along(
        &self,
        p: [f64; 3],
        direction: [f64; 3],
        most: f64,
        is_hit: impl Fn(u32, [f64; 3]) -> bool,
    ) -> Option<(f64, u32)> {
        if !p.iter().chain(&direction).all(|x| x.is_finite()) {
            return None;
        }
        let q = self.frame.inward(p);
        let vector = |p: [f64; 3]| Vector::new(p[0], p[1], p[2]);
        let ray = Ray::new(vector(q), vector(direction));
        let hit = self.tree.cast_ray(&ray, most / self.frame.size, |leaf, _| {
            let k = leaf as usize;
            let at = ray_on_triangle(q, direction, &self.corners[k])?;
            is_hit(self.ids[k], self.normals[k]).then_some(at)
        });
        hit.map(|(leaf, at)| (at * self.frame.size, self.ids[leaf as usize])).filter(|hit| hit.0 <= most)
    }

    /// [`Closest::project`] for many points, in their order whatever the number of threads.
    pub fn project_all(&self, points: &[[f64; 3]]) -> Vec<Option<Nearest>> {
        points.par_iter().map(|&p| self.project(p)).collect()
    }
}

fn blend(corners: &[[f64; 3]; 3], w: [f64; 3]) -> [f64; 3] {
    add(add(scale(corners[0], w[0]), scale(corners[1], w[1])), scale(corners[2], w[2]))
}

/// Where a ray from `p` meets a triangle, in lengths of `d` (Moeller and Trumbore, 1997); `None` behind `p`, beside the
/// triangle, and within its plane.
fn ray_on_triangle(p: [f64; 3], d: [f64; 3], t: &[[f64; 3]; 3]) -> Option<f64> {
    let (ab, ac, ap) = (sub(t[1], t[0]), sub(t[2], t[0]), sub(p, t[0]));
    let across = cross(d, ac);
    let det = dot(ab, across);
    if det == 0.0 {
        return None;
    }
    let v = dot(ap, across) / det;
    let along = cross(ap, ab);
    let (w, at) = (dot(d, along) / det, dot(ac, along) / det);
    (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && at >= 0.0 && at.is_finite()).then_some(at)
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
    use crate::base::vec3::distance;
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
    fn triangles_that_overlap_are_told_apart_exactly() {
        let mut draw = crate::base::shapes::random(5);
        let mut coordinate = || draw(1 << 20) as f64 / f64::from(1 << 20) - 0.5;
        let mut positions: Vec<P> = (0..600).map(|_| [0, 1, 2].map(|_| coordinate())).collect();
        // Needles, whose normals are not sure, among them.
        for k in (0..600).step_by(30) {
            positions[k + 2] =
                crate::base::vec3::lerp(positions[k], positions[k + 1], 0.3).map(|x| x + 1e-13 * coordinate());
        }
        let triangles: Vec<[u32; 3]> = (0..200).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let c = Closest::new(&positions, &triangles);
        for far in [1.0, 1e3, 1e9] {
            for _ in 0..200 {
                let p = [0, 1, 2].map(|_| far * coordinate());
                let (near, visits) = c.counted(p);
                assert!((near.unwrap().distance - brute(p, &positions, &triangles)).abs() <= 1e-12 * far);
                assert!(visits > 0);
            }
        }
    }

    #[test]
    fn a_ray_finds_the_first_triangle_that_is_accepted() {
        let p = [[0., 0., 0.], [3., 0., 0.], [0., 3., 0.], [0., 0., 2.], [3., 0., 2.], [0., 3., 2.]];
        let c = Closest::new(&p, &[[3, 4, 5], [0, 1, 2]]);
        let up = |most, skip| c.along([1.0, 1.0, -1.0], [0.0, 0.0, 1.0], most, |t, n| n[2] > 0.9 && t != skip);
        assert_eq!(up(9.0, 9).map(|h| h.1), Some(1));
        assert!((up(9.0, 1).unwrap().0 - 3.0).abs() < 1e-12);
        assert_eq!((up(2.5, 1), up(0.5, 9)), (None, None));
        assert!(c.along([1.0, 1.0, 1.0], [0.0, 0.0, 1.0], 9.0, |t, _| t == 1).is_none());
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
