//! Findings of the stages: repairs, accessories, choices and limits.

use serde::Serialize;

/// How much a [`Finding`] matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Lossless or asked for: the result is what the input says.
    Note,
    /// The input was changed, or part of it went elsewhere.
    Repair,
    /// The result is sound but worse than it could be.
    Warning,
}

/// One change or observation of a stage, with its number and places.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// The stage by name: `import`, `repair`, `component`, ...
    pub stage: &'static str,
    /// A fixed kebab-case name of the kind of thing, such as `duplicate-faces`.
    pub kind: &'static str,
    /// How often.
    pub count: u64,
    /// Up to [`MAX_EXAMPLES`] places, as words: "triangle 17", "vertex 3 at (0.1, 0.2, 0.3)".
    pub examples: Vec<String>,
    /// One sentence for people.
    pub message: String,
}

/// Largest number of examples per finding.
pub const MAX_EXAMPLES: usize = 4;
