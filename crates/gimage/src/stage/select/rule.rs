//! The role of each part of a skinned file, from its names and from how it follows the joints.

use std::collections::BTreeSet;

use super::facts::{self, Following};
use super::{Role, Verdict, words};
use crate::base::mesh::{Mesh, Part};

/// Share of triangles on solid pieces from which a part is rigid.
const STIFF: f64 = 0.9;
/// Share of the skeleton's joints from which a part without a telling name is a body.
const MANY: f64 = 0.5;

/// The role of each part; `None` for a mesh without a skin, and for one with a single part. If nothing looks like cloth, all
/// parts are cloth.
///
/// A part with a telling name has the role of that name; the name of the material comes first where a mesh has several
/// materials, else that of the node, the mesh, the material. Of the others, a part that follows no joint, or whose connected
/// pieces nearly all follow one or two joints, is rigid; a part that follows half of the joints or more is a body; the rest is
/// cloth.
pub(super) fn verdicts(mesh: &Mesh) -> Option<Vec<Verdict>> {
    let single = mesh.triangle_part.iter().all(|p| *p == mesh.triangle_part[0]);
    if single || !facts::is_skinned(mesh) {
        return None;
    }
    let later = mesh.parts.iter().filter(|p| p.primitive > 0);
    let several: BTreeSet<(&str, &str)> = later.map(|p| (&*p.node, &*p.mesh)).collect();
    let joints = mesh.skeleton.joints.len();
    let following = facts::following(mesh);
    let mut verdicts: Vec<Verdict> = mesh
        .parts
        .iter()
        .zip(&following)
        .map(|(part, following)| {
            by_name(part, several.contains(&(&*part.node, &*part.mesh))).unwrap_or_else(|| by_skin(following, joints))
        })
        .collect();
    if !mesh.triangle_part.iter().any(|&p| verdicts[p as usize].role == Role::Cloth) {
        verdicts.iter_mut().for_each(|v| v.role = Role::Cloth);
    }
    Some(verdicts)
}

/// The role that names tell. `several`: the mesh has several primitives.
fn by_name(part: &Part, several: bool) -> Option<Verdict> {
    let order =
        if several { [&part.material, &part.node, &part.mesh] } else { [&part.node, &part.mesh, &part.material] };
    let (role, word) = order.into_iter().find_map(|name| words::role(name))?;
    Some(Verdict::new(role, format!("name has \"{word}\"")))
}

fn by_skin(following: &Following, joints: usize) -> Verdict {
    let Following { joints: used, solid } = *following;
    if used == 0 {
        return Verdict::new(Role::Rigid, "follows no joint");
    }
    if solid >= STIFF {
        return Verdict::new(Role::Rigid, "each piece follows 1 or 2 joints");
    }
    let role = if used as f64 >= MANY * joints as f64 { Role::Body } else { Role::Cloth };
    Verdict::new(role, format!("follows {used} of {joints} joints"))
}
