//! Findings about thin shells.

use super::verdict::Doubt;
use super::{Layer, Shell};
use crate::base::words::{counted, number, triangles};
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use crate::stage::component::Component;

/// The shells that became single layers, and those that are kept because they are doubtful.
pub(super) fn findings(shells: &[Shell], doubts: &[Doubt], components: &[Component]) -> Vec<Finding> {
    let mut out = Vec::new();
    if let Some(first) = shells.first() {
        let bound: usize = shells.iter().map(|s| s.bound_triangles).sum();
        let place = if first.layer == Layer::Mid { "moved halfway to the inner one" } else { "where it is" };
        out.push(Finding {
            severity: Severity::Repair,
            stage: "shell",
            kind: "thin-shell",
            count: shells.len() as u64,
            examples: shells.iter().take(MAX_EXAMPLES).map(words).collect(),
            message: format!(
                "{} became one layer of cloth: the outer sheet, {place}. The inner sheets and rims ({}) get no image; --shell keep \
                 keeps both sheets.",
                counted(shells.len(), "thin shell", "thin shells"),
                triangles(bound)
            ),
        });
    }
    if !doubts.is_empty() {
        out.push(Finding {
            severity: Severity::Warning,
            stage: "shell",
            kind: "thin-shell-kept",
            count: doubts.len() as u64,
            examples: doubts.iter().take(MAX_EXAMPLES).map(|d| doubt(d, components)).collect(),
            message: "Components look like thin shells, but are kept with both sheets, which may cross in the images. \
                      Delete one of the sheets in the file if the fabric is one layer."
                .into(),
        });
    }
    out
}

fn words(shell: &Shell) -> String {
    let [low, high] = shell.range.map(|x| number(1e3 * x));
    let alone = if shell.alone > 0 { format!(", {} of one layer among them", shell.alone) } else { String::new() };
    format!(
        "{}: {} mm thick ({low} to {high} mm), {:.0} % of the area faced, {} of {} stay{alone}",
        shell.name,
        number(1e3 * shell.thickness),
        100.0 * shell.share,
        shell.triangles,
        triangles(shell.triangles + shell.bound_triangles)
    )
}

fn doubt(doubt: &Doubt, components: &[Component]) -> String {
    let names: Vec<&str> = doubt.components.iter().map(|&c| components[c as usize].name.as_str()).collect();
    format!("{}: {}", names.join(" and "), doubt.reason)
}
