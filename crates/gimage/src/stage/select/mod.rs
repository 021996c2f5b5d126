//! Chooses the parts of a file that become cloth, by the names that the user gives or by a rule.

mod divide;
mod facts;
mod keep;
mod pattern;
mod report;
mod rule;
mod words;

use serde::Serialize;

use crate::base::mesh::Mesh;
use crate::error::{Error, Result};
use crate::options::{Range, stage_options};
use crate::record::Finding;

pub use divide::{component_numbers, divided};
pub(crate) use facts::{Following, following};
pub(crate) use keep::{apart, keeping};
pub use pattern::Pattern;
use report::{label, names};

stage_options! {
    /// Options of [`select`].
    pub struct SelectOptions of "select" {
        /// Build only the parts whose node, mesh or material has one of these names, separated by commas; * stands for any text,
        /// letter case is ignored; NODE/MATERIAL chooses one material of a node; component:K chooses a connected component by the number that `gimage list` shows. Other parts are left out and reported. Without --cloth, a rule leaves
        /// out bodies and props of characters and reports them; all parts of other files are cloth.
        pub cloth: Vec<Pattern> = Vec::new() => "cloth" [""] Range::Any;
        /// Leave out these parts, which are a body; names as for --cloth. Without --cloth, the rule decides about the other parts, which
        /// are cloth if none of them looks like it.
        pub body: Vec<Pattern> = Vec::new() => "body" [""] Range::Any;
        /// Leave out these parts, which move rigidly, such as armour; names as for --cloth. Without --cloth, the rule decides about the
        /// other parts, which are cloth if none of them looks like it.
        pub rigid: Vec<Pattern> = Vec::new() => "rigid" [""] Range::Any;
    }
}

/// How a part of a file is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Becomes images.
    Cloth,
    /// A body or a part of one: left out.
    Body,
    /// Moves rigidly, such as armour or a staff: left out.
    Rigid,
    /// Not named by --cloth: left out.
    Other,
}

impl Role {
    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Role::Cloth => "cloth",
            Role::Body => "body",
            Role::Rigid => "rigid",
            Role::Other => "other",
        }
    }
}

/// The role of a part, and why it has that role.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The role.
    pub role: Role,
    /// The role that it looks like; another than `role` only where nothing in a skinned file looks like cloth.
    pub looks_like: Role,
    /// The reason in a few words, such as `name has "cape"`; empty where all parts are cloth without a choice.
    pub reason: String,
}

impl Verdict {
    fn new(role: Role, reason: impl Into<String>) -> Self {
        Self { role, looks_like: role, reason: reason.into() }
    }
}

/// The parts of a mesh that become cloth.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    /// The mesh without the other parts; the same mesh if all parts are cloth.
    pub mesh: Mesh,
    /// The parts left out, as findings.
    pub findings: Vec<Finding>,
}

/// The role of each part of an imported mesh, in the order of [`Mesh::parts`]. Components that the options choose by number are parts of their own ([`divided`]). O(triangles + parts x patterns).
///
/// Errors: [`Error::Option`] if a pattern matches no part (it lists the names that exist), if two flags choose one part, or if
/// nothing is left as cloth.
pub fn roles(mesh: &Mesh, options: &SelectOptions) -> Result<Vec<Verdict>> {
    let verdicts = assigned(mesh, options)?;
    let named = options.chosen().iter().any(|(_, patterns, _)| !patterns.is_empty());
    if named && !mesh.triangle_part.iter().any(|&p| verdicts[p as usize].role == Role::Cloth) {
        let problem = "no part is left that is cloth".to_owned();
        let hint = format!("name the cloth with --cloth: {}", names(&mesh.parts));
        return Err(Error::Option { option: "cloth".into(), problem, hint });
    }
    Ok(verdicts)
}

/// As [`roles`], of a mesh that may have no cloth.
pub(crate) fn assigned(mesh: &Mesh, options: &SelectOptions) -> Result<Vec<Verdict>> {
    let chosen = options.chosen();
    if chosen.iter().all(|(_, patterns, _)| patterns.is_empty()) {
        let all = Verdict::new(Role::Cloth, "");
        return Ok(rule::verdicts(mesh).unwrap_or_else(|| vec![all; mesh.parts.len()]));
    }
    for (option, patterns, _) in chosen {
        if let Some(unmet) = patterns.iter().find(|p| !mesh.parts.iter().any(|part| p.matches_part(part))) {
            return Err(unmatched(mesh, option, unmet));
        }
    }
    let mut verdicts = Vec::with_capacity(mesh.parts.len());
    for part in &mesh.parts {
        let mut verdict: Option<(&str, Verdict)> = None;
        for (option, patterns, role) in chosen {
            // A number goes before a name: `--cloth component:3 --body Body`.
            let counts = |p: &&Pattern| p.matches_part(part) && (part.component.is_none() || p.component().is_some());
            let Some(pattern) = patterns.iter().find(counts) else { continue };
            if let Some((first, _)) = verdict {
                return Err(Error::Option {
                    option: option.into(),
                    problem: format!("`{pattern}` matches {}, which --{first} chooses too", label(part)),
                    hint: "give patterns that share no part".into(),
                });
            }
            verdict = Some((option, Verdict::new(role, format!("--{option} {pattern}"))));
        }
        verdicts.push(verdict.map(|(_, verdict)| verdict));
    }
    Ok(with_rest(mesh, verdicts, options.cloth.is_empty()))
}

