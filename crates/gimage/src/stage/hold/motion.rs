//! The poses of a body in the animations of its file: few of them, as different from one another as possible.

use gimage_bundle::{Body, Winding};

use crate::base::closest::Closest;
use crate::base::mesh::{Mesh, Skeleton};
use crate::base::vec3::{add, cross, dot, norm, scale, sub};
use crate::stage::import::{Character, inverse, matrix};

/// Poses looked at.
const MOST_POSES: usize = 32;
/// Animations looked at.
pub(crate) const MOST_ANIMATIONS: usize = 256;
/// Time \[s\] between the poses of an animation to choose from, most of one, most of all, and most joints of all of them.
const EVERY_S: f64 = 0.125;
const MOST_OF_ONE: usize = 64;
const MOST_OF_ALL: usize = 2048;
const MOST_JOINTS: usize = 1 << 17;
/// Poses are alike if the squares of what their joints differ by sum to less: a single joint that turns by 0.1 rad, or goes 50 mm, has this.
const ALIKE: f64 = 0.02;
/// Weight of a metre that a joint goes, beside the entries of its rotation.
const PER_METRE: f64 = 3.0;
/// Winding number from which a point is inside.
const INSIDE: f64 = 0.5;

type Matrix = [f64; 16];
type V3 = [f64; 3];

/// A body whose joints move it.
pub struct Motion<'a> {
    pub(super) body: &'a Body,
    /// For each pose the matrices of the joints, from the pose in which the mesh is bound; zero of joints that move nothing.
    pub(super) poses: Vec<Vec<Matrix>>,
}

/// The poses of animations to choose from.
pub struct Poses<'a> {
    body: &'a Body,
    skeleton: &'a Skeleton,
    /// The joints that move the body or the cloth, each with the nearest ancestor among them, or else with the first of them.
    used: Vec<(usize, usize)>,
    /// For each pose the transforms of those joints to world space, and what it is compared by.
    all: Vec<(Vec<Matrix>, Vec<f64>)>,
}

impl<'a> Poses<'a> {
    /// None yet. `mesh` is that of the cloth; `None` if no joint moves the body.
    pub fn new(body: &'a Body, mesh: &'a Mesh) -> Option<Self> {
        let joints = &mesh.skeleton.joints;
        let mut used = mesh.followed(|_| true);
        let weights = body.joints.iter().flatten().zip(body.weights.iter().flatten());
        used.extend(weights.filter(|(_, w)| **w > 0.0).map(|(joint, _)| *joint));
        let is_used = |j: u32| used.contains(&j);
        let mut list: Vec<u32> = used.iter().copied().filter(|j| (*j as usize) < joints.len()).collect();
        list.sort_unstable();
        let first = *list.first().filter(|_| !body.joints.is_empty())? as usize;
        let anchor = |j: u32| {
            let up = |k: &u32| joints[*k as usize].parent;
            // A cycle of parents would end nowhere.
            let mut above = std::iter::successors(Some(j), up).skip(1).take(joints.len());
            above.find(|k| is_used(*k)).map_or(first, |k| k as usize)
        };
        let used = list.iter().map(|j| (*j as usize, anchor(*j))).collect();
        let mut poses = Poses { body, skeleton: &mesh.skeleton, used, all: Vec::new() };
        // The pose in which the mesh is bound.
        let bound: Vec<Matrix> =
            joints.iter().map(|joint| inverse(&joint.inverse_bind).unwrap_or(joint.world)).collect();
        poses.add(|j| bound[j]);
        Some(poses)
    }

    /// Adds poses of one animation of `count`. An animation of a file that lacks a joint has none.
    pub fn read(&mut self, animation: &Character, count: usize) {
        let name = |j: usize| animation.node(&self.skeleton.joints[j].name).ok();
        let Some(nodes) = self.used.iter().map(|(j, _)| Some((*j, name(*j)?))).collect::<Option<Vec<_>>>() else {
            return;
        };
        let most = MOST_OF_ALL.min(MOST_JOINTS / nodes.len().max(1)) / count.clamp(1, MOST_ANIMATIONS);
        let steps = ((animation.seconds() / EVERY_S) as usize).clamp(1, most.clamp(1, MOST_OF_ONE));
        for step in 1..=steps {
            let worlds = animation.worlds(animation.seconds() * (step as f64 - 0.5) / steps as f64);
            self.add(|j| nodes.binary_search_by_key(&j, |x| x.0).map_or([0.0; 16], |at| worlds[nodes[at].1]));
        }
    }

    fn add(&mut self, world: impl Fn(usize) -> Matrix) {
        let bends = self.used.iter().flat_map(|&(j, anchor)| bend(&world(anchor), &world(j))).collect();
        self.all.push((self.used.iter().map(|(j, _)| world(*j)).collect(), bends));
    }

