//! A build of the cloth of a character, with solids in place of its body.

use std::path::Path;
use std::time::Instant;

use gimage_bundle::manifest::{ColliderEntry, ColliderShape};
use gimage_bundle::{Body, Bundle, MapKind};
use serde_json::json;

use super::entries::repair_entry;
use super::{Built, build_as};
use crate::base::words::counted;
use crate::colliders::{Collider, ColliderOptions, Fit, Form, LOOSE_FIT, Start, Surface, Tier, fit_body};
use crate::error::{Error, Result};
use crate::options::{BuildOptions, Choice};
use crate::progress::{Progress, Stage};
use crate::record::{Finding, Severity};
use crate::report::{StageTime, peak_memory};

/// Builds a bundle as [`super::build`] does, and adds solids that stand for the body ([`crate::colliders::fit_colliders`]) to its manifest. Without
/// pins in the options and in the file, garments are pinned where they rest on the body ([`crate::hold`]), which a finding reports. A file without
/// a body has no solids, with a warning, and the top of each garment is pinned ([`super::PINNED_TOP`]).
///
/// Errors: those of both, and [`Error::Option`] for a skinned file of which no part looks like cloth, unless parts are chosen.
pub fn dress(path: &Path, options: &BuildOptions, solids: &ColliderOptions, progress: &dyn Progress) -> Result<Built> {
    let mut findings = Vec::new();
    // The shorter work first, so that it fails first.
    progress.begin(Stage::Colliders, 1);
    let start = Instant::now();
    let fit = match fit_body(path, options, solids, true) {
        Ok(fit) => Some(fit),
        Err(Error::Empty { problem, hint, .. }) => {
            findings.push(finding(Severity::Warning, "no-body", format!("There are no colliders: {problem}; {hint}.")));
            None
        }
        Err(error) => return Err(error),
    };
    let fitting =
        StageTime { stage: Stage::Colliders, seconds: start.elapsed().as_secs_f64(), peak_bytes: peak_memory() };
    let mut built = build_as(path, options, true, progress, |bundle, report| {
        if let Some(fit) = fit {
            findings.extend(add(bundle, fit, solids.tier));
        }
        describe(bundle, solids);
        bundle.manifest.repairs.extend(findings.iter().map(repair_entry));
        report.findings.extend(findings);
    })?;
    built.report.stages.insert(0, fitting);
    Ok(built)
}

/// Adds the colliders of a fit to a bundle, and the surface of the body if cloth is to collide with it. Returns the findings.
fn add(bundle: &mut Bundle, fit: Fit, tier: Tier) -> Vec<Finding> {
    let Fit { colliders, figures, surface, findings, .. } = fit;
    let mm = [figures.body.mean, figures.body.p95, figures.body.max].map(|x| format!("{:.1}", 1e3 * x)).join(", ");
    let count = colliders.iter().filter(|collider| !collider.guessed).count();
    let message = format!("{count} colliders; mean, 95 % and largest distance of the body from them: {mm} mm.");
    let mut said = vec![finding(Severity::Note, "hint-colliders", message)];
    bundle.manifest.colliders = colliders.iter().map(entry).collect();
    let mut found: Vec<Finding> = findings.into_iter().filter(|f| f.stage == "colliders").collect();
    if tier != Tier::Capsules {
        let (body, hint) = worn(bundle, surface, tier);
        found.push(hint);
        bundle.body = body;
    }
    // The cloth does not meet the solids of a body whose surface it has.
    if bundle.body.is_some() {
        found.iter_mut().filter(|f| f.kind == LOOSE_FIT).for_each(|f| f.severity = Severity::Note);
    }
    said.extend(found);
    said
}

/// Adds the options of solids to a manifest.
fn describe(bundle: &mut Bundle, solids: &ColliderOptions) {
    let kinds: Vec<&str> = solids.kinds.iter().map(|k| k.name()).collect();
    let options = &mut bundle.manifest.options;
    options.insert("collider".into(), json!(solids.tier.name()));
    options.insert("collider-guess".into(), json!(solids.guess.name()));
    options.insert("collider-error".into(), json!(solids.error));
    options.insert("max-colliders".into(), json!(solids.count));
    options.insert("collider-shapes".into(), json!(kinds));
    options.insert("collider-source".into(), json!(solids.source.name()));
}

/// The surface of the body, if cloth is to collide with it, and what is to be said of it.
fn worn(bundle: &Bundle, surface: std::result::Result<Surface, String>, tier: Tier) -> (Option<Body>, Finding) {
    let manifest = &bundle.manifest;
    let joints = manifest.skeleton.as_ref().map_or(0, |s| s.joints.len());
    let follows = (0..manifest.pieces.len()).all(|k| bundle.images.contains_key(&(k, MapKind::Joints(0))));
    let surface = surface.and_then(|surface| match surface.body.joints.is_empty() || (joints > 0 && follows) {
        true => Ok(surface),
        false => Err("the cloth does not follow the joints of the body".into()),
    });
    let Surface { body, covered, closed } = match surface {
        Ok(surface) => surface,
        Err(why) => {
            let message = format!("The surface of the body cannot be a collider, its solids stand for it: {why}.");
            let severity = if tier == Tier::Auto { Severity::Note } else { Severity::Warning };
            return (None, finding(severity, "hint-surface", message));
        }
    };
    let triangles = body.triangles.len();
    let mut left_out =
        if covered > 0 { format!(" ({covered} inside of other parts of it are left out)") } else { String::new() };
    if closed > 0 {
        left_out += &format!(", with {} closed", counted(closed, "opening", "openings"));
    }
    let used = format!("The body is a collider: {triangles} triangles{left_out}");
    if tier == Tier::Surface {
        return (Some(body), finding(Severity::Note, "hint-surface", used + "."));
    }
    let start = Start::of(bundle, &body);
    let measured = format!(
        "{} of {} free particles start more than 5 mm inside of it, at most {:.1} mm",
        start.inside,
        start.free,
        1e3 * start.deepest
    );
    if start.suits(&body) {
        return (Some(body), finding(Severity::Note, "hint-surface", format!("{used}; {measured}.")));
    }
    let message = format!(
        "The solids of the body are its colliders, not its {triangles} triangles: {measured}. --collider surface takes the triangles."
    );
    (None, finding(Severity::Note, "hint-surface", message))
}

fn finding(severity: Severity, kind: &'static str, message: String) -> Finding {
    Finding { severity, stage: "dress", kind, count: 1, examples: Vec::new(), message }
}

fn entry(collider: &Collider) -> ColliderEntry {
    let shape = match collider.bound.form {
        Form::Sphere { radius } => ColliderShape::Sphere { radius },
        Form::Capsule { half_height, radius } => ColliderShape::Capsule { half_height, radius },
        Form::TaperedCapsule { half_height, radii } => ColliderShape::TaperedCapsule { half_height, radii },
        Form::Box { half } => ColliderShape::Box { half },
        Form::Ellipsoid { radii } => ColliderShape::Ellipsoid { radii },
    };
    let Collider { joint, bound, guessed, .. } = collider.clone();
    ColliderEntry { joint, shape, position: bound.center, rotation: bound.rotation, guessed }
}
