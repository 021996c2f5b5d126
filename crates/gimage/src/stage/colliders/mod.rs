//! Fits solids (spheres, capsules, boxes, ellipsoids) to a body, so that cloth can collide with it.
//!
//! The body is sampled where it can be touched; each sample follows the joint with the largest weight. Each joint gets one solid,
//! and those that are farthest from the body are divided until the surface of all of them is near enough. Solids follow one joint each.
//! Garments at rest stay outside of them, so that nothing is pushed at the start.
//! They are fitted in the pose in which the mesh is bound to its skeleton, and then put where their joints are in the file.

mod bare;
mod bounded;
mod fit;
mod given;
mod guess;
mod judge;
mod motion;
mod refine;
mod samples;
mod shape;
mod solid;
mod start;
mod surface;

use std::path::Path;

use gimage_bundle::Winding;

use super::caps::open_caps;
use super::import::{Imported, import, inverse};
use super::repair::repair;
use super::select::{Role, SelectOptions, assigned, divided, keeping, roles, unmatched};
use crate::base::mesh::{Joint, Mesh, Part};
use crate::base::vec3::distance;
use crate::error::{Error, Result};
use crate::options::{BuildOptions, Choice};
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use fit::Limits;
use given::Given;
use motion::Motion;
use samples::{guards, join_small, samples, worn};

pub use given::ColliderSource;
pub use judge::{Figures, FitError};
pub use shape::Kind;
pub use solid::{Form, Solid};
pub(crate) use start::Start;
pub use surface::Surface;

/// Solids, at most.
pub const MAX_COUNT: usize = 512;
/// How deep a part of the body is in clothes that it passes through, as a multiple of [`ColliderOptions::error`].
const PASSING: f64 = 2.0;
/// Smallest thickness of a solid of a division, as a share of the diagonal: 2 cm of a person.
const MIN_THICKNESS: f64 = 0.01;
/// Samples of the surface, of a fit and of what judges it each.
const SAMPLES: usize = 2_500;

/// Options of [`fit_colliders`].
#[derive(Clone, Debug, PartialEq)]
pub struct ColliderOptions {
    /// Distance \[m\] from the body that at most 5 % of its points may exceed, above 0. Solids are divided until then.
    pub error: f64,
    /// Largest number of solids, 1 to [`MAX_COUNT`]; a skeleton with more joints that move some of the body has one per joint.
    pub count: usize,
    /// The kinds of solids, at least one.
    pub kinds: Vec<Kind>,
    /// Whether solids that the file has are used.
    pub source: ColliderSource,
    /// The collider of the cloth of a dressed character.
    pub tier: Tier,
    /// Whether parts of the body that the file leaves out beneath clothes are guessed.
    pub guess: Guess,
}

/// Whether solids stand for parts of the body that a file leaves out beneath clothes, with room beneath the innermost garment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Guess {
    /// For bones that a garment surrounds and no body does.
    #[default]
    On,
    /// Nowhere.
    Off,
}

impl Choice for Guess {
    const ALL: &'static [(&'static str, Self)] = &[("on", Self::On), ("off", Self::Off)];
}

/// The collider of the cloth of a dressed character. A bundle has the solids in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// The solids.
    Capsules,
    /// The surface of its body.
    Surface,
    /// The surface, if at most 1 % of the free particles start more than 5 mm inside of it, and if it has at most 200,000 triangles; else the
    /// solids.
    #[default]
    Auto,
}

impl Choice for Tier {
    const ALL: &'static [(&'static str, Self)] =
        &[("capsules", Self::Capsules), ("surface", Self::Surface), ("auto", Self::Auto)];
}

impl Default for ColliderOptions {
    fn default() -> Self {
        ColliderOptions {
            error: 0.006,
            count: 48,
            kinds: vec![Kind::Sphere, Kind::Capsule],
            source: ColliderSource::Auto,
            tier: Tier::default(),
            guess: Guess::default(),
        }
    }
}

/// A solid of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// The joint that it follows; none of a body without a skin.
    pub joint: Option<String>,
    /// The solid, where the character stands as its file has it.
    pub solid: Solid,
    /// The same where the body is bound to its skeleton, as the cloth of a bundle is.
    pub bound: Solid,
    /// Whether it stands for a part of the body that the file leaves out beneath clothes.
    pub guessed: bool,
}

/// Solids in place of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Name of the file without folders.
    pub file: String,
    /// The parts of the file that are the body, by name.
    pub parts: Vec<String>,
    /// The solids, by joint in the order of the skeleton; those of a file in its order.
    pub colliders: Vec<Collider>,
    /// How far they are from the body.
    pub figures: Figures,
    /// The surface of the body where it is bound to its skeleton, or the reason why it cannot be a collider.
    pub surface: std::result::Result<Surface, String>,
    /// Findings of the import and of the fit.
    pub findings: Vec<Finding>,
}

