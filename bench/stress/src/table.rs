//! Results of all cases, for people and as CSV.

use std::fmt::Write;

use crate::case::{Asked, SOLVERS, Stretch, Tried};
use crate::drive::Outcome;

/// A case under all solvers; none where it was not tried.
pub struct Entry {
    pub name: String,
    pub step: f64,
    pub substeps: u32,
    pub asked: Asked,
    pub outcomes: Vec<Option<Outcome>>,
}

impl Entry {
    /// The outcomes of the solvers tried.
    pub fn tried(&self) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().flatten()
    }

    /// A line: the name, then what failed under each solver.
    pub fn line(&self) -> String {
        let mut line = format!("{:48}", self.name);
        for outcome in &self.outcomes {
            let words = match outcome {
                None => "-".into(),
                Some(o) if o.failures.is_empty() && o.limited.is_empty() => "ok".into(),
                Some(o) if o.failures.is_empty() => format!("ok, limited: {}", o.limited.join(" ")),
                Some(o) => o.failures.join("; "),
            };
            let _ = write!(line, " | {words:24}");
        }
        line
    }
}

/// Survived and tried, solver by solver.
pub fn sum(entries: &[Entry]) -> String {
    let count = |s: usize, ok: bool| {
        let of = |e: &&Entry| e.outcomes[s].as_ref().is_some_and(|o| !ok || o.failures.is_empty());
        entries.iter().filter(of).count()
    };
    let each = |s: usize| format!("{} {} of {}", SOLVERS[s].name, count(s, true), count(s, false));
    format!("survived: {}", [0, 1, 2].map(each).join(", "))
}

/// A line a case and solver.
pub fn csv(entries: &[Entry]) -> String {
    let mut out = "case,solver,step_s,substeps,verdict,failures,stretch_judged,stretch_2s,rest_mm_s,rest_before_mm_s,drift_mm,momentum,\
                   energy_gain,first_lost_frame,particles_lost,limited\n"
        .to_owned();
    for e in entries {
        for (outcome, Tried { name: solver, tethers, .. }) in e.outcomes.iter().zip(SOLVERS) {
            let Some(o) = outcome else { continue };
            let (verdict, failures) = (if o.failures.is_empty() { "ok" } else { "failed" }, o.failures.join("; "));
            let judged = match e.asked.stretch {
                Stretch::Judged | Stretch::OfLongest => true,
                Stretch::WithTethers => tethers > 0,
                Stretch::Open => false,
            };
            let (Entry { name, step, substeps, asked, .. }, judged) = (e, u8::from(judged));
            let _ = write!(out, "\"{name}\",{solver},{step:.6},{substeps},{verdict},\"{failures}\",{judged}");
            let _ = write!(out, ",{:.3e},{:.3e},{:.3e}", o.stretch, o.rest, o.rest_before);
            for (asked, x) in [(asked.drift, o.drift), (asked.momentum, o.momentum), (asked.energy, o.energy)] {
                let _ = if asked { write!(out, ",{x:.3e}") } else { write!(out, ",") };
            }
            let _ = match o.broke {
                Some((frame, count)) => write!(out, ",{frame},{count}"),
                None => write!(out, ",,"),
            };
            let _ = writeln!(out, ",{}", o.limited.join(" "));
        }
    }
    out
}
