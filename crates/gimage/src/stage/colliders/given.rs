//! The colliders that the file of a character brings along, as solids.

use nalgebra::{Rotation3, Vector3};

use super::fit::Placed;
use super::solid::{Form, Solid};
use super::{ColliderOptions, Figures, MAX_COUNT};
use crate::base::mesh::{Joint, Mesh};
use crate::error::{Error, Result};
use crate::import::{FileCollider, FileShape, IDENTITY, inverse};
use crate::record::{Finding, Severity};

/// Where colliders come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColliderSource {
    /// From the file, if 95 % of the body are within three times [`ColliderOptions::error`] of those that it has; otherwise they are fitted.
    #[default]
    Auto,
    /// From the file.
    File,
    /// They are fitted, whatever the file has.
    Fit,
}

impl ColliderSource {
    /// All of them.
    pub const ALL: [ColliderSource; 3] = [ColliderSource::Auto, ColliderSource::File, ColliderSource::Fit];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            ColliderSource::Auto => "auto",
            ColliderSource::File => "file",
            ColliderSource::Fit => "fit",
        }
    }
}

/// Distance of the body from colliders of a file, over that asked for, from which they are fitted instead.
const LOOSE: f64 = 3.0;

/// Solids of a file.
pub(super) struct Given {
    /// Where the mesh is bound to its skeleton.
    pub placed: Vec<Placed>,
    /// The extensions that they are from.
    pub sources: Vec<&'static str>,
    pub findings: Vec<Finding>,
}

/// The colliders of a file as solids. Errors if they are asked for and there are none.
pub(super) fn given(colliders: &[FileCollider], mesh: &Mesh, options: &ColliderOptions) -> Result<Option<Given>> {
    if options.source == ColliderSource::Fit {
        return Ok(None);
    }
    let (mut changed, mut found) = (Vec::new(), Vec::new());
    for c in colliders {
        let (solid, is_exact) = solid(&c.shape);
        let solid = solid.posed(&Joint { name: String::new(), parent: None, inverse_bind: IDENTITY, world: c.world });
        let joint = c.joint.and_then(|j| mesh.skeleton.joints.get(j as usize));
        if let Some(solid) = joint.map_or(Some(solid), |joint| back(&solid, joint)) {
            found.push((Placed { joint: joint.and(c.joint), solid }, c.source));
            changed.extend((!is_exact).then(|| c.node.clone()));
        }
    }
    if found.is_empty() && options.source == ColliderSource::File {
        return Err(Error::Option {
            option: "collider-source".into(),
            problem: "the file has no colliders of KHR_physics_rigid_bodies or VRM".into(),
            hint: "leave it out, so that colliders are fitted".into(),
        });
    }
    let mut findings = Vec::new();
    if !changed.is_empty() {
        let message = "A collider of the file is a cylinder: it became a capsule of its mean radius.";
        findings.push(finding(Severity::Note, "rounded-collider", changed.len(), message.into(), changed));
    }
    if found.len() > MAX_COUNT {
        let message = format!("The file has {} colliders; {MAX_COUNT} of them are used.", found.len());
        findings.push(finding(Severity::Warning, "many-colliders", found.len() - MAX_COUNT, message, Vec::new()));
        found.truncate(MAX_COUNT);
    }
    let (placed, mut sources): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    sources.dedup();
    Ok((!placed.is_empty()).then_some(Given { placed, sources, findings }))
}

/// Whether colliders of a file are used, and what is to be said of it.
pub(super) fn judged(given: &Given, figures: &Figures, options: &ColliderOptions) -> (bool, Finding) {
    let (count, sources) = (given.placed.len(), given.sources.join(", "));
    let (far, asked) = (1e3 * figures.body.p95, 1e3 * options.error);
    let is_near = figures.body.p95 <= LOOSE * options.error;
    let is_used = is_near || options.source == ColliderSource::File;
    let (severity, message) = match (is_used, is_near) {
        (false, _) => (
            Severity::Note,
            format!(
                "5 % of the body are more than {far:.1} mm from the {count} colliders of the file ({sources}), which is more than {LOOSE} times {asked:.1} \
                 mm: colliders were fitted instead. --collider-source file takes those of the file."
            ),
        ),
        (true, true) => (
            Severity::Note,
            format!("The {count} colliders of the file ({sources}) are used. --collider-source fit fits others."),
        ),
        (true, false) => (
            Severity::Warning,
            format!(
                "5 % of the body are more than {far:.1} mm from the {count} colliders of the file ({sources}), {asked:.1} mm asked for: cloth will lie \
                 inside the body there. --collider-source fit fits others."
            ),
        ),
    };
    (is_used, finding(severity, "file-colliders", 1, message, Vec::new()))
}

fn finding(severity: Severity, kind: &'static str, count: usize, message: String, examples: Vec<String>) -> Finding {
    let examples = examples.into_iter().take(5).collect();
    Finding { severity, stage: "colliders", kind, count: count as u64, examples, message }
}

/// A solid moved from where a joint is in the file to the pose in which the mesh is bound; none if the joint is flat.
fn back(solid: &Solid, joint: &Joint) -> Option<Solid> {
    let (world, inverse_bind) = (inverse(&joint.inverse_bind)?, inverse(&joint.world)?);
    Some(solid.posed(&Joint { world, inverse_bind, ..joint.clone() }))
}

/// The shape in the space of its node, and whether it is that shape exactly.
fn solid(shape: &FileShape) -> (Solid, bool) {
    let still = Rotation3::identity();
    match *shape {
        FileShape::Sphere { center, radius } => (Solid::new(Form::Sphere { radius }, center.into(), &still), true),
        FileShape::Box { half } => (Solid::new(Form::Box { half }, Vector3::zeros(), &still), true),
        FileShape::Cylinder { half_height, radii: [a, b] } => {
            let radius = 0.5 * (a + b);
            let half_height = (half_height - radius).max(0.0);
            (Solid::new(Form::Capsule { half_height, radius }, Vector3::zeros(), &still), false)
        }
        FileShape::Capsule { ends, radii: [a, b] } => {
            let [p, q] = ends.map(Vector3::from);
            let (way, half_height) = (p - q, 0.5 * (p - q).norm());
            if (a - b).abs() >= 2.0 * half_height {
                // One ball holds the other.
                let (center, radius) = if a >= b { (p, a) } else { (q, b) };
                return (Solid::new(Form::Sphere { radius }, center, &still), true);
            }
            // Two ends that are opposite have no shortest turn.
            let turn = Rotation3::rotation_between(&Vector3::y(), &way).unwrap_or_else(|| {
                if way.y < 0.0 { Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI) } else { still }
            });
            let form = match a == b {
                true => Form::Capsule { half_height, radius: a },
                false => Form::TaperedCapsule { half_height, radii: [b, a] },
            };
            (Solid::new(form, 0.5 * (p + q), &turn), true)
        }
    }
}
