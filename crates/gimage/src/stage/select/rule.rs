//! The role of each part of a character, from its names and from how it follows the joints.

use std::collections::BTreeMap;

use super::facts::{self, Following, SOLID};
use super::{Role, Verdict, words};
use crate::base::mesh::{Mesh, Part};

/// Share of triangles on solid pieces from which a part is rigid.
const STIFF: f64 = 0.9;
/// Share of the skeleton's joints from which a part without a telling name is a body, as are solid pieces of a file without another body.
const MANY: f64 = 0.5;

/// The role of each part; `None` for one with a single part, and for a mesh without a skin unless its names tell a character ([`by_names`]). If nothing looks like cloth, all
/// parts are cloth.
///
/// A part with a telling name has the role of that name. The name of the material comes first if a mesh has several
/// materials, else the name of the node, then of the mesh, then of the material. One exception: a material named after a garment, such as a robe, decides over
/// a node or a mesh named after a part of the body that garments cover.
///
/// The name of a node says nothing about the parts with other materials if one material of the mesh is named after a garment, as those parts may be trims,
/// linings or skin. It says nothing about them either if one material is named after skin, as those parts are clothes then, except on a head, hands or feet.
///
/// Of parts without a telling name, one that follows no joint, or whose connected
/// pieces nearly all follow one or two joints, is rigid; one that follows joints of eyes, jaws or fingers, or those of head, hands and feet, is a body; one that
/// follows half of the joints or more is a body, beside garments only if it follows more than they do; the rest is cloth.
///
/// In a file with cloth and without a body, rigid parts that follow half of the joints or more, and at least three, are the body: a robot, or armour
/// around nothing.
pub(super) fn verdicts(mesh: &Mesh) -> Option<Vec<Verdict>> {
    if facts::is_single(mesh) {
        return None;
    }
    if !facts::is_skinned(mesh) {
        return by_names(mesh);
    }
    let joints = mesh.skeleton.joints.len();
    let following = facts::following(mesh);
    let meshes = Meshes::new(mesh, &following);
    let verdict = |(part, following): (&Part, &Following)| {
        let of = meshes.of(part);
        // Beside skin that has a material of its own, nothing else is skin.
        let garments =
            of.filter(|of| of.is_dressed(part)).map_or(0, |of| if of.garments == 0 { joints } else { of.garments });
        by_name(part, of).unwrap_or_else(|| by_skin(following, joints, garments))
    };
    let mut verdicts: Vec<Verdict> = mesh.parts.iter().zip(&following).map(verdict).collect();
    let present: Vec<usize> = mesh.triangle_part.iter().map(|&p| p as usize).collect();
    let any = |verdicts: &[Verdict], role: Role| present.iter().any(|&p| verdicts[p].role == role);
    if !any(&verdicts, Role::Cloth) {
        verdicts.iter_mut().for_each(|v| v.role = Role::Cloth);
    } else if !any(&verdicts, Role::Body) {
        let rigid = verdicts.iter_mut().zip(&following).filter(|(v, _)| v.role == Role::Rigid);
        for (verdict, Following { joints: used, .. }) in
            rigid.filter(|(_, f)| f.joints > SOLID && many(f.joints, joints))
        {
            *verdict =
                Verdict::new(Role::Body, format!("follows {used} of {joints} joints, and nothing else is a body"));
        }
    }
    Some(verdicts)
}

/// The role of each part of a character without a skin, which is one if names tell garments, and parts of a body that no garment covers: the panels of a shirt
/// may be called body and arms. Parts without a telling name are rigid.
fn by_names(mesh: &Mesh) -> Option<Vec<Verdict>> {
    let told: Vec<Option<(Role, String)>> = (mesh.parts.iter())
        .map(|part| [&part.node, &part.mesh, &part.material].into_iter().find_map(|name| words::role(name)))
        .collect();
    let present = || mesh.triangle_part.iter().filter_map(|p| told[*p as usize].as_ref());
    let is_body = |(role, word): &(Role, String)| *role == Role::Body && !words::is_covered(word);
    if !present().any(is_body) || !present().any(|(role, _)| *role == Role::Cloth) {
        return None;
    }
    let verdict = |told: Option<(Role, String)>| match told {
        Some((role, word)) => Verdict::new(role, format!("name has \"{word}\"")),
        None => Verdict::new(Role::Rigid, "no name tells what it is, beside garments and a body"),
    };
    Some(told.into_iter().map(verdict).collect())
}

