//! Where the animations of a file take the points of its meshes.

use std::path::Path;

use super::samples::{barycentric, strongest};
use crate::base::mesh::{Joint, Mesh, Semantic, Skeleton};
use crate::base::scatter::Sampler;
use crate::base::vec3::{add, scale};
use crate::stage::import::{Character, ImportOptions, Matrix, mul, point};

/// Frames per second at which animations are looked at, frames of one at most, and of all.
const RATE: f64 = 12.0;
const OF_ONE: usize = 32;
const OF_ALL: usize = 400;

/// Frames of all animations: for each the transform of each joint, from where meshes are bound to the world.
pub(super) struct Motion {
    pub frames: Vec<Vec<Matrix>>,
}

impl Motion {
    /// Of a file whose meshes follow this skeleton. Animations that do not have its joints, or cannot be read, are left out.
    pub fn new(path: &Path, options: &ImportOptions, skeleton: &Skeleton) -> Self {
        let mut frames: Vec<Vec<Matrix>> = Vec::new();
        for character in Character::all(path, options) {
            let nodes: Option<Vec<usize>> = skeleton.joints.iter().map(|j| character.node(&j.name).ok()).collect();
            let Some(nodes) = nodes.filter(|nodes| !nodes.is_empty()) else { continue };
            let count = ((character.seconds() * RATE).ceil() as usize).clamp(1, OF_ONE);
            frames.extend((0..count).map(|k| {
                let worlds = character.worlds(character.seconds() * k as f64 / count as f64);
                let of = |(node, joint): (&usize, &Joint)| mul(&worlds[*node], &joint.inverse_bind);
                nodes.iter().zip(&skeleton.joints).map(of).collect()
            }));
        }
        let every = frames.len().div_ceil(OF_ALL).max(1);
        Motion { frames: frames.into_iter().step_by(every).collect() }
    }
}

/// Points of a mesh that follow joints.
pub(super) struct Followers {
    /// The joint with the largest weight of each.
    pub joints: Vec<Option<u32>>,
    /// For each the corners of its triangle.
    corners: Vec<[Corner; 3]>,
}

/// A corner of a triangle.
struct Corner {
    /// Its share of a point.
    share: f64,
    /// Where it is bound \[m\].
    at: [f64; 3],
    /// Its joints and their weights.
    joints: Vec<(u32, f64)>,
}

impl Followers {
    /// Points at equal shares of the area; none without an area.
    pub fn new(mesh: &Mesh, count: usize, seed: u64) -> Self {
        let corners: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let sampler = Sampler::new(&corners, count, seed);
        let count = if sampler.area() > 0.0 { count } else { 0 };
        let (mut joints, mut all) = (Vec::new(), Vec::new());
        for (p, t) in (0..count).map(|i| sampler.at(i)) {
            let shares = barycentric(corners[t], p);
            joints.push(strongest(mesh, t, p));
            let corner = |c: usize| Corner { share: shares[c], at: corners[t][c], joints: influences(mesh, t, c) };
            all.push([0, 1, 2].map(corner));
        }
        Followers { joints, corners: all }
    }

    /// Where they are in a frame.
    pub fn at(&self, pose: &[Matrix]) -> Vec<[f64; 3]> {
        let corner = |Corner { share, at, joints }: &Corner| {
            let moved = joints.iter().filter_map(|(j, w)| Some(scale(point(pose.get(*j as usize)?, *at), share * w)));
            moved.fold([0.0; 3], add)
        };
        self.corners.iter().map(|corners| corners.iter().map(corner).fold([0.0; 3], add)).collect()
    }
}

/// The joints of a corner, and their weights, which sum to 1.
fn influences(mesh: &Mesh, t: usize, c: usize) -> Vec<(u32, f64)> {
    let mut out = Vec::new();
    for n in 0.. {
        let channels = (mesh.channel(&Semantic::Joints(n)), mesh.channel(&Semantic::Weights(n)));
        let (Some(joints), Some(weights)) = channels else { break };
        let (Some(joints), Some(weights)) = (joints.at(t, c), weights.at(t, c)) else { continue };
        let each = joints.iter().zip(weights).filter(|(_, w)| **w > 0.0);
        out.extend(each.map(|(j, w)| (*j as u32, f64::from(*w))));
    }
    let sum: f64 = out.iter().map(|(_, w)| w).sum();
    out.iter_mut().for_each(|(_, w)| *w /= sum);
    out
}
