//! The poses of a body in the animations of its file: few of them, as different from one another as possible.

use gimage_bundle::{Body, Winding};

use crate::base::closest::Closest;
use crate::base::mesh::Skeleton;
use crate::base::vec3::{add, cross, dot, scale, sub};
use crate::stage::import::{Character, inverse};

/// Poses looked at.
const MOST_POSES: usize = 32;
/// Time \[s\] between the poses of an animation to choose from, most of one, and most of all.
const EVERY_S: f64 = 0.125;
const MOST_OF_ONE: usize = 64;
const MOST_OF_ALL: usize = 2048;
/// Poses are alike if the squares of what their joints differ by sum to less: a single joint that turns by 0.1 rad, or goes 14 mm, has this.
const ALIKE: f64 = 0.02;
/// Weight of a metre that a joint goes, beside the entries of its rotation.
const PER_METRE: f64 = 10.0;
/// Winding number from which a point is inside.
const INSIDE: f64 = 0.5;

type Matrix = [f64; 16];
type V3 = [f64; 3];

/// A body whose joints move it.
pub struct Motion<'a> {
    pub(super) body: &'a Body,
    /// For each pose the matrices of the joints, from the pose in which the mesh is bound.
    pub(super) poses: Vec<Vec<Matrix>>,
}

impl<'a> Motion<'a> {
    /// From the animations of a character, and the skeleton of the mesh that its import has; `None` without an animation that moves it.
    ///
    /// Poses are chosen by farthest-point sampling (Gonzalez, 1985) of the places of joints against their parents, from the pose in which the mesh is bound on:
    /// where the whole character goes does not count.
    pub fn new(body: &'a Body, animations: &[Character], skeleton: &Skeleton) -> Option<Self> {
        let joints = &skeleton.joints;
        if body.joints.is_empty() || joints.is_empty() {
            return None;
        }
        let most = MOST_OF_ONE.min(MOST_OF_ALL.div_ceil(animations.len().max(1)));
        let bound = joints.iter().map(|j| inverse(&j.inverse_bind)).collect::<Option<Vec<_>>>()?;
        let mut all: Vec<(Vec<Matrix>, Vec<f64>)> = vec![(Vec::new(), bends(skeleton, &bound))];
        for animation in animations {
            let nodes: Option<Vec<usize>> = joints.iter().map(|j| animation.node(&j.name).ok()).collect();
            let Some(nodes) = nodes else { continue };
            let steps = ((animation.seconds() / EVERY_S) as usize).min(most.saturating_sub(1)).max(1);
            for step in 0..=steps {
                let worlds = animation.worlds(animation.seconds() * step as f64 / steps as f64);
                let worlds: Vec<Matrix> = nodes.iter().map(|n| worlds[*n]).collect();
                let bends = bends(skeleton, &worlds);
                all.push((worlds, bends));
            }
        }
        let poses: Vec<Vec<Matrix>> = farthest(&all.iter().map(|(_, bends)| &bends[..]).collect::<Vec<_>>())
            .into_iter()
            .map(|k| all[k].0.iter().zip(joints).map(|(world, joint)| times(world, &joint.inverse_bind)).collect())
            .collect();
        (!poses.is_empty()).then_some(Motion { body, poses })
    }

    /// The body in each pose.
    pub(super) fn poses(&self) -> impl Iterator<Item = Posed<'_>> {
        self.poses.iter().map(|matrices| Posed::new(self.body, matrices))
    }
}

/// The body in a pose.
pub(super) struct Posed<'a> {
    matrices: &'a [Matrix],
    corners: Vec<[V3; 3]>,
    closest: Closest,
    winding: Winding,
}

impl<'a> Posed<'a> {
    fn new(body: &Body, matrices: &'a [Matrix]) -> Self {
        let sets = body.sets();
        let place = |(v, p): (usize, &[f32; 3])| {
            let own = body.joints[v * sets..].iter().zip(&body.weights[v * sets..]).take(sets);
            let each =
                own.flat_map(|(joints, weights)| joints.iter().copied().zip(weights.iter().map(|w| f64::from(*w))));
            skinned(matrices, each, p.map(f64::from))
        };
        let positions: Vec<V3> = body.positions.iter().enumerate().map(place).collect();
        let corners: Vec<[V3; 3]> = body.triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect();
        let closest = Closest::new(&positions, &body.triangles);
        Posed { matrices, winding: Winding::new(corners.iter().copied()), closest, corners }
    }

