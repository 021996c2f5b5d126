//! Findings about stitches.

use super::panel::Panel;
use super::partly::Partly;
use crate::base::words::{counted, number};
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// The stitches that were made: their number, the panels that they join, and how far apart points may be \[m\].
pub(super) fn sewn(count: usize, joined: &[&Panel], distance: f64, estimated: bool) -> Finding {
    let how = if estimated { "estimated from the borders" } else { "as given" };
    Finding {
        severity: Severity::Note,
        stage: "stitch",
        kind: "stitched",
        count: count as u64,
        examples: joined.iter().take(MAX_EXAMPLES).map(|p| p.name.clone()).collect(),
        message: format!(
            "{} tie {} that touch or overlap, up to {} mm apart ({how}); --stitch METRES sets the distance, --stitch none leaves \
             pieces loose.",
            counted(count, "stitch", "stitches"),
            counted(joined.len(), "piece", "pieces"),
            number(1e3 * distance)
        ),
    }
}

/// Panels that would fall off, or hang on a small part of a border, each tied at a distance \[m\] larger than that of the others.
pub(super) fn farther(panels: &[(&Panel, f64)]) -> Option<Finding> {
    let words = |(panel, far): &(&Panel, f64)| format!("{}: up to {} mm", panel.name, number(1e3 * far));
    let message = format!(
        "{} that nothing would hold, or a small part of a border, {} tied over larger distances than the rest; --stitch METRES sets one for all.",
        counted(panels.len(), "piece", "pieces"),
        if panels.len() == 1 { "is" } else { "are" }
    );
    about(Severity::Note, "hint-stitched", panels, words, message)
}

/// Panels that are sewn along a part of their borders near others.
pub(super) fn partly(panels: &[(&Panel, Partly)]) -> Option<Finding> {
    let words = |(panel, partly): &(&Panel, Partly)| {
        let [sewn, near] = partly.lengths.map(number);
        format!("{}: {sewn} of {near} m", panel.name)
    };
    let (_, Partly { far, .. }) = panels.first()?;
    let message = format!(
        "{} sewn along a part of the borders that are near other pieces, and may hang askew: --stitch {}? sews more.",
        counted(panels.len(), "piece is", "pieces are"),
        number(1e-4 * (1e4 * far).ceil())
    );
    about(Severity::Note, "hint-partly-sewn", panels, words, message)
}

/// Panels that nothing holds while others are pinned, with the distance of each to the nearest other panel \[m\].
pub(super) fn loose(panels: &[(&Panel, Option<f64>)]) -> Option<Finding> {
    let words = |(panel, gap): &(&Panel, Option<f64>)| match gap {
        Some(gap) => format!("{}: {} mm from the nearest piece", panel.name, number(1e3 * gap)),
        None => panel.name.clone(),
    };
    let message = format!(
        "Nothing holds {}: no pin, and no stitch to a piece that is held. In motion they fall off. Pin them (--pin), tie them by a \
         larger distance (--stitch METRES), or leave them out (--rigid).",
        counted(panels.len(), "piece", "pieces")
    );
    about(Severity::Warning, "loose-piece", panels, words, message)
}

/// A finding about panels, each in words; none of no panel.
fn about<T>(
    severity: Severity,
    kind: &'static str,
    panels: &[T],
    words: impl Fn(&T) -> String,
    message: String,
) -> Option<Finding> {
    let (count, examples) = (panels.len() as u64, panels.iter().take(MAX_EXAMPLES).map(words).collect());
    (count > 0).then_some(Finding { severity, stage: "stitch", kind, count, examples, message })
}
