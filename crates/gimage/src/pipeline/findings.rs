//! Findings of the pipeline itself about a build.

use std::path::Path;

use super::budget;
use crate::base::mesh::Mesh;
use crate::base::words;
use crate::error::Error;
use crate::options::BuildOptions;
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use crate::stage::assemble::Family;
use crate::stage::assemble::accessory::Rider;
use crate::stage::component::{Component, no_area};
use crate::stage::image::PieceImage;
use crate::stage::sample::FitRecord;

/// How much larger than its share an image may be before that is worth a warning: the next size that welds is up to twice as
/// large.
const OVER: f64 = 2.1;

pub(super) fn nothing_left(path: &Path, mesh: &Mesh, parts: &[Component], options: &BuildOptions) -> Error {
    let largest = parts.iter().map(|c| c.area).fold(0.0, f64::max);
    let all: f64 = parts.iter().map(|c| c.area).sum();
    if mesh.triangles.is_empty() || all <= 0.0 {
        return no_area(path);
    }
    Error::Empty {
        path: path.to_path_buf(),
        problem: format!(
            "none of {} is large enough to be a piece (the largest has {:.2} % of the area, {:.2} % are required)",
            words::counted(parts.len(), "loose part", "loose parts"),
            100.0 * largest / all,
            100.0 * options.component.accessory_area
        ),
        hint: "join the parts with --weld METRES, or lower --accessory-area".into(),
    }
}

/// A warning where f32 cannot hold the shape: far from the origin for its size.
pub(super) fn resolution(mesh: &Mesh) -> Option<Finding> {
    let (lo, hi) = mesh.bounds()?;
    let far = lo.iter().chain(&hi).fold(0.0f64, |m, x| m.max(x.abs()));
    let step = far * f64::from(f32::EPSILON);
    let diagonal = mesh.diagonal();
    (step > 1e-5 * diagonal).then(|| Finding {
        severity: Severity::Warning,
        stage: "component",
        kind: "far-from-origin",
        count: 1,
        examples: vec![format!("coordinates up to {far:.3e} m, diagonal {diagonal:.3e} m")],
        message: format!(
            "The garment is so far from the origin that 32-bit positions are rounded to {step:.1e} m; use --center, or move \
             it to the origin."
        ),
    })
}

/// A hint about pieces that are closed around a volume, as hats and tops are whose openings have caps.
pub(super) fn closed(pieces: &[Component]) -> Option<Finding> {
    let closed: Vec<&Component> = pieces.iter().filter(|c| c.loops == 0).collect();
    (!closed.is_empty()).then(|| Finding {
        severity: Severity::Note,
        stage: "component",
        kind: "hint-closed",
        count: closed.len() as u64,
        examples: closed.iter().take(MAX_EXAMPLES).map(|c| c.name.clone()).collect(),
        message: "Closed around a volume, without any opening: caps across openings of a garment become cloth too. --caps open leaves \
                  out what looks like one; else delete them in the file."
            .into(),
    })
}

/// Which components were split.
pub(super) fn split_up(families: &[Family<'_>]) -> Option<Finding> {
    (!families.is_empty()).then(|| Finding {
        severity: Severity::Note,
        stage: "image",
        kind: "split",
        count: families.len() as u64,
        examples: families
            .iter()
            .take(MAX_EXAMPLES)
            .map(|f| format!("{} in {} parts", f.whole.name, f.count))
            .collect(),
        message:
            "One image cannot hold these surfaces at this size; each became several pieces, joined by welded seams."
                .into(),
    })
}

pub(super) fn set_apart(riders: &[Rider<'_>]) -> Option<Finding> {
    (!riders.is_empty()).then(|| Finding {
        severity: Severity::Repair,
        stage: "component",
        kind: "accessories",
        count: riders.len() as u64,
        examples: riders
            .iter()
            .take(MAX_EXAMPLES)
            .map(|r| format!("{} ({}): {}", r.component.name, words::triangles(r.component.triangles.len()), r.reason))
            .collect(),
        message:
            "Parts that are too small to be cloth, lie on a larger one, or have a border too long for their size, as by many holes, get no image and ride on the nearest piece."
                .into(),
    })
}

/// Findings of the image stage about a piece.
pub(super) fn remarks(name: &str, image: &PieceImage) -> Vec<Finding> {
    let one = |severity, kind, count: usize, message: &str| Finding {
        severity,
        stage: "image",
        kind,
        count: count as u64,
        examples: vec![format!("piece {name}")],
        message: message.into(),
    };
    let mut out = Vec::new();
    if !image.closed {
        let text = "The image does not weld to a surface with the topology of the piece; use more texels.";
        out.push(one(Severity::Warning, "topology", 1, text));
    }
    let texels = image.width * image.height;
    if let Some(share) = image.budget.filter(|&b| f64::from(texels) > OVER * f64::from(b.max(budget::LEAST_SHARE))) {
        out.push(Finding {
            examples: vec![format!("piece {name}: {} x {} texels, its share is {share}", image.width, image.height)],
            ..one(
                Severity::Warning,
                "over-budget",
                1,
                "The border needs more texels than the piece's share; close small holes, or split the piece.",
            )
        });
    }
    if image.moved > 0 {
        let text = "Texels beside the end of a cut were sampled a fraction of a texel farther inside, so that the image welds.";
        out.push(one(Severity::Note, "moved-texels", image.moved, text));
    }
    match image.fit {
        Some(FitRecord::Failed) => {
            let text =
                "The least-squares fit failed, and point sampling is used instead. Try another number of texels.";
            out.push(one(Severity::Warning, "fit-failed", 1, text));
        }
        Some(FitRecord::Dropped) => {
            let text = "The least-squares fit was no closer than point sampling, which is used instead.";
            out.push(one(Severity::Note, "fit-dropped", 1, text));
        }
        Some(FitRecord::Kept(back)) if back > 0 => {
            let text = "Texels that the fit moved too far were reset to their sampled points.";
            out.push(one(Severity::Note, "fit-restrained", back, text));
        }
        _ => {}
    }
    let p = &image.parameterize;
    if p.newton.steps == 0 && !p.newton.converged {
        let text = "The minimiser made no progress; the flip-free initial map is used.";
        out.push(one(Severity::Warning, "start-kept", 1, text));
    } else if p.newton.capped {
        let text = "The minimiser reached its work limit while the map still improved; a mesh with fewer triangles converges further.";
        out.push(one(Severity::Note, "work-cap", 1, text));
    } else if !p.newton.converged {
        let text = "The minimiser stopped before it converged; the map is flip-free but could be less distorted.";
        out.push(one(Severity::Note, "not-converged", 1, text));
    }
    out
}

/// One finding of each kind for all pieces, in the order they first occur.
pub(super) fn merged(findings: impl Iterator<Item = Finding>) -> Vec<Finding> {
    let mut out: Vec<Finding> = Vec::new();
    for f in findings {
        match out.iter_mut().find(|o| o.kind == f.kind) {
            Some(o) => {
                o.count += f.count;
                o.examples.extend(f.examples);
                o.examples.truncate(MAX_EXAMPLES);
            }
            None => out.push(f),
        }
    }
    out
}
