//! Closes openings: the ends of limbs that clothes hide, the rims of plates of armour. Beside an opening no triangle tells inside from outside, and cloth would go in.

use std::collections::{BTreeMap, HashMap};

use gimage_bundle::{Body, DisjointSets};

use crate::base::halfedge::{origin, sorted_edges, target};
use crate::base::joints::strongest;
use crate::base::vec3::{add, cross, distance, dot, norm, normalize, scale, sub};

/// Largest mean distance of the corners of an opening from its plane, as a share of their mean distance from its middle.
const FLAT: f64 = 0.3;
/// Largest area of an opening as a share of that of its component: the outline of a sheet does not count.
const MOST: f64 = 0.4;
/// How far the middle is within the opening, as a share of the mean distance of its corners.
const DENT: f64 = 0.1;
/// Cosine of the normals of the body and of the fan at a side, below which body in front of the fan lies on it: its border is turned over, and the crack between both would be outside.
const FOLDED: f64 = -0.5;

/// Closes the openings that are about flat, that their middle sees all around, and whose border is not turned over in front of them, each by a fan around a new vertex, which follows the joints of the corners. Returns their
/// number. O(n log n).
pub(super) fn close(body: &mut Body) -> usize {
    let mut parts = DisjointSets::new(body.positions.len());
    for t in &body.triangles {
        parts.union(t[0], t[1]);
        parts.union(t[0], t[2]);
    }
    let at = |v: u32| body.positions[v as usize].map(f64::from);
    let mut areas: HashMap<u32, f64> = HashMap::new();
    for [a, b, c] in &body.triangles {
        *areas.entry(parts.find(*a)).or_default() += area(at(*a), at(*b), at(*c));
    }
    let beyond: HashMap<[u32; 2], u32> =
        body.triangles.iter().flat_map(|[a, b, c]| [([*a, *b], *c), ([*b, *c], *a), ([*c, *a], *b)]).collect();
    let mut closed = Vec::new();
    for ring in rings(&body.triangles) {
        let corners: Vec<[f64; 3]> = ring.iter().map(|v| at(*v)).collect();
        let most = MOST * areas.get(&parts.find(ring[0])).copied().unwrap_or(0.0);
        let Some(middle) = middle(&corners, most) else { continue };
        let sides = ring.iter().zip(ring.iter().cycle().skip(1));
        let mut corners = sides.map(|(a, b)| [*a, *b, beyond[&[*a, *b]]].map(at));
        if !corners.any(|side| is_folded(&side, middle)) {
            closed.push((ring, middle));
        }
    }
    let sets = body.sets();
    for (ring, middle) in &closed {
        let own = body.positions.len() as u32;
        let (joints, weights) = shared(body, ring, sets);
        body.positions.push(middle.map(|x| x as f32));
        body.joints.extend(joints);
        body.weights.extend(weights);
        let next = ring.iter().cycle().skip(1);
        body.triangles.extend(ring.iter().zip(next).map(|(a, b)| [*b, *a, own]));
    }
    closed.len()
}

/// Closed rings of sides without a neighbour, each of whose corners has one such side before it and one after it. Deterministic.
fn rings(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let (mut next, mut ways): (BTreeMap<u32, u32>, HashMap<u32, [u32; 2]>) = Default::default();
    let sides = sorted_edges(triangles);
    for side in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|run| run.len() == 1) {
        let [a, b] = [origin(triangles, side[0].2), target(triangles, side[0].2)];
        next.insert(a, b);
        ways.entry(a).or_default()[0] += 1;
        ways.entry(b).or_default()[1] += 1;
    }
    let mut out = Vec::new();
    while let Some((first, mut at)) = next.pop_first() {
        let mut ring = vec![first];
        while at != first {
            ring.push(at);
            let Some(then) = next.remove(&at) else { break };
            at = then;
        }
        if at == first && ring.len() > 2 && ring.iter().all(|v| ways.get(v) == Some(&[1, 1])) {
            out.push(ring);
        }
    }
    out
}

/// The middle of an opening that can be closed, of at most this area \[m2\].
fn middle(corners: &[[f64; 3]], most: f64) -> Option<[f64; 3]> {
    let after = |k: usize| corners[(k + 1) % corners.len()];
    let length: f64 = (0..corners.len()).map(|k| distance(corners[k], after(k))).sum();
    // Sides count by their length, so that the density of vertices has no effect.
    let sum = (0..corners.len())
        .map(|k| scale(add(corners[k], after(k)), 0.5 * distance(corners[k], after(k))))
        .fold([0.0; 3], add);
    let middle = scale(sum, 1.0 / length.max(1e-300));
    let faces: Vec<[f64; 3]> =
        (0..corners.len()).map(|k| cross(sub(after(k), middle), sub(corners[k], middle))).collect();
    let whole = faces.iter().copied().fold([0.0; 3], add);
    let normal = normalize(whole);
    let away = corners.iter().map(|p| dot(sub(*p, middle), normal).abs()).sum::<f64>();
    let far = corners.iter().map(|p| distance(*p, middle)).sum::<f64>();
    let sees = faces.iter().all(|face| dot(*face, normal) >= 0.0);
    // Within the opening: cloth around its rim, such as a collar around the end of a neck, keeps its place.
    let middle = sub(middle, scale(normal, DENT * far / corners.len() as f64));
    (sees && norm(whole) > 0.0 && away <= FLAT * far && 0.5 * norm(whole) <= most).then_some(middle)
}

