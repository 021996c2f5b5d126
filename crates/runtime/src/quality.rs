//! Chooses the numbers of substeps and of rounds of polish of a frame, from the remaining stretch and the cost of both.

mod chooser;
mod cost;
mod law;
mod reach;
mod saved;

pub use chooser::Chooser;
pub use saved::{NUMBERS, Numbers};

use crate::error::{Result, check};

/// Numbers of substeps and of rounds of polish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    pub substeps: u32,
    pub rounds: u32,
}

/// Which numbers a chooser may change, and what they cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levers {
    /// Cost of a round of polish, that of a substep without any being 1; none where the number of rounds is fixed.
    pub round: Option<f64>,
    /// Rounds at the start.
    pub start: u32,
    /// Fewest substeps, unless a budget has no room for them.
    pub fewest: u32,
}

impl Levers {
    /// Cost of a substep with `rounds` rounds.
    fn of_substep(&self, rounds: u32) -> f64 {
        1.0 + self.round.unwrap_or(0.0) * f64::from(rounds)
    }

    /// Cost of a frame.
    fn cost(&self, mix: Mix) -> f64 {
        f64::from(mix.substeps) * self.of_substep(mix.rounds)
    }
}

/// How the numbers of substeps and of rounds of polish are chosen from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Quality {
    /// Always [`crate::Options::substeps`]. No cost.
    #[default]
    Fixed,
    /// As many substeps as take at most this time \[ms\] in [`crate::Options::step`], from the times that the host reports
    /// ([`crate::Stepper::took`]), or from timestamps of the GPU where it has them ([`crate::device_features`]) and the host settles
    /// ([`crate::Stepper::settle`]); unchanged until a time is known. Above 0. A frame is modelled as a fixed part plus a part per
    /// step, so that normals and other work once per frame do not count as steps. Results then depend on a clock.
    Budget(f64),
    /// The cheapest numbers of substeps and of rounds of polish, at most 256 and 32, that keep the error at or below this value;
    /// 1e-4 to 1, 0.01 is 1 %. The error is the largest stretch of a spring to the right or down (length / rest length - 1, not below 0) at the end of a frame,
    /// over cloths that are awake. Where cloth has a compliance or a material, only a share of a stretch is error, that
    /// which one relaxation takes away (`w dt^2 / (w dt^2 + compliance)`, w being the sum of the inverse masses): more
    /// than is left of relaxation rather than less. For a material the compliance is that of square cells.
    ///
    /// Both numbers start as those of [`crate::Choice`]. Each change is a measurement of what it brought, from which the stepper
    /// foretells the error of other numbers; their cost is computed from the passes. Rounds of polish change on the CPU only (on
    /// the GPU they are part of compiled pipelines), and stay as they are where the host gave them ([`crate::Options::polish`])
    /// and in scenes whose cloths all have a compliance or a material. Substeps do not fall below those that fast colliders
    /// need. Without a mix that meets the target, the cost ends at that of 256 substeps with the rounds of the start. Costs a pass over the particles per frame. Deterministic on
    /// the CPU; on the GPU the number of substeps changes when measurements have come back ([`crate::Stepper::settle`]), so
    /// runs repeat if the host waits for each frame before it settles.
    Error(f64),
    /// As `Error`, but never more than `Budget` allows: the budget wins.
    ErrorWithin {
        /// As in `Error`.
        stretch: f64,
        /// As in `Budget`.
        ms: f64,
    },
}

impl Quality {
    /// The quality that keeps the largest stretch at or below `stretch` and frames within `ms`, where these are given.
    pub fn of(stretch: Option<f64>, ms: Option<f64>) -> Self {
        match (stretch, ms) {
            (None, None) => Quality::Fixed,
            (None, Some(ms)) => Quality::Budget(ms),
            (Some(stretch), None) => Quality::Error(stretch),
            (Some(stretch), Some(ms)) => Quality::ErrorWithin { stretch, ms },
        }
    }

    pub(crate) fn check(self) -> Result<()> {
        if let Some(ms) = self.budget() {
            check("the budget [ms]", ms, "above 0", |b| b > 0.0)?;
        }
        if let Some(stretch) = self.target() {
            check("the error (largest stretch)", stretch, "1e-4 to 1", |e| (1e-4..=1.0).contains(&e))?;
        }
        Ok(())
    }

    /// The largest stretch that is asked for, if any.
    pub fn target(self) -> Option<f64> {
        match self {
            Quality::Error(stretch) | Quality::ErrorWithin { stretch, .. } => Some(stretch),
            _ => None,
        }
    }

    /// The time that is allowed \[ms\], if any.
    pub fn budget(self) -> Option<f64> {
        match self {
            Quality::Budget(ms) | Quality::ErrorWithin { ms, .. } => Some(ms),
            _ => None,
        }
    }
}
