//! The pose in which the skins of a file are bound.

use std::collections::HashMap;

use super::accessor::Accessors;
use super::local::Local;
use super::matrix::{self, Matrix};
use super::nodes::Forest;
use super::roots::without_odd_roots;
use super::skin::inverse_binds;
use crate::base::vec3::{distance, norm};

/// A joint stays where the file has it if it is bound no farther from there: turned or scaled by this share, moved by this share of the longest way from
/// a node to its parent on the way up from it.
const SAME: f64 = 1e-3;

/// Where nodes are in the space of their parents when joints are to one another as the skins of the file are bound; `rest` is where they are in the
/// file. Clothes fit the body there: the pose of the nodes may be any, such as that of the frame at which a file was exported.
///
/// A joint without a joint of its skin above it stays where it is in the file, as skins are bound in a space of their own. Skins without inverse bind
/// matrices, or with damaged ones, and joints that are bound with a shear have no effect.
pub(super) fn bound(accessors: &Accessors, forest: &Forest, rest: &[Local]) -> Vec<Local> {
    let skins = &accessors.doc.root.skins;
    let binds = |k: usize| -> HashMap<usize, Matrix> {
        let is_bound = skins[k].inverse_bind_matrices.is_some();
        let matrices = is_bound.then(|| inverse_binds(accessors, forest, k).ok()).flatten().unwrap_or_default();
        without_odd_roots(forest, skins[k].joints.iter().map(|j| j.value()).zip(matrices).collect())
    };
    let binds: Vec<_> = (0..skins.len()).map(binds).collect();
    let mut worlds = forest.world.clone();
    let mut pose = rest.to_vec();
    for n in forest.order() {
        let Some(parent) = forest.parent[n] else { continue };
        let above = || std::iter::successors(Some(parent), |n| forest.parent[*n]);
        // Its transform to the space of the joint above it, by the first skin that has both.
        let to_joint = binds.iter().find_map(|binds| {
            let own = matrix::inverse(binds.get(&n)?)?;
            above().find_map(|a| Some((a, matrix::mul(binds.get(&a)?, &own))))
        });
        if let (Some((joint, to_joint)), Some(back)) = (to_joint, matrix::inverse(&worlds[parent])) {
            let own = matrix::mul(&back, &matrix::mul(&worlds[joint], &to_joint));
            let length = above().chain([n]).map(|n| norm(origin(&rest[n].matrix()))).fold(0.0, f64::max);
            let moves = matches!(rest[n], Local::Parts { .. }) && !same(&own, &rest[n].matrix(), length);
            pose[n] = Local::parts(&own).filter(|_| moves).unwrap_or(rest[n]);
        }
        worlds[n] = matrix::mul(&worlds[parent], &pose[n].matrix());
    }
    pose
}

/// Whether two transforms of a joint are the same to within [`SAME`].
fn same(a: &Matrix, b: &Matrix, length: f64) -> bool {
    let size = a[..12].iter().chain(&b[..12]).fold(0.0f64, |s, x| s.max(x.abs()));
    a[..12].iter().zip(&b[..12]).all(|(a, b)| (a - b).abs() <= SAME * size)
        && distance(origin(a), origin(b)) <= SAME * length
}

fn origin(m: &Matrix) -> [f64; 3] {
    [m[12], m[13], m[14]]
}
