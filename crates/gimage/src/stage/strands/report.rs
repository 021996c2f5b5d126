//! The finding about strands.

use super::Strand;
use crate::base::words::{counted, number, triangles};
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// The strands that are left out.
pub(super) fn finding(strands: &[Strand]) -> Option<Finding> {
    let count: usize = strands.iter().map(|strand| strand.triangles.len()).sum();
    (!strands.is_empty()).then(|| Finding {
        severity: Severity::Repair,
        stage: "strands",
        kind: "strands-left-out",
        count: strands.len() as u64,
        examples: strands.iter().take(MAX_EXAMPLES).map(words).collect(),
        message: format!(
            "{} left out of the cloth ({}): texels are as wide as they are, so the drawn mesh has them ride on the cloth. --strands keep makes \
             cloth of them.",
            counted(strands.len(), "strand, such as a drawstring,", "strands, such as drawstrings,"),
            triangles(count)
        ),
    })
}

fn words(strand: &Strand) -> String {
    let [length, around] = [strand.length, strand.around].map(number);
    format!("{}: {}, {length} m long and {around} m around", strand.node, triangles(strand.triangles.len()))
}
