//! Messages about the choice of parts.

use std::collections::BTreeSet;

use super::{Role, Verdict, facts};
use crate::base::mesh::{Mesh, Part};
use crate::base::words::{counted, triangles};
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// Names of parts that a message lists.
const LISTED: usize = 30;

/// The names in a file, as a hint.
pub(super) fn names(parts: &[Part]) -> String {
    let (mut list, mut seen): (Vec<&str>, BTreeSet<&str>) = Default::default();
    for name in parts.iter().flat_map(|p| [&p.node, &p.mesh, &p.material]).filter(|name| !name.is_empty()) {
        if seen.insert(name) {
            list.push(name);
        }
        if list.len() > LISTED {
            break;
        }
    }
    if list.is_empty() {
        return "the file names none; `*` matches all".into();
    }
    let shown = list.iter().take(LISTED).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let more = if list.len() > LISTED { ", ... (`gimage list` shows all)" } else { "" };
    format!("choose from {shown}{more}")
}

/// The name that a message has for a part: node, else mesh, else material; `NODE/MATERIAL` if the node has several materials.
pub(super) fn label(part: &Part) -> String {
    let name = [&part.node, &part.mesh, &part.material].into_iter().find(|name| !name.is_empty());
    let name = name.cloned().unwrap_or_else(|| "the part without a name".into());
    let tells = part.has_siblings && !part.node.is_empty() && !part.material.is_empty();
    let name = if tells { format!("{name}/{}", part.material) } else { name };
    part.component.map_or(name.clone(), |number| format!("{name} (component {number})"))
}

/// Names that the message gives per role.
const NAMED: usize = 8;

/// The finding about the parts that were left out. `asked`: by flags, not by the rule.
pub(super) fn left_out(mesh: &Mesh, verdicts: &[Verdict], asked: bool) -> Finding {
    let mut counts = vec![0usize; mesh.parts.len()];
    mesh.triangle_part.iter().for_each(|&p| counts[p as usize] += 1);
    let parts = |role: Role| (0..counts.len()).filter(move |&p| verdicts[p].role == role);
    let listed = |role: Role| {
        let mut seen = BTreeSet::new();
        let mut names: Vec<String> = parts(role).filter(|&p| counts[p] > 0).map(|p| label(&mesh.parts[p])).collect();
        names.retain(|name| seen.insert(name.clone()));
        let more = names.len().saturating_sub(NAMED);
        names.truncate(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        (!names.is_empty()).then(|| format!("{}: {}{more}", role.name(), names.join(", ")))
    };
    let roles: Vec<String> =
        [Role::Cloth, Role::Body, Role::Rigid, Role::Other].into_iter().filter_map(listed).collect();
    let out: Vec<usize> = (0..counts.len()).filter(|&p| counts[p] > 0 && verdicts[p].role != Role::Cloth).collect();
    let lost: usize = out.iter().map(|&p| counts[p]).sum();
    let left = format!("{} ({}) left out", counted(out.len(), "part", "parts"), triangles(lost));
    let roles = roles.join("; ");
    let message = if asked {
        format!("{left}; {roles}.")
    } else {
        format!(
            "{left}, as they look like a body or props; {roles}. Choose with --cloth, --body or \
             --rigid; `gimage list` shows why."
        )
    };
    let example = |&p: &usize| {
        let Verdict { role, reason, .. } = &verdicts[p];
        let why = if reason.is_empty() { String::new() } else { format!(" ({reason})") };
        format!("{}: {}{why}", label(&mesh.parts[p]), role.name())
    };
    Finding {
        severity: if asked { Severity::Note } else { Severity::Repair },
        stage: "select",
        kind: "left-out",
        count: out.len() as u64,
        examples: out.iter().take(MAX_EXAMPLES).map(example).collect(),
        message,
    }
}

/// The parts and what they look like, as a hint: those that follow the most joints first, as cloth does.
pub(super) fn candidates(mesh: &Mesh, verdicts: &[Verdict]) -> String {
    let mut counts = vec![0usize; mesh.parts.len()];
    mesh.triangle_part.iter().for_each(|&p| counts[p as usize] += 1);
    let following = facts::following(mesh);
    let mut parts: Vec<usize> = (0..counts.len()).filter(|&p| counts[p] > 0).collect();
    parts.sort_by_key(|&p| (std::cmp::Reverse(following[p].joints), p));
    let one = |&p: &usize| {
        let Verdict { looks_like, reason, .. } = &verdicts[p];
        let size = triangles(counts[p]);
        format!("`{}` ({size}; looks like {}: {reason})", label(&mesh.parts[p]), looks_like.name())
    };
    let shown = parts.iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ");
    let more = if parts.len() > NAMED { ", ..." } else { "" };
    format!("its parts are {shown}{more}; `gimage list` shows their sizes and loops")
}

/// The warning where nothing in a skinned file looks like cloth; all parts are built.
pub(super) fn no_cloth(mesh: &Mesh, verdicts: &[Verdict]) -> Finding {
    let mut has = vec![false; mesh.parts.len()];
    mesh.triangle_part.iter().for_each(|&p| has[p as usize] = true);
    let parts: Vec<usize> = (0..has.len()).filter(|&p| has[p]).collect();
    let example = |&p: &usize| {
        let Verdict { looks_like, reason, .. } = &verdicts[p];
        format!("{} looks like {} ({reason})", label(&mesh.parts[p]), looks_like.name())
    };
    Finding {
        severity: Severity::Warning,
        stage: "select",
        kind: "no-cloth",
        count: parts.len() as u64,
        examples: parts.iter().take(MAX_EXAMPLES).map(example).collect(),
        message:
            "No part of this skinned file looks like cloth, so all parts became cloth. Choose with --cloth, --body or \
                  --rigid; `gimage list` shows the parts."
                .into(),
    }
}
