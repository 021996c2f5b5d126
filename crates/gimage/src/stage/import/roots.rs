//! The joints of a skin but for roots that exporters add: they are bound in another size than all others, and no vertex follows them.

use std::collections::HashMap;

use super::matrix::{self, Matrix};
use super::nodes::Forest;

/// A root is bound as the other joints are if it agrees in size to this share.
pub(super) const SIZE: f64 = 0.02;

/// The inverse bind matrices by joint, without joints above all others that give the mesh another size, where they are in the file, than the joint in the
/// middle does. O(n log n).
pub(super) fn without_odd_roots(forest: &Forest, mut binds: HashMap<usize, Matrix>) -> HashMap<usize, Matrix> {
    let size = |joint: &usize| size_of(&matrix::mul(&forest.world[*joint], &binds[joint]));
    let sizes: HashMap<usize, f64> = binds.keys().map(|joint| (*joint, size(joint))).collect();
    let mut sorted: Vec<f64> = sizes.values().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    // A size of 0, or none, tells nothing.
    while middle > 0.0 && middle.is_finite() {
        let has_joint_above = |joint: &usize| {
            std::iter::successors(forest.parent[*joint], |n| forest.parent[*n]).any(|n| binds.contains_key(&n))
        };
        let is_odd = |joint: &&usize| (sizes[*joint] / middle - 1.0).abs() > SIZE && !has_joint_above(joint);
        let odd: Vec<usize> = binds.keys().filter(is_odd).copied().collect();
        if odd.is_empty() {
            break;
        }
        odd.iter().for_each(|joint| _ = binds.remove(joint));
    }
    binds
}

/// The size that a transform gives to what is as large as 1.
pub(super) fn size_of(m: &Matrix) -> f64 {
    matrix::determinant(m).abs().cbrt()
}
