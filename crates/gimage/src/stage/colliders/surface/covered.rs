//! Leaves out triangles that other components cover: an arm that is a part of its own ends inside of the chest. From inside of both no way leads out over them.

use gimage_bundle::{Body, DisjointSets, Winding};
use rayon::prelude::*;

use crate::base::vec3::{add, cross, norm, normalize, scale, sub};

/// Winding number from which a point is inside of a component.
const INSIDE: f64 = 0.5;
/// Points of a triangle that must be inside, as weights of its corners: near the corners, and the middle.
const POINTS: [[f64; 3]; 4] = [[0.98, 0.01, 0.01], [0.01, 0.98, 0.01], [0.01, 0.01, 0.98], [1.0 / 3.0; 3]];

/// The distance of the points in front of their triangle, as a share of the diagonal of the body: copies of one component do not cover each other.
const IN_FRONT: f64 = 1e-4;

/// A connected component.
struct Part {
    bounds: [[f64; 3]; 2],
    winding: Winding,
}

impl Part {
    fn has(&self, p: [f64; 3]) -> bool {
        let near = (0..3).all(|c| p[c] >= self.bounds[0][c] && p[c] <= self.bounds[1][c]);
        near && self.winding.number(p) > INSIDE
    }
}

/// Drops the triangles that are inside of another component, and the vertices that none is left of. O(n log n), and O(components) per triangle.
pub(super) fn drop_covered(body: &mut Body) {
    let mut sets = DisjointSets::new(body.positions.len());
    for [a, b, c] in &body.triangles {
        sets.union(*a, *b);
        sets.union(*a, *c);
    }
    let of: Vec<u32> = body.triangles.iter().map(|t| sets.find(t[0])).collect();
    let mut names = of.clone();
    names.sort_unstable();
    names.dedup();
    if names.len() < 2 {
        return;
    }
    let corners: Vec<[[f64; 3]; 3]> =
        body.triangles.iter().map(|t| t.map(|v| body.positions[v as usize].map(f64::from))).collect();
    let mut own: Vec<Vec<[[f64; 3]; 3]>> = vec![Vec::new(); names.len()];
    for (corners, of) in corners.iter().zip(&of) {
        own[names.partition_point(|name| name < of)].push(*corners);
    }
    let part = |own: Vec<[[f64; 3]; 3]>| {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for p in own.iter().flatten() {
            (0..3).for_each(|c| bounds[0][c] = bounds[0][c].min(p[c]));
            (0..3).for_each(|c| bounds[1][c] = bounds[1][c].max(p[c]));
        }
        Part { bounds, winding: Winding::new(own.into_iter()) }
    };
    let parts: Vec<Part> = own.into_iter().map(part).collect();
    let span = |c: usize| {
        let all = || parts.iter().map(|part| part.bounds);
        all().map(|b| b[1][c]).fold(f64::NEG_INFINITY, f64::max) - all().map(|b| b[0][c]).fold(f64::INFINITY, f64::min)
    };
    let far = IN_FRONT * norm([0, 1, 2].map(span));
    let is_seen = |(corners, name): (&[[f64; 3]; 3], &u32)| {
        let [a, b, c] = *corners;
        let front = scale(normalize(cross(sub(b, a), sub(c, a))), far);
        let point = |w: [f64; 3]| add(front, [0, 1, 2].map(|k| (0..3).map(|c| w[c] * corners[c][k]).sum::<f64>()));
        let is_covered = |p: [f64; 3]| names.iter().zip(&parts).any(|(other, part)| other != name && part.has(p));
        !POINTS.into_iter().all(|w| is_covered(point(w)))
    };
    let seen: Vec<bool> = corners.par_iter().zip(&of).map(is_seen).collect();
    let mut kept = seen.iter();
    body.triangles.retain(|_| *kept.next().unwrap_or(&true));
    compact(body);
}

/// Drops vertices that no triangle has.
fn compact(body: &mut Body) {
    let sets = body.joints.len() / body.positions.len().max(1);
    let mut number = vec![u32::MAX; body.positions.len()];
    let mut used: Vec<u32> = body.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.iter().enumerate().for_each(|(n, v)| number[*v as usize] = n as u32);
    body.positions = used.iter().map(|v| body.positions[*v as usize]).collect();
    let of = |v: &u32| *v as usize * sets..(*v as usize + 1) * sets;
    body.joints = used.iter().flat_map(of).map(|k| body.joints[k]).collect();
    body.weights = used.iter().flat_map(of).map(|k| body.weights[k]).collect();
    body.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box that follows a joint.
    fn cuboid(low: [f32; 3], high: [f32; 3], joint: u32, body: &mut Body) {
        let at = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 1 { high[c] } else { low[c] });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let first = body.positions.len() as u32;
        let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        body.triangles.extend(triangles.map(|t| t.map(|v| first + v)));
        body.positions.extend((0..8).map(at));
        body.joints.extend([[joint, 0, 0, 0]; 8]);
        body.weights.extend([[1.0, 0.0, 0.0, 0.0]; 8]);
    }

    #[test]
    fn the_end_of_an_arm_inside_of_a_chest_is_dropped() {
        let mut body = Body::default();
        cuboid([0.0; 3], [1.0; 3], 1, &mut body);
        // Its end is inside, its sides reach from inside to outside.
        cuboid([0.8, 0.4, 0.4], [2.0, 0.6, 0.6], 2, &mut body);
        cuboid([0.3; 3], [0.4; 3], 3, &mut body);
        drop_covered(&mut body);
        assert_eq!((body.triangles.len(), body.positions.len()), (12 + 10, 16));
        assert_eq!((body.joints.len(), body.weights.len()), (16, 16));
        assert!(body.triangles.iter().flatten().all(|v| *v < 16));
        assert!(body.joints[..8].iter().all(|j| j[0] == 1) && body.joints[8..].iter().all(|j| j[0] == 2));
        let same = body.clone();
        drop_covered(&mut body);
        assert_eq!(body, same);
    }

    #[test]
    fn copies_of_one_component_do_not_cover_each_other() {
        let mut body = Body::default();
        cuboid([0.0; 3], [1.0; 3], 1, &mut body);
        cuboid([0.0; 3], [1.0; 3], 1, &mut body);
        drop_covered(&mut body);
        assert_eq!(body.triangles.len(), 24);
        // One that faces inwards has its front inside of the other one.
        body.triangles[12..].iter_mut().for_each(|t| t.swap(0, 1));
        drop_covered(&mut body);
        assert_eq!(body.triangles.len(), 12);
    }
}
