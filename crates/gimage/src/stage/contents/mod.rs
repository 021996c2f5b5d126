//! The contents of a garment file: its parts, and the components and boundary loops that a build makes of them.

mod loops;
mod numbers;
mod size;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::caps::{Caps, CapsOptions, open_caps};
use super::component::{Component, Split, no_area};
use super::import::{Animation, FileCollider, Imported, Skin, import};
use super::repair::repair;
use super::select::{self, Following, Role, Verdict, apart, divided, following, roles};
use super::shell::{Layer, Sheets, Shell, ShellOptions, Thinned, thin};
use super::strands::{Strands, StrandsOptions, leave_strands};
use crate::base::mesh::{Mesh, Part};
use crate::error::Result;
use crate::options::BuildOptions;
use crate::record::Finding;
use size::{Bounded, bounded};

pub use loops::BoundaryLoop;
pub use size::Size;

/// The contents of a file, as a build with the same options reads them. Lengths are in metres, Y up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contents {
    /// Name of the file without folders.
    pub file: String,
    /// Sizes of everything.
    pub size: Size,
    /// The primitives of glTF, or the groups of faces of OBJ with one object, group and material, in the order of the file.
    pub parts: Vec<PartEntry>,
    /// The connected components after repair: those large enough to be pieces, then accessories, then those that it
    /// leaves out, the largest area first.
    pub components: Vec<ComponentEntry>,
    /// The skins.
    pub skins: Vec<Skin>,
    /// The animations.
    pub animations: Vec<Animation>,
    /// The colliders.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub colliders: Vec<FileCollider>,
    /// Findings of import, choice of parts and repair.
    pub findings: Vec<Finding>,
}

/// One part of a file: a primitive of a node's mesh, or the faces of an OBJ object with one material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartEntry {
    /// glTF node or OBJ object; empty if it has no name.
    pub node: String,
    /// glTF mesh or OBJ group.
    pub mesh: String,
    /// Material; empty for none.
    pub material: String,
    /// Index of the primitive in its mesh, or of the material in its OBJ object.
    pub primitive: u32,
    /// How often it is placed: nodes of one name and instances count as one part.
    pub copies: usize,
    /// Its size, of all copies.
    pub size: Size,
    /// Number of joints that move it.
    pub joints: usize,
    /// Its role in a build, and the reason.
    pub verdict: Verdict,
}

/// A connected component: triangles that share vertices after repair.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentEntry {
    /// The name that it has in a bundle if it becomes a piece or an accessory.
    pub name: String,
    /// The numbers K by which `component:K` chooses it; several where repair joins components of the file.
    pub numbers: Vec<u32>,
    /// Its role in a build.
    pub role: Role,
    /// The kind of surface that it seems to be.
    pub kind: Kind,
    /// Estimated thickness \[m\] of a thin shell: the median distance of two facing sheets.
    pub thickness: Option<f64>,
    /// The name of the component that has the second sheet of a thin shell, if it is another one.
    pub other_sheet: Option<String>,
    /// Its size.
    pub size: Size,
    /// Its boundary loops, longest first.
    pub loops: Vec<BoundaryLoop>,
}

/// The kind of surface that a component seems to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A single layer with at least one boundary loop.
    OpenSurface,
    /// Closed around a volume.
    ClosedShell,
    /// Two sheets that face each other at a small distance.
    ThinShell,
    /// It lies on a larger component all over, such as a print that was modelled as a copy of faces: an accessory.
    Overlay,
    /// Too small to be a piece, such as a button: an accessory.
    Crumb,
}

impl Kind {
    /// Its name in words.
    pub fn words(self) -> &'static str {
        match self {
            Kind::OpenSurface => "open surface",
            Kind::ClosedShell => "closed shell",
            Kind::ThinShell => "thin shell",
            Kind::Overlay => "overlay",
            Kind::Crumb => "crumb",
        }
    }
}

/// The contents of a file: see [`contents`].
///
/// Errors: those of the import; [`crate::Error::Option`] for an impossible choice of parts; [`crate::Error::Empty`] if no
/// triangle has an area.
pub fn list(path: &Path, options: &BuildOptions) -> Result<Contents> {
    options.check()?;
    contents(path, import(path, &options.import)?, options)
}

