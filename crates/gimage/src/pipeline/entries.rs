//! The record of a build in the manifest, beside its pieces.

use gimage_bundle::Bundle;
use gimage_bundle::manifest::{Joint, Repair, ShellEntry, Skeleton, Source as SourceEntry};

use crate::base::mesh::Mesh;
use crate::options::{BuildOptions, Choice};
use crate::record::{Finding, Severity};
use crate::stage::assemble::Piece;
use crate::stage::assemble::accessory::Rider;
use crate::stage::import::Source;
use crate::stage::shell::Thinned;

/// Writes source, options, skeleton and findings into the manifest.
pub(super) fn describe(
    bundle: &mut Bundle,
    mesh: &Mesh,
    source: &Source,
    options: &BuildOptions,
    findings: &[Finding],
) {
    let Source { file_name, sha256, extras, .. } = source;
    bundle.manifest.source = SourceEntry { file: file_name.clone(), sha256: sha256.clone(), extras: extras.clone() };
    bundle.manifest.options = options.record();
    bundle.manifest.skeleton = skeleton(mesh, bundle);
    bundle.manifest.repairs = findings.iter().map(repair_entry).collect();
}

/// Writes the shell of each piece that was one. Bound triangles are counted once, with the first piece of a shell, or with an
/// accessory if none of it is a piece.
pub(super) fn shells(bundle: &mut Bundle, pieces: &[Piece<'_>], riders: &[Rider<'_>], thinned: &Thinned) {
    let mut counted = vec![false; thinned.shells.len()];
    let mut bound = |component| {
        let k = thinned.shell_index(component)?;
        let (shell, is_first) = (&thinned.shells[k], !std::mem::replace(&mut counted[k], true));
        Some((shell, if is_first { (shell.bound_triangles as u32, shell.bound_area) } else { (0, 0.0) }))
    };
    for (entry, piece) in bundle.manifest.pieces.iter_mut().zip(pieces) {
        entry.shell = bound(piece.component).map(|(shell, (bound_triangles, bound_area))| ShellEntry {
            layer: shell.layer.name().into(),
            thickness: shell.thickness,
            thickness_range: shell.range,
            share: shell.share,
            bound_triangles,
            bound_area,
        });
    }
    for (entry, rider) in bundle.manifest.accessories.iter_mut().zip(riders) {
        let Some((_, (triangles, area))) = bound(rider.component) else { continue };
        entry.triangles += triangles;
        entry.area += area;
    }
}

fn skeleton(mesh: &Mesh, bundle: &Bundle) -> Option<Skeleton> {
    let used = bundle.images.keys().any(|(_, kind)| matches!(kind, gimage_bundle::MapKind::Joints(_)));
    (used && !mesh.skeleton.joints.is_empty()).then(|| Skeleton {
        joints: mesh
            .skeleton
            .joints
            .iter()
            .map(|j| Joint { name: j.name.clone(), parent: j.parent, inverse_bind: j.inverse_bind.map(|x| x as f32) })
            .collect(),
    })
}

pub(super) fn repair_entry(f: &Finding) -> Repair {
    Repair {
        severity: match f.severity {
            Severity::Note => "note",
            Severity::Repair => "repair",
            Severity::Warning => "warning",
        }
        .into(),
        stage: f.stage.into(),
        kind: f.kind.into(),
        count: f.count,
        examples: f.examples.clone(),
        message: f.message.clone(),
    }
}