    /// Where this pose puts a point of cloth that follows four joints.
    pub fn place(&self, (joints, weights): &([f32; 4], [f32; 4]), p: V3) -> V3 {
        skinned(self.matrices, joints.iter().map(|j| *j as u32).zip(weights.iter().map(|w| f64::from(*w))), p)
    }

    /// Whether a point is deeper \[m\] than `least` inside. Only points behind their nearest triangle pay for a winding number.
    pub fn is_deeper(&self, p: V3, least: f64) -> bool {
        let Some(near) = self.closest.project(p) else { return false };
        let [a, b, c] = self.corners[near.triangle as usize];
        let is_behind = dot(cross(sub(b, a), sub(c, a)), sub(p, near.point)) < 0.0;
        is_behind && near.distance > least && self.winding.number(p) > INSIDE
    }
}

/// Linear blend skinning.
fn skinned(matrices: &[Matrix], influences: impl Iterator<Item = (u32, f64)>, p: V3) -> V3 {
    let moved = |m: &Matrix| [0, 1, 2].map(|c| m[c] * p[0] + m[4 + c] * p[1] + m[8 + c] * p[2] + m[12 + c]);
    let each = influences.filter(|x| x.1 > 0.0);
    let sum = each.filter_map(|(j, w)| Some((matrices.get(j as usize)?, w)));
    sum.fold([0.0; 3], |sum, (m, w)| add(sum, scale(moved(m), w)))
}

/// The places of joints against their parents, one after the other.
fn bends(skeleton: &Skeleton, worlds: &[Matrix]) -> Vec<f64> {
    let own = skeleton.joints.iter().zip(worlds).filter_map(|(joint, world)| {
        let parent = inverse(&worlds[joint.parent? as usize])?;
        let local = times(&parent, world);
        Some([0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14].map(|k| if k < 12 { local[k] } else { PER_METRE * local[k] }))
    });
    own.flatten().collect()
}

/// The poses that differ most from the first one and from one another, without it.
fn farthest(all: &[&[f64]]) -> Vec<usize> {
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let mut nearest: Vec<f64> = all.iter().map(|pose| apart(pose, all[0])).collect();
    let mut chosen = Vec::new();
    while chosen.len() < MOST_POSES {
        // Of equals the first.
        let farther = |best: usize, k: usize| if nearest[k] > nearest[best] { k } else { best };
        let next = (0..all.len()).fold(0, farther);
        if nearest[next] < ALIKE {
            break;
        }
        chosen.push(next);
        nearest.iter_mut().zip(all).for_each(|(near, pose)| *near = near.min(apart(pose, all[next])));
    }
    chosen
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_chosen_that_differ_and_no_two_alike() {
        let all: [&[f64]; 6] = [&[0.0, 0.0], &[0.1, 0.0], &[3.0, 0.0], &[3.05, 0.0], &[0.0, 1.0], &[0.0, 0.0]];
        assert_eq!(farthest(&all), [3, 4]);
        assert_eq!(farthest(&all[..2]), [0usize; 0]);
        let many: Vec<Vec<f64>> = (0..100).map(|k| vec![f64::from(k)]).collect();
        let chosen = farthest(&many.iter().map(|x| &x[..]).collect::<Vec<_>>());
        assert_eq!((chosen.len(), &chosen[..2]), (MOST_POSES, &[99, 49][..]));
        assert!(chosen.iter().all(|k| *k > 0));
    }

    #[test]
    fn where_the_whole_character_goes_does_not_count() {
        use crate::base::mesh::Joint;
        let at = |x: f64| {
            let mut m = [0.0; 16];
            [0, 5, 10, 15].iter().for_each(|k| m[*k] = 1.0);
            m[12] = x;
            m
        };
        let turned = |x: f64| Matrix::from([0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.]);
        let joint = |parent| Joint { name: String::new(), parent, inverse_bind: at(0.0), world: at(0.0) };
        let skeleton = Skeleton { joints: vec![joint(None), joint(Some(0))] };
        let rest = bends(&skeleton, &[at(0.0), at(1.0)]);
        assert_eq!(rest, bends(&skeleton, &[at(5.0), at(6.0)]));
        let quarter = |y: f64| Matrix::from([0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 1., 0., 5., y, 0., 1.]);
        let turned_all = bends(&skeleton, &[quarter(5.0), quarter(6.0)]);
        assert!(rest.iter().zip(&turned_all).all(|(a, b)| (a - b).abs() < 1e-9), "{turned_all:?}");
        assert_ne!(rest, bends(&skeleton, &[at(0.0), at(1.5)]));
        assert_ne!(rest, bends(&skeleton, &[at(0.0), turned(1.0)]));
    }
}
