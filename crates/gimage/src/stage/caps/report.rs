//! The finding about caps.

use super::Cap;
use crate::base::words::{counted, number, triangles};
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// The caps that are left out.
pub(super) fn finding(caps: &[Cap]) -> Option<Finding> {
    let count: usize = caps.iter().map(|cap| cap.triangles.len()).sum();
    (!caps.is_empty()).then(|| Finding {
        severity: Severity::Repair,
        stage: "caps",
        kind: "caps-opened",
        count: caps.len() as u64,
        examples: caps.iter().take(MAX_EXAMPLES).map(words).collect(),
        message: format!(
            "{} across openings of garments left out of the cloth ({}): they get no image, and the drawn mesh keeps them. --caps keep makes cloth \
             of them.",
            counted(caps.len(), "cap", "caps"),
            triangles(count)
        ),
    })
}

fn words(cap: &Cap) -> String {
    let around = match &cap.bone {
        Some(bone) => format!("around the bone to {bone}"),
        None => "without a bone".into(),
    };
    format!("{}: {} with a border of {} m, {around}", cap.node, triangles(cap.triangles.len()), number(cap.length))
}