/// Fits solids to the body of a character. Parts named by `--body` ([`crate::select::SelectOptions::body`]) are the body;
/// otherwise those that look like one, or all parts of a file without a skin.
///
/// Solids that the file has (`KHR_physics_rigid_bodies` with `KHR_implicit_shapes`, spring bones of VRM) are used instead of a fit as
/// [`ColliderOptions::source`] says.
///
/// Deterministic. O(n log n) in the triangles, and O(samples x solids x divisions): a character of 10,000 triangles takes a second or two.
///
/// Errors: those of the import; [`Error::Option`] for values out of range and for patterns that match nothing; [`Error::Empty`] if
/// no part looks like a body, or if it has no area.
pub fn fit_colliders(path: &Path, read: &BuildOptions, options: &ColliderOptions) -> Result<Fit> {
    fit_body(path, read, options, false)
}

/// As [`fit_colliders`]; with `dressed`, no part that a build with these options makes cloth of is the body.
pub(crate) fn fit_body(path: &Path, read: &BuildOptions, options: &ColliderOptions, dressed: bool) -> Result<Fit> {
    read.check()?;
    options.check()?;
    let Imported { mesh, source, scene, mut findings, .. } = import(path, &read.import)?;
    let mesh = divided(mesh, &read.select);
    let body = body(&mesh, read, dressed)?;
    if !body.contains(&true) {
        let problem = "no part looks like a body".into();
        let hint = "choose parts with --body; `gimage list` shows their names".into();
        return Err(Error::Empty { path: path.into(), problem, hint });
    }
    let mut parts: Vec<String> =
        mesh.parts.iter().zip(&body).filter(|(_, b)| **b).map(|(p, _)| p.node.clone()).collect();
    parts.dedup();
    let verdicts = assigned(&mesh, &read.select)?;
    let garments: Vec<bool> = verdicts.iter().zip(&body).map(|(v, body)| v.role == Role::Cloth && !body).collect();
    let cloth =
        if garments.contains(&true) { worn_cloth(keeping(mesh.clone(), &garments), read)? } else { Mesh::default() };
    let mesh = if body.contains(&false) { keeping(mesh, &body) } else { mesh };
    let given = given::given(&scene.colliders, &mesh, options)?;
    let (colliders, figures, found) = fit_mesh(&mesh, &cloth, given, options).ok_or_else(|| Error::Empty {
        path: path.into(),
        problem: "the body has no area that can be touched".into(),
        hint: "check that its triangles face outwards".into(),
    })?;
    findings.extend(found);
    findings.extend(elsewhere(&mesh, options));
    let guessed: Vec<u32> =
        (0..).zip(&mesh.skeleton.joints).filter(|(_, j)| stands_for(&colliders, &j.name)).map(|(k, _)| k).collect();
    let passing = if guessed.is_empty() {
        Vec::new()
    } else {
        let motion = Motion::new(path, &read.import, &mesh.skeleton);
        bare::passing([&mesh, &cloth], &guessed, &motion, PASSING * options.error)
    };
    let left_out = if passing.is_empty() { Vec::new() } else { bare::bare([&mesh, &cloth], &passing) };
    let surface = surface::surface(&mesh, &left_out);
    findings.extend(passed(&mesh, &passing, &left_out));
    Ok(Fit { file: source.file_name, parts, colliders, figures, surface, findings })
}

impl ColliderOptions {
    /// Errors with [`Error::Option`] for values out of range.
    pub fn check(&self) -> Result<()> {
        let wrong = |option: &str, problem: String, hint: &str| {
            Err(Error::Option { option: option.into(), problem, hint: hint.into() })
        };
        if !(self.error.is_finite() && self.error > 0.0) {
            return wrong(
                "collider-error",
                format!("{} is not a distance above 0", self.error),
                "give metres, such as 0.006",
            );
        }
        if !(1..=MAX_COUNT).contains(&self.count) {
            return wrong("max-colliders", format!("{} is not in 1 to {MAX_COUNT}", self.count), "give fewer solids");
        }
        if self.kinds.is_empty() {
            return wrong("collider-shapes", "no shape is left".into(), "give at least one, such as capsule");
        }
        Ok(())
    }
}