/// Whether a triangle of the body at an opening, whose first two corners are of the opening, lies in front of the fan around a point.
fn is_folded([a, b, c]: &[[f64; 3]; 3], middle: [f64; 3]) -> bool {
    let [fan, own] = [cross(sub(*a, *b), sub(middle, *b)), cross(sub(*b, *a), sub(*c, *a))];
    dot(sub(*c, *a), fan) > 0.0 && dot(fan, own) < FOLDED * norm(fan) * norm(own)
}

/// The strongest joints of some vertices together, with weights that sum to 1.
fn shared(body: &Body, ring: &[u32], sets: usize) -> (Vec<[u32; 4]>, Vec<[f32; 4]>) {
    let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
    for k in ring.iter().flat_map(|v| *v as usize * sets..(*v as usize + 1) * sets) {
        for (joint, weight) in body.joints[k].iter().zip(body.weights[k]) {
            *sum.entry(*joint).or_default() += f64::from(weight);
        }
    }
    let (mut joints, mut weights) = (vec![[0; 4]; sets], vec![[0.0; 4]; sets]);
    for (k, (joint, weight)) in strongest(sum, 4 * sets).into_iter().enumerate() {
        (joints[k / 4][k % 4], weights[k / 4][k % 4]) = (joint, weight as f32);
    }
    (joints, weights)
}

fn area(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tube along y of `around` sides, in two joints, without its ends.
    fn tube(around: u32, wave: f32) -> Body {
        let mut body = Body::default();
        for j in 0..2u32 {
            for i in 0..around {
                let a = std::f32::consts::TAU * i as f32 / around as f32;
                body.positions.push([a.cos(), 3.0 * j as f32 + wave * (2.0 * a).sin(), a.sin()]);
                body.joints.push([j, 2, 0, 0]);
                body.weights.push([0.75, 0.25, 0.0, 0.0]);
            }
        }
        for i in 0..around {
            let (k, to) = (i, (i + 1) % around);
            body.triangles.extend([[k, k + around, to], [to, k + around, to + around]]);
        }
        body
    }

    #[test]
    fn the_ends_of_a_tube_are_closed_and_follow_their_joints() {
        let mut body = tube(12, 0.0);
        assert_eq!(close(&mut body), 2);
        assert_eq!((body.triangles.len(), body.positions.len()), (48, 26));
        assert_eq!(body.fault(3), None);
        let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
        body.triangles.iter().for_each(|t| (0..3).for_each(|c| *sides.entry([t[c], t[(c + 1) % 3]]).or_default() += 1));
        assert!(sides.iter().all(|([a, b], n)| *n == 1 && sides.contains_key(&[*b, *a])));
        // The volume of twelve sides around a circle, 3 m long, without two cones 0.1 m high.
        let at = |v: u32| body.positions[v as usize].map(f64::from);
        let volume: f64 = body.triangles.iter().map(|t| dot(at(t[0]), cross(at(t[1]), at(t[2]))) / 6.0).sum();
        assert!((volume - 8.8).abs() < 1e-5, "{volume}");
        let (joints, weights) = (&body.joints[24..], &body.weights[24..]);
        assert_eq!(joints, [[0, 2, 0, 0], [1, 2, 0, 0]]);
        assert!(weights.iter().all(|w| (w[0] - 0.75).abs() < 1e-6 && (w[1] - 0.25).abs() < 1e-6), "{weights:?}");
        assert_eq!(close(&mut body), 0);
    }

    #[test]
    fn openings_that_are_not_flat_and_sheets_stay_open() {
        assert_eq!(close(&mut tube(12, 0.2)), 2);
        assert_eq!(close(&mut tube(12, 0.8)), 0);
        let mut sheet = Body {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Body::default()
        };
        assert_eq!(close(&mut sheet), 0);
    }

    #[test]
    fn an_opening_whose_border_is_turned_over_in_front_of_it_stays_open() {
        // A tube whose upper end widens, as that of a trumpet: flat, or drooping, or as a funnel.
        for (rise, closed) in [(-0.3, 1), (0.0, 1), (0.3, 2)] {
            let mut body = tube(12, 0.0);
            for i in 0..12u32 {
                let a = std::f32::consts::TAU * i as f32 / 12.0;
                body.positions.push([1.5 * a.cos(), 3.0 + rise, 1.5 * a.sin()]);
                body.joints.push([1, 2, 0, 0]);
                body.weights.push([0.75, 0.25, 0.0, 0.0]);
                let (k, to) = (12 + i, 12 + (i + 1) % 12);
                body.triangles.extend([[k, k + 12, to], [to, k + 12, to + 12]]);
            }
            assert_eq!(close(&mut body), closed, "{rise}");
        }
    }
}