/// The role of each part: the chosen one if there is one. Other parts have the role that they look like if no flag names the cloth (`open`), and are
/// left out if one does.
fn with_rest(mesh: &Mesh, chosen: Vec<Option<Verdict>>, open: bool) -> Vec<Verdict> {
    let looks = open.then(|| rule::verdicts(mesh)).flatten();
    let is_left = |p: &&u32| chosen[**p as usize].is_none();
    let looks_cloth = |looks: &Vec<Verdict>| {
        mesh.triangle_part.iter().filter(is_left).any(|p| looks[*p as usize].looks_like == Role::Cloth)
    };
    let looks = looks.filter(looks_cloth);
    let rest = |part: usize| match &looks {
        Some(looks) => Verdict::new(looks[part].looks_like, looks[part].reason.clone()),
        None => Verdict::new(if open { Role::Cloth } else { Role::Other }, ""),
    };
    chosen.into_iter().enumerate().map(|(part, verdict)| verdict.unwrap_or_else(|| rest(part))).collect()
}

/// The error for a pattern that matches nothing, with what exists.
pub(crate) fn unmatched(mesh: &Mesh, option: &str, pattern: &Pattern) -> Error {
    let (problem, hint) = match pattern.component() {
        Some(number) => {
            let count = component_numbers(mesh).1;
            let last = count.saturating_sub(1);
            (
                format!("there is no component {number}"),
                format!("choose from component:0 to component:{last}; `gimage list` shows them"),
            )
        }
        None => (format!("no node, mesh or material matches `{pattern}`"), names(&mesh.parts)),
    };
    Error::Option { option: option.into(), problem, hint }
}

/// Leaves out the parts that are not cloth, and reports them. Errors: those of [`roles`].
pub fn select(mesh: Mesh, options: &SelectOptions) -> Result<Selected> {
    let verdicts = roles(&mesh, options)?;
    let findings = findings(&mesh, &verdicts, options);
    let keep: Vec<bool> = verdicts.iter().map(|v| v.role == Role::Cloth).collect();
    let mesh = if keep.iter().all(|k| *k) { mesh } else { keeping(mesh, &keep) };
    Ok(Selected { mesh, findings })
}

/// Refuses a skinned file of which no part looks like cloth, and one of a single part that has hands or a face, unless the options choose parts: all of it would
/// become cloth.
///
/// Errors: [`Error::Option`], which lists the parts and what they look like, or says how to choose components.
pub(crate) fn demand_cloth(file: &str, mesh: &Mesh, options: &SelectOptions) -> Result<()> {
    if !(options.cloth.is_empty() && options.body.is_empty() && options.rigid.is_empty()) {
        return Ok(());
    }
    if let Some(joint) = facts::is_single(mesh).then(|| bare_joint(mesh)).flatten() {
        let problem = format!("the one part of {file} follows the joint {joint}: hands and face would become cloth");
        let hint = "name its garments with --cloth component:K,...; `gimage list` shows the numbers, sizes and loops of its components (`*` takes all of it)";
        return Err(Error::Option { option: "cloth".into(), problem, hint: hint.into() });
    }
    let verdicts = roles(mesh, options)?;
    if mesh.triangle_part.iter().any(|p| verdicts[*p as usize].looks_like == Role::Cloth) {
        return Ok(());
    }
    let problem = format!("no part of {file} looks like cloth, and its armour or body would become cloth");
    let hint = format!("name the cloth with --cloth (`*` takes all parts); {}", report::candidates(mesh, &verdicts));
    Err(Error::Option { option: "cloth".into(), problem, hint })
}

/// The joint that tells that the mesh has hands and a face.
fn bare_joint(mesh: &Mesh) -> Option<&str> {
    words::bare(&facts::names(mesh, &facts::joints(mesh)))
}

/// The finding about a choice; none if all parts are cloth and look like it.
pub(crate) fn findings(mesh: &Mesh, verdicts: &[Verdict], options: &SelectOptions) -> Vec<Finding> {
    let asked = !(options.cloth.is_empty() && options.body.is_empty() && options.rigid.is_empty());
    let of = |p: &u32| &verdicts[*p as usize];
    if mesh.triangle_part.iter().any(|p| of(p).role != Role::Cloth) {
        vec![report::left_out(mesh, verdicts, asked)]
    } else if mesh.triangle_part.iter().any(|p| of(p).looks_like != Role::Cloth) {
        vec![report::no_cloth(mesh, verdicts)]
    } else {
        Vec::new()
    }
}

#[cfg(test)]
mod tests;