/// For each part of a skinned mesh whether no name tells its role and it lies beside garments in one mesh.
pub(super) fn unnamed_beside_garments(mesh: &Mesh) -> Vec<bool> {
    let meshes = Meshes::new(mesh, &facts::following(mesh));
    let beside = |part: &Part| meshes.of(part).filter(|of| of.is_dressed(part));
    mesh.parts.iter().map(|part| beside(part).is_some_and(|of| by_name(part, Some(of)).is_none())).collect()
}

/// The meshes of several primitives, by node and mesh.
struct Meshes<'a>(BTreeMap<(&'a str, &'a str), Several>);

/// Facts of a mesh of several primitives.
#[derive(Clone, Copy, Default)]
struct Several {
    /// The most joints that a part follows whose material names a garment; 0 where none does.
    garments: usize,
    /// Whether a material names skin, so that the others are something else.
    skin: bool,
}

impl Several {
    /// Whether parts that no name tells may be garments, although the mesh is that of a body.
    fn is_dressed(self, part: &Part) -> bool {
        let told = [&part.node, &part.mesh].into_iter().find_map(|name| words::role(name));
        let is_covered = told.is_none_or(|(role, word)| role != Role::Body || words::is_covered(&word));
        self.garments > 0 || self.skin && is_covered
    }
}

impl<'a> Meshes<'a> {
    fn new(mesh: &'a Mesh, following: &[Following]) -> Self {
        let later = mesh.parts.iter().filter(|p| p.primitive > 0);
        let mut all: BTreeMap<_, Several> = later.map(|p| ((&*p.node, &*p.mesh), Several::default())).collect();
        for (part, following) in mesh.parts.iter().zip(following) {
            let told = words::role(&part.material);
            if let (Some((role, word)), Some(of)) = (told, all.get_mut(&(&*part.node, &*part.mesh))) {
                of.garments = of.garments.max(if role == Role::Cloth { following.joints } else { 0 });
                of.skin |= word == "skin";
            }
        }
        Meshes(all)
    }

    fn of(&self, part: &Part) -> Option<Several> {
        self.0.get(&(&*part.node, &*part.mesh)).copied()
    }
}

/// The role that names tell; `of` is the part's mesh, if it has several primitives.
fn by_name(part: &Part, of: Option<Several>) -> Option<Verdict> {
    let order: &[&String] = match of {
        None => &[&part.node, &part.mesh, &part.material],
        Some(of) if of.is_dressed(part) => &[&part.material],
        Some(_) => &[&part.material, &part.node, &part.mesh],
    };
    let (mut role, mut word) = order.iter().find_map(|name| words::role(name))?;
    let material = words::role(&part.material).filter(|(_, word)| words::is_garment(word));
    if let Some(garment) = material.filter(|_| words::is_covered(&word)) {
        (role, word) = garment;
    }
    Some(Verdict::new(role, format!("name has \"{word}\"")))
}

/// The role that the joints tell; garments of the same mesh follow up to `garments` of them.
fn by_skin(following: &Following, joints: usize, garments: usize) -> Verdict {
    let Following { joints: used, solid, ref bare } = *following;
    if used == 0 {
        return Verdict::new(Role::Rigid, "follows no joint");
    }
    if solid >= STIFF {
        return Verdict::new(Role::Rigid, "each piece follows 1 or 2 joints");
    }
    if let Some(joint) = bare {
        return Verdict::new(Role::Body, format!("follows the joint {joint}, as hands and faces do"));
    }
    let role = if many(used, joints) && used > garments { Role::Body } else { Role::Cloth };
    Verdict::new(role, format!("follows {used} of {joints} joints"))
}

fn many(used: usize, joints: usize) -> bool {
    used as f64 >= MANY * joints as f64
}
