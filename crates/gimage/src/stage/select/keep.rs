//! A mesh without some of its parts.

use super::{Role, Verdict};
use crate::base::mesh::{Mesh, NONE};

/// Parts of a mesh of which all or none are cloth.
pub(crate) struct Group {
    pub mesh: Mesh,
    pub is_cloth: bool,
    /// The number that each part of the mesh had before.
    pub parts: Vec<usize>,
}

/// The parts of a mesh that are cloth, and then the others if there are any.
pub(crate) fn apart(mesh: Mesh, verdicts: &[Verdict]) -> Vec<Group> {
    let group = |mesh: Mesh, is_cloth: bool| {
        let keep: Vec<bool> = verdicts.iter().map(|v| (v.role == Role::Cloth) == is_cloth).collect();
        let parts = (0..keep.len()).filter(|&p| keep[p]).collect();
        let mesh = if keep.iter().all(|k| *k) { mesh } else { keeping(mesh, &keep) };
        Group { mesh, is_cloth, parts }
    };
    let is_cloth = |&p: &u32| verdicts[p as usize].role == Role::Cloth;
    if mesh.triangle_part.iter().all(is_cloth) {
        return vec![group(mesh, true)];
    }
    vec![group(mesh.clone(), true), group(mesh, false)]
}

/// The mesh with some of its parts only. Vertices, triangles and parts keep their order. O(n).
pub(crate) fn keeping(mut mesh: Mesh, keep: &[bool]) -> Mesh {
    let kept: Vec<bool> = mesh.triangle_part.iter().map(|&p| keep[p as usize]).collect();
    let mut flags = kept.iter();
    mesh.triangles.retain(|_| flags.next().copied().unwrap_or(false));
    let mut flags = kept.iter();
    mesh.triangle_part.retain(|_| flags.next().copied().unwrap_or(false));
    for channel in &mut mesh.channels {
        let mut corner = 0;
        channel.corners.retain(|_| {
            corner += 1;
            kept[(corner - 1) / 3]
        });
    }
    mesh.channels.retain(|c| c.corners.iter().any(|&k| k != NONE));
    let part = renumber(keep);
    mesh.triangle_part.iter_mut().for_each(|p| *p = part[*p as usize]);
    let mut flags = keep.iter();
    mesh.parts.retain(|_| flags.next().copied().unwrap_or(false));
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let vertex = renumber(&used);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = vertex[*v as usize]);
    let mut flags = used.iter();
    mesh.positions.retain(|_| flags.next().copied().unwrap_or(false));
    mesh
}

/// For each element the number that it has among those kept.
fn renumber(keep: &[bool]) -> Vec<u32> {
    let mut next = 0;
    let number = |&kept: &bool| {
        next += u32::from(kept);
        next.saturating_sub(1)
    };
    keep.iter().map(number).collect()
}
