//! Gathers what the importer met, one finding a kind.

use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// Findings in the order in which their kinds were first met.
#[derive(Default)]
pub(crate) struct Findings(Vec<Finding>);

impl Findings {
    /// Counts `count` more of a kind, with one place as an example.
    pub fn add(
        &mut self,
        severity: Severity,
        kind: &'static str,
        count: usize,
        message: &str,
        example: impl FnOnce() -> String,
    ) {
        if count == 0 {
            return;
        }
        let at = self.0.iter().position(|f| f.kind == kind).unwrap_or_else(|| {
            self.0.push(Finding {
                severity,
                stage: "import",
                kind,
                count: 0,
                examples: Vec::new(),
                message: message.into(),
            });
            self.0.len() - 1
        });
        let finding = &mut self.0[at];
        finding.count += count as u64;
        if finding.examples.len() < MAX_EXAMPLES {
            finding.examples.push(example());
        }
    }

    pub fn into_vec(self) -> Vec<Finding> {
        self.0
    }
}
