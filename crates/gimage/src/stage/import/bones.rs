//! The bones of a skeleton: lines from joints to their parents.

use super::matrix::inverse;
use crate::base::mesh::{Joint, Skeleton};

/// A bone, where the mesh is bound to its skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bone {
    /// The joint at its end, and the parent of that, at its start.
    pub joint: u32,
    pub parent: u32,
    /// Where both are \[m\], the end first.
    pub ends: [[f64; 3]; 2],
}

/// The bones of a skeleton; joints without an inverse of their matrix have none.
pub(crate) fn bones(skeleton: &Skeleton) -> Vec<Bone> {
    let place = |joint: &Joint| inverse(&joint.inverse_bind).map(|m| [m[12], m[13], m[14]]);
    let bone = |(joint, of): (usize, &Joint)| {
        let parent = of.parent?;
        let ends = [place(of)?, place(skeleton.joints.get(parent as usize)?)?];
        let is_finite = ends.iter().flatten().all(|x| x.is_finite());
        is_finite.then_some(Bone { joint: joint as u32, parent, ends })
    };
    skeleton.joints.iter().enumerate().filter_map(bone).collect()
}