    /// The poses that differ most; `None` if no animation moves the body.
    ///
    /// They are chosen by farthest-point sampling (Gonzalez, 1985), from the pose in which the mesh is bound on, of the places of joints against their ancestors:
    /// where the whole character goes does not count.
    pub fn motion(self) -> Option<Motion<'a>> {
        let joints = &self.skeleton.joints;
        let chosen = farthest(&self.all.iter().map(|(_, bends)| &bends[..]).collect::<Vec<_>>());
        let matrices = |pose: usize| {
            let mut matrices = vec![[0.0; 16]; joints.len()];
            for ((j, _), world) in self.used.iter().zip(&self.all[pose].0) {
                matrices[*j] = matrix::mul(world, &joints[*j].inverse_bind);
            }
            matrices
        };
        let poses: Vec<_> = chosen.into_iter().map(matrices).collect();
        (!poses.is_empty()).then_some(Motion { body: self.body, poses })
    }
}

impl Motion<'_> {
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

/// The place of a joint against an ancestor: its rotation and, in metres, its offset. Scales do not count.
fn bend(ancestor: &Matrix, joint: &Matrix) -> [f64; 12] {
    let axes = |m: &Matrix| [0, 4, 8].map(|k| [m[k], m[k + 1], m[k + 2]]).map(|a| scale(a, 1.0 / norm(a).max(1e-30)));
    let (own, above) = (axes(joint), axes(ancestor));
    let offset = [0, 1, 2].map(|c| PER_METRE * (joint[12 + c] - ancestor[12 + c]));
    let rows = [own[0], own[1], own[2], offset];
    std::array::from_fn(|k| dot(rows[k / 3], above[k % 3]))
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
        if nearest[next].is_nan() || nearest[next] < ALIKE {
            break;
        }
        chosen.push(next);
        nearest.iter_mut().zip(all).for_each(|(near, pose)| *near = near.min(apart(pose, all[next])));
    }
    chosen
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
        let at = |x: f64, y: f64| Matrix::from([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, 0., 1.]);
        let turned = |x: f64, y: f64| Matrix::from([0., 2., 0., 0., -2., 0., 0., 0., 0., 0., 2., 0., x, y, 0., 1.]);
        let rest = bend(&at(0.0, 0.0), &at(1.0, 0.0));
        let apart = |other: [f64; 12]| rest.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart(bend(&at(5.0, 0.0), &at(6.0, 0.0))) < 1e-12);
        assert!(apart(bend(&turned(5.0, 5.0), &turned(5.0, 6.0))) < 1e-12);
        assert!(apart(bend(&at(0.0, 0.0), &at(1.5, 0.0))) > 0.5);
        assert!(apart(bend(&at(0.0, 0.0), &turned(1.0, 0.0))) > 0.5);
        assert!(bend(&[0.0; 16], &at(1.0, 0.0)).iter().all(|x| x.is_finite()));
    }

    #[test]
    fn joints_that_move_nothing_do_not_choose_poses() {
        use crate::base::mesh::{Channel, Joint, Semantic};
        let at = |x: f64| Matrix::from([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.]);
        let joint = |parent| Joint { name: String::new(), parent, inverse_bind: at(0.0), world: at(0.0) };
        // A control, the spine below it, a control below that, an arm below that, and another root.
        let joints = vec![joint(None), joint(Some(0)), joint(Some(1)), joint(Some(2)), joint(None)];
        let channel =
            |semantic, values: [f32; 4]| Channel { semantic, width: 4, values: values.into(), corners: vec![0; 3] };
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]],
            skeleton: Skeleton { joints },
            channels: vec![
                channel(Semantic::Joints(0), [3.0, 4.0, 2.0, 0.0]),
                channel(Semantic::Weights(0), [0.5, 0.5, 0.0, 0.0]),
            ],
            ..Mesh::default()
        };
        let body = Body {
            positions: vec![[0.0; 3]],
            joints: vec![[1, 2, 0, 0]],
            weights: vec![[1.0, 0.0, 0.0, 0.0]],
            ..Body::default()
        };
        let mut poses = Poses::new(&body, &mesh).unwrap();
        assert_eq!(poses.used, [(1, 1), (3, 1), (4, 1)]);
        // All of it goes away, then controls alone, then the arm.
        poses.add(|_| at(7.0));
        poses.add(|j| at(if j == 0 || j == 2 { 9.0 } else { 0.0 }));
        assert_eq!(poses.all[1].1, poses.all[0].1);
        poses.add(|j| at(if j == 3 { 1.0 } else { 0.0 }));
        let motion = poses.motion().unwrap();
        assert_eq!((motion.poses.len(), motion.poses[0][3], motion.poses[0][2]), (1, at(1.0), [0.0; 16]));
        assert!(Poses::new(&body, &mesh).unwrap().motion().is_none());
        assert!(Poses::new(&Body::default(), &mesh).is_none());
    }
}