/// For each part whether it belongs to the body; with `dressed`, none that becomes cloth does.
pub(crate) fn body(mesh: &Mesh, read: &BuildOptions, dressed: bool) -> Result<Vec<bool>> {
    let patterns = &read.select.body;
    if let Some(unmet) = patterns.iter().find(|p| !mesh.parts.iter().any(|part| p.matches_part(part))) {
        return Err(unmatched(mesh, "body", unmet));
    }
    if !patterns.is_empty() {
        let is_body = |part: &Part| match read.select.of_component(part) {
            Some(role) => role == Role::Body,
            None => patterns.iter().any(|p| p.matches_part(part)),
        };
        return Ok(mesh.parts.iter().map(is_body).collect());
    }
    // The rule says what looks like a body, and names of other parts what is none.
    let (looks, roles) = (roles(mesh, &SelectOptions::default())?, roles(mesh, &read.select)?);
    let named = !read.select.cloth.is_empty() || !read.select.rigid.is_empty();
    let other = |role: Role| (named && role == Role::Rigid) || ((named || dressed) && role == Role::Cloth);
    let is_body: Vec<bool> =
        looks.iter().zip(&roles).map(|(look, r)| look.looks_like == Role::Body && !other(r.role)).collect();
    let plain = mesh.skeleton.joints.is_empty() && !named && !dressed;
    Ok(if plain && !is_body.contains(&true) { vec![true; is_body.len()] } else { is_body })
}

/// The solids of a mesh, all of which is the body, that leave the garments of another mesh outside, or those given; none if it has no area
/// that can be touched.
fn fit_mesh(
    mesh: &Mesh,
    cloth: &Mesh,
    given: Option<Given>,
    options: &ColliderOptions,
) -> Option<(Vec<Collider>, Figures, Vec<Finding>)> {
    let winding = winding(mesh);
    let parents: Vec<Option<u32>> = mesh.skeleton.joints.iter().map(|j| j.parent).collect();
    // Other samples than those of a fit.
    let mut others = samples(mesh, &winding, SAMPLES, 2);
    join_small(&mut others, &parents);
    let all = |placed: &[fit::Placed]| placed.iter().map(|p| collider(mesh, p)).collect::<Vec<_>>();
    let mut findings = Vec::new();
    let thin = MIN_THICKNESS * mesh.diagonal();
    let limits = Limits { kinds: &options.kinds, target: options.error, count: options.count, thin };
    let (missing, beneath) = match options.guess {
        Guess::On => guess::guess((mesh, &winding), cloth, &limits, options.error),
        Guess::Off => (Vec::new(), Vec::new()),
    };
    findings.extend(guessed(mesh, &missing));
    // Figures of the solids that stand for the body that is there, and then those of each that is guessed, as wide as the clothes.
    let with_missing = |placed: Vec<fit::Placed>, mut figures: Figures| {
        figures.of_each.extend(judge::each(&missing, &beneath));
        let guessed = all(&guess::narrowed(&missing)).into_iter();
        let guessed = guessed.map(|collider| Collider { guessed: true, ..collider });
        (all(&placed).into_iter().chain(guessed).collect(), figures)
    };
    if let Some(given) = given.filter(|_| !others.is_empty()) {
        let figures = judge::judge(mesh, &winding, &given.placed, &others);
        let (is_used, said) = given::judged(&given, &figures, options);
        findings.push(said);
        if is_used {
            findings.extend(given.findings);
            let (colliders, figures) = with_missing(given.placed, figures);
            return Some((colliders, figures, findings));
        }
    }
    let mut fitted = samples(mesh, &winding, SAMPLES, 1);
    join_small(&mut fitted, &parents);
    let guards = guards(mesh, &winding, &fitted);
    fitted.extend(guards);
    fitted.extend(worn(cloth, &winding, SAMPLES));
    let placed = fit::fit(&fitted, &limits);
    if placed.is_empty() {
        return None;
    }
    let figures = judge::judge(mesh, &winding, &placed, &others);
    findings.extend(missed(&figures, placed.len(), options));
    let (colliders, figures) = with_missing(placed, figures);
    Some((colliders, figures, findings))
}

/// Whether a guessed solid follows a joint.
fn stands_for(colliders: &[Collider], joint: &str) -> bool {
    colliders.iter().any(|c| c.guessed && c.joint.as_deref() == Some(joint))
}

/// A note of the parts that pass through clothes.
fn passed(mesh: &Mesh, joints: &[u32], left_out: &[bool]) -> Option<Finding> {
    let names: Vec<&str> = joints.iter().map(|j| mesh.skeleton.joints[*j as usize].name.as_str()).collect();
    let count = left_out.iter().filter(|out| **out).count();
    (count > 0).then(|| Finding {
        severity: Severity::Note,
        stage: "colliders",
        kind: "hint-passing",
        count: count as u64,
        message: format!(
            "Animations take bare parts of the body through clothes beneath which it is guessed: {count} triangles of {} are not in its surface.",
            names.join(", ")
        ),
        examples: names.iter().take(MAX_EXAMPLES).map(|name| (*name).to_owned()).collect(),
    })
}