/// Lists an imported mesh. Parts that are cloth and parts that are not are repaired and split apart from each other, so
/// that components and loops are those of a build. `path` is for messages. O(n log n), deterministic.
pub fn contents(path: &Path, imported: Imported, options: &BuildOptions) -> Result<Contents> {
    let Imported { mesh, source, scene, mut findings, .. } = imported;
    let mut mesh = divided(mesh, &options.select);
    numbers::mark(&mut mesh);
    let verdicts = roles(&mesh, &options.select)?;
    findings.extend(select::findings(&mesh, &verdicts, &options.select));
    let following = following(&mesh);
    let names = mesh.parts.clone();
    let mut sizes = vec![Bounded::default(); names.len()];
    let (mut whole, mut components) = (Bounded::default(), Vec::new());
    for group in apart(mesh, &verdicts) {
        let repaired = repair(group.mesh, &options.repair)?;
        findings.extend(repaired.findings);
        let mesh = repaired.mesh;
        let triangles = (0..mesh.triangles.len() as u32).collect::<Vec<_>>();
        whole = whole.joined(bounded(&mesh, &triangles));
        measure_parts(&mesh, &group.parts, &mut sizes);
        let shell = if group.is_cloth { options.shell } else { ShellOptions { shell: Layer::Keep } };
        let caps = if group.is_cloth { options.caps } else { CapsOptions { caps: Caps::Keep } };
        let strands = if group.is_cloth { options.strands } else { StrandsOptions { strands: Strands::Keep } };
        let stripped = leave_strands(mesh, &strands);
        findings.extend(stripped.finding);
        let opened = open_caps(stripped.mesh, &caps);
        findings.extend(opened.finding);
        let thinned = thin(opened.mesh, &shell, &options.component);
        findings.extend(thinned.findings.iter().cloned());
        let mesh = &thinned.mesh;
        let mut parts = thinned.split(&options.component);
        if parts.pieces.is_empty() && parts.accessories.is_empty() {
            if group.is_cloth {
                return Err(no_area(path));
            }
            continue;
        }
        let role = |c: &Component| match group.is_cloth {
            true => Role::Cloth,
            false => verdicts[group.parts[mesh.triangle_part[c.triangles[0] as usize] as usize]].role,
        };
        components.extend(entries(&thinned, &mut parts, group.is_cloth, role));
    }
    Ok(Contents {
        file: source.file_name,
        size: whole.finish(),
        parts: part_entries(&names, verdicts, &sizes, &following),
        components,
        skins: scene.skins,
        animations: scene.animations,
        colliders: scene.colliders,
        findings,
    })
}

/// The parts in the order in which they occur first; parts of one name, material and role are one.
fn part_entries(names: &[Part], verdicts: Vec<Verdict>, sizes: &[Bounded], following: &[Following]) -> Vec<PartEntry> {
    let mut out: Vec<PartEntry> = Vec::new();
    let mut whole: Vec<Bounded> = Vec::new();
    let mut at: BTreeMap<(&str, &str, &str, u32, Role), usize> = BTreeMap::new();
    for (k, (part, verdict)) in names.iter().zip(verdicts).enumerate() {
        let name = (&*part.node, &*part.mesh, &*part.material, part.primitive, verdict.role);
        let index = *at.entry(name).or_insert(out.len());
        if let Some(entry) = out.get_mut(index) {
            // Components that were chosen by number are of one copy.
            entry.copies += usize::from(part.component.is_none());
            whole[index] = whole[index].joined(sizes[k]);
            entry.size = whole[index].finish();
            entry.joints = entry.joints.max(following[k].joints);
            continue;
        }
        whole.push(sizes[k]);
        out.push(PartEntry {
            node: part.node.clone(),
            mesh: part.mesh.clone(),
            material: part.material.clone(),
            primitive: part.primitive,
            copies: 1,
            size: sizes[k].finish(),
            joints: following[k].joints,
            verdict,
        });
    }
    out
}

/// The components of a repaired mesh: pieces, then accessories.
fn entries(
    thinned: &Thinned,
    parts: &mut Split,
    built: bool,
    role: impl Fn(&Component) -> Role,
) -> Vec<ComponentEntry> {
    let mesh = &thinned.mesh;
    let pieces = parts.pieces.len();
    let all: Vec<Component> = parts.pieces.drain(..).chain(parts.accessories.drain(..)).collect();
    let mut owner = vec![0; mesh.triangles.len()];
    all.iter().enumerate().for_each(|(k, c)| c.triangles.iter().for_each(|&t| owner[t as usize] = k as u32));
    let sheets = Sheets::new(mesh, &owner);
    let entry = |(k, c): (usize, &Component)| {
        let shell: Option<&Shell> = thinned.shell(c);
        let opposite = if k < pieces && shell.is_none() { sheets.opposite(c) } else { None };
        let thickness = shell.map(|s| s.thickness).or(opposite.map(|o| o.thickness));
        let kind = match (k < pieces, thickness, c.loops) {
            (false, ..) if c.lies_on.is_some() => Kind::Overlay,
            (false, ..) => Kind::Crumb,
            (_, Some(_), _) => Kind::ThinShell,
            (_, None, 0) => Kind::ClosedShell,
            _ => Kind::OpenSurface,
        };
        let other = opposite.map(|o| o.component as usize).filter(|&o| o != k);
        ComponentEntry {
            name: c.name.clone(),
            numbers: numbers::of(mesh, c),
            role: role(c),
            kind,
            thickness,
            other_sheet: other.map(|o| all[o].name.clone()),
            size: bounded(mesh, &c.triangles).finish(),
            loops: loops::loops(mesh, c),
        }
    };
    let mut out: Vec<ComponentEntry> = all.iter().enumerate().map(entry).collect();
    if built {
        loops::number(&mut out[..pieces].iter_mut().map(|c| &mut c.loops).collect::<Vec<_>>());
    }
    out
}

/// Adds the sizes of the parts of one group; `parts` has their numbers in the file.
fn measure_parts(mesh: &Mesh, parts: &[usize], sizes: &mut [Bounded]) {
    let mut of_part: Vec<Vec<u32>> = vec![Vec::new(); parts.len()];
    mesh.triangle_part.iter().enumerate().for_each(|(t, &p)| of_part[p as usize].push(t as u32));
    for (triangles, &part) in of_part.iter().zip(parts) {
        sizes[part] = bounded(mesh, triangles);
    }
}

#[cfg(test)]
mod tests;
