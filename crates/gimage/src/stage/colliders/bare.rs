//! Bare parts of a body, such as hands, that animations take through clothes beneath which the body is guessed.
//!
//! Animators let a hand pass through trousers that follow the skeleton. Cloth that collides with both the hand and a leg has no place there: the hand takes hold of it and carries it away.

use rayon::prelude::*;

use super::motion::{Followers, Motion};
use super::samples::{normal, strongest};
use crate::base::closest::Closest;
use crate::base::mesh::{Mesh, Skeleton};
use crate::base::scatter::Sampler;
use crate::base::vec3::{add, distance, dot, norm, scale, sub};
use crate::stage::import::{Matrix, inverse, point};

/// Points of the body and of the clothes, and the seeds of both.
const SAMPLES: usize = 2_000;
const SEEDS: [u64; 2] = [6, 7];
/// Share of all frames in which a part that passes through clothes is in them, at least.
const OFTEN: f64 = 0.01;
/// Bones between the joint of a part and those of clothes that it passes through, at least: a bent knee folds the clothes of both of its bones.
const APART: usize = 2;
/// A part is bare without clothes around it up to this share of the height of body and clothes.
const AROUND: f64 = 0.12;
/// A garment around a part is seen from its inside.
const INSIDE: f64 = 0.2;
/// Height above a triangle from which clothes are looked for, as a share of that distance.
const ABOVE: f64 = 1e-3;

/// A point of a body.
struct Skin {
    point: [f64; 3],
    /// The unit vector into the body.
    inward: [f64; 3],
    joint: Option<u32>,
}

/// The points of a joint, and a ball around them.
struct Part<'a> {
    joint: u32,
    points: Vec<&'a Skin>,
    center: [f64; 3],
    radius: f64,
}

impl<'a> Part<'a> {
    /// Of each joint that has points, in ascending order.
    fn all(skin: &'a [Skin]) -> Vec<Self> {
        let mut joints: Vec<u32> = skin.iter().filter_map(|s| s.joint).collect();
        joints.sort_unstable();
        joints.dedup();
        let of = |joint: u32| {
            let points: Vec<&Skin> = skin.iter().filter(|s| s.joint == Some(joint)).collect();
            let center = scale(points.iter().fold([0.0; 3], |sum, s| add(sum, s.point)), 1.0 / points.len() as f64);
            let radius = points.iter().map(|s| distance(center, s.point)).fold(0.0, f64::max);
            Part { joint, points, center, radius }
        };
        joints.into_iter().map(of).collect()
    }

    /// How deep \[m\] a point is beneath the nearest of its points; none of one that is outside.
    fn depth(&self, p: [f64; 3]) -> Option<f64> {
        if distance(p, self.center) > self.radius {
            return None;
        }
        let nearest = self.points.iter().min_by(|a, b| distance(a.point, p).total_cmp(&distance(b.point, p)))?;
        let way = sub(p, nearest.point);
        let depth = dot(way, nearest.inward);
        let aside = norm(sub(way, scale(nearest.inward, depth)));
        (depth > 0.0 && aside <= depth).then_some(depth)
    }
}

/// Joints of a body that animations take more than `deep` \[m\] through clothes around `guessed` joints in one of a hundred frames or more, in ascending order. O(frames x
/// points of the clothes x points of the body near them).
pub(super) fn passing([body, cloth]: [&Mesh; 2], guessed: &[u32], motion: &Motion, deep: f64) -> Vec<u32> {
    let corners: Vec<_> = (0..body.triangles.len()).map(|t| body.corners(t)).collect();
    let sampler = Sampler::new(&corners, SAMPLES, SEEDS[0]);
    if guessed.is_empty() || motion.frames.is_empty() || sampler.area() <= 0.0 {
        return Vec::new();
    }
    let of = |i: usize| {
        let (point, t) = sampler.at(i);
        Skin { point, inward: scale(normal(corners[t]), -1.0), joint: strongest(body, t, point) }
    };
    let skin: Vec<Skin> = (0..SAMPLES).map(of).collect();
    let (parts, followers) = (Part::all(&skin), Followers::new(cloth, SAMPLES, SEEDS[1]));
    let chains: Vec<Vec<usize>> = (0..body.skeleton.joints.len()).map(|j| chain(&body.skeleton, j)).collect();
    let apart = |a: u32, b: u32| hops(&chains[a as usize], &chains[b as usize]).is_none_or(|hops| hops >= APART);
    let within = |pose: &Vec<Matrix>| -> Vec<bool> {
        let at = followers.at(pose);
        let of = |part: &Part<'_>| {
            let Some(back) = pose.get(part.joint as usize).and_then(inverse) else { return false };
            let is_other = |joint: Option<u32>| joint.is_some_and(|j| guessed.contains(&j) && apart(part.joint, j));
            let others = at.iter().zip(&followers.joints).filter(|(_, joint)| is_other(**joint));
            others.filter_map(|(p, _)| part.depth(point(&back, *p))).any(|depth| depth > deep)
        };
        parts.iter().map(of).collect()
    };
    let frames: Vec<Vec<bool>> = motion.frames.par_iter().map(within).collect();
    let least = OFTEN * frames.len() as f64;
    let passes = |k: &usize| frames.iter().filter(|frame| frame[*k]).count() as f64 >= least;
    (0..parts.len()).filter(passes).map(|k| parts[k].joint).collect()
}

/// A joint, its parent, and so on.
fn chain(skeleton: &Skeleton, joint: usize) -> Vec<usize> {
    let parent = |j: &usize| skeleton.joints[*j].parent.map(|p| p as usize);
    std::iter::successors(Some(joint), parent).take(skeleton.joints.len()).collect()
}

/// The number of bones from one joint to another.
fn hops(a: &[usize], b: &[usize]) -> Option<usize> {
    a.iter().enumerate().find_map(|(n, j)| Some(n + b.iter().position(|k| k == j)?))
}

/// For each triangle of a body whether it follows one of these joints for the most part, and has no clothes around it.
pub(super) fn bare([body, cloth]: [&Mesh; 2], joints: &[u32]) -> Vec<bool> {
    let clothes = Closest::new(&cloth.positions, &cloth.triangles);
    let (Some((low, high)), Some((foot, top))) = (body.bounds(), cloth.bounds()) else { return Vec::new() };
    let around = AROUND * (high[1].max(top[1]) - low[1].min(foot[1]));
    let of = |t: usize| {
        let corners = body.corners(t);
        let middle = scale(corners.into_iter().fold([0.0; 3], add), 1.0 / 3.0);
        let n = normal(corners);
        strongest(body, t, middle).is_some_and(|j| joints.contains(&j))
            && clothes.along(add(middle, scale(n, ABOVE * around)), n, around, |_, m| dot(m, n) > INSIDE).is_none()
    };
    (0..body.triangles.len()).into_par_iter().map(of).collect()
}