/// A note of the joints where the body is guessed.
fn guessed(mesh: &Mesh, placed: &[fit::Placed]) -> Option<Finding> {
    let mut names: Vec<String> = Vec::new();
    for joint in placed.iter().filter_map(|p| Some(mesh.skeleton.joints.get(p.joint? as usize)?.name.clone())) {
        if !names.contains(&joint) {
            names.push(joint);
        }
    }
    (!placed.is_empty()).then(|| Finding {
        severity: Severity::Note,
        stage: "colliders",
        kind: "hint-guessed",
        count: placed.len() as u64,
        message: format!(
            "The file has no body beneath parts of the clothes: {} colliders beneath them stand for it ({}). --collider-guess off does without.",
            placed.len(),
            names.join(", ")
        ),
        examples: names.into_iter().take(MAX_EXAMPLES).collect(),
    })
}

/// Garments without their caps, which lie inside of the body.
fn worn_cloth(cloth: Mesh, read: &BuildOptions) -> Result<Mesh> {
    let opened = open_caps(repair(cloth.clone(), &read.repair)?.mesh, &read.caps);
    Ok(if opened.caps.is_empty() { cloth } else { opened.mesh })
}

/// How often a mesh winds around points.
fn winding(mesh: &Mesh) -> Winding {
    Winding::new((0..mesh.triangles.len()).map(|t| mesh.corners(t)))
}

/// A solid in both poses.
fn collider(mesh: &Mesh, placed: &fit::Placed) -> Collider {
    let solid = placed.solid;
    match placed.joint.map(|j| &mesh.skeleton.joints[j as usize]) {
        Some(joint) => {
            let bound = bound(mesh, joint, solid);
            Collider { joint: Some(joint.name.clone()), solid: solid.posed(joint), bound, guessed: false }
        }
        None => Collider { joint: None, solid, bound: solid, guessed: false },
    }
}

/// A solid of a joint where the first joint of its name is bound: meshes that are bound differently have joints of equal names.
fn bound(mesh: &Mesh, joint: &Joint, solid: Solid) -> Solid {
    let first = mesh.skeleton.joints.iter().find(|other| other.name == joint.name).unwrap_or(joint);
    if first.inverse_bind == joint.inverse_bind {
        return solid;
    }
    inverse(&first.inverse_bind).map_or(solid, |world| solid.posed(&Joint { world, ..joint.clone() }))
}

/// A note if the file poses its skeleton elsewhere than its meshes are bound, by more than the target.
fn elsewhere(mesh: &Mesh, options: &ColliderOptions) -> Option<Finding> {
    let (low, high) = mesh.bounds()?;
    let center = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
    let middle = Solid { form: Form::Sphere { radius: 1.0 }, center, rotation: [0.0, 0.0, 0.0, 1.0] };
    let moves = |joint: &Joint| distance(middle.posed(joint).center, center) > options.error;
    let count = mesh.skeleton.joints.iter().filter(|joint| moves(joint)).count();
    let message = "The file poses its skeleton in another way than its meshes are bound: colliders fit the cloth when an animation \
                   moves both (--animation), not before."
        .into();
    (count > 0).then(|| Finding {
        severity: Severity::Note,
        stage: "colliders",
        kind: "hint-pose",
        count: count as u64,
        examples: Vec::new(),
        message,
    })
}

/// The kind of the finding that colliders are far from the body.
pub(crate) const LOOSE_FIT: &str = "loose-fit";

/// A warning if the body is not within reach of the target.
fn missed(figures: &Figures, count: usize, options: &ColliderOptions) -> Option<Finding> {
    let mm = |x: f64| format!("{:.1} mm", 1e3 * x);
    let message = format!(
        "5 % of the body are more than {} from the {} colliders ({} asked for). Try a larger --max-colliders, or other --collider-shapes.",
        mm(figures.body.p95),
        count,
        mm(options.error)
    );
    // Other samples than those of the fit decide, which differ by some percent.
    (figures.body.p95 > 1.1 * options.error).then(|| Finding {
        severity: Severity::Warning,
        stage: "colliders",
        kind: LOOSE_FIT,
        count: 1,
        examples: Vec::new(),
        message,
    })
}

#[cfg(test)]
mod tests;
