//! Findings about garments that are held.

use super::{Hold, Rule, Tuck};
use crate::base::words::counted;
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// A note about all garments, and a warning about those that do not rest on the body.
pub(super) fn findings(garments: &[Hold]) -> Vec<Finding> {
    let words = |hold: &Hold| {
        let rules: Vec<&str> = hold.rules.iter().map(|r| r.words()).collect();
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        format!(
            "{} ({} pinned, {} limited): {}",
            hold.name,
            percent(hold.pinned),
            percent(hold.limited),
            rules.join(" and ")
        )
    };
    let list = |holds: &[&Hold]| {
        let mut text = holds.iter().take(MAX_EXAMPLES).map(|h| words(h)).collect::<Vec<_>>().join("; ");
        if holds.len() > MAX_EXAMPLES {
            text += &format!("; and {} more", holds.len() - MAX_EXAMPLES);
        }
        text
    };
    let finding = |severity, kind, holds: &[&Hold], message| Finding {
        severity,
        stage: "hold",
        kind,
        count: holds.len() as u64,
        examples: holds.iter().take(MAX_EXAMPLES).map(|h| h.name.clone()).collect(),
        message,
    };
    let mut out = Vec::new();
    let tucked: Vec<&Hold> = garments.iter().filter(|h| h.tuck.added > 0).collect();
    if !tucked.is_empty() {
        let one = |hold: &&Hold| {
            let Tuck { found, added, deepest } = hold.tuck;
            format!(
                "{} ({found} pins more than 5 mm inside, at most {:.1} mm; {added} points beside them)",
                hold.name,
                1e3 * deepest
            )
        };
        let listed = tucked.iter().take(MAX_EXAMPLES).map(one).collect::<Vec<_>>().join("; ");
        let message = format!(
            "Cloth that was modelled into the body around pins is pinned too, where it is inside: {listed}. Choose otherwise with --pin."
        );
        out.push(finding(Severity::Note, "hint-tucked", &tucked, message));
    }
    let hiding: Vec<&Hold> = garments.iter().filter(|h| h.hems > 0).collect();
    if !hiding.is_empty() {
        let one = |hold: &&Hold| format!("{} of {}", counted(hold.hems, "border", "borders"), hold.name);
        let listed = hiding.iter().take(MAX_EXAMPLES).map(one).collect::<Vec<_>>().join("; ");
        let message = format!(
            "The body ends beneath clothes: {listed} would show it in motion, and stay near their place on the skin. Choose otherwise with --pin."
        );
        out.push(finding(Severity::Note, "hint-ends", &hiding, message));
    }
    let covered: Vec<&Hold> = garments.iter().filter(|h| !h.over.is_empty()).collect();
    if !covered.is_empty() {
        let one =
            |hold: &&Hold| format!("{} over {} ({:.1} %)", hold.over.join(" and "), hold.name, 100.0 * hold.covered);
        let mut listed = covered.iter().take(MAX_EXAMPLES).map(one).collect::<Vec<_>>().join("; ");
        if covered.len() > MAX_EXAMPLES {
            listed += &format!("; and {} more", covered.len() - MAX_EXAMPLES);
        }
        let message = format!(
            "Garments lie over others: {listed}. Near pins and the body, covered cloth stays near the skin, and the cloth over it stays in front. Choose otherwise with --pin."
        );
        out.push(finding(Severity::Note, "hint-layers", &covered, message));
    }
    let (loose, held): (Vec<&Hold>, Vec<&Hold>) = garments.iter().partition(|h| h.rules.contains(&Rule::Top));
    if !held.is_empty() {
        let message = format!("Pinned where garments rest on the body: {}. Choose otherwise with --pin.", list(&held));
        out.push(finding(Severity::Note, "hint-pins", &held, message));
    }
    if !loose.is_empty() {
        let message =
            format!("These do not rest on the body, or all of them does: {}. Choose with --pin.", list(&loose));
        out.push(finding(Severity::Warning, "rests-nowhere", &loose, message));
    }
    out
}
