//! What a round of polish costs against a substep, from the passes of both.

use super::World;
use crate::choose::{Settings, stiff};
use crate::options::Solver;
use crate::passes::{Air, Pass, Schedule, Soft};

/// Time per particle of a pass on the CPU, that of a colour of springs without compliance being 1.
fn of_pass(pass: &Pass) -> f64 {
    match *pass {
        Pass::Stretch { soft: Soft::None, .. } | Pass::Polish { .. } => 1.0,
        Pass::Stretch { .. } => 2.0,
        Pass::Tethers { slots } => f64::from(slots),
        Pass::Integrate(Air::None) | Pass::Advance(Air::None) => 2.0,
        Pass::Integrate(_) | Pass::Advance(_) => 40.0,
        Pass::Wind { .. } => 400.0,
        Pass::Contact(_) => 4.0,
        Pass::Membrane { .. } | Pass::Pyramid { .. } | Pass::Refine { .. } => 10.0,
        _ => 1.0,
    }
}

impl World {
    /// Cost of a round of polish, that of a substep without any being 1; none where the number of rounds does not change
    /// from frame to frame: where the host gave it or no error is asked for, for cloth whose stretch is wanted, and on the GPU, where it
    /// is compiled into whole frames and tiles.
    pub fn cost_of_round(&self) -> Option<f64> {
        let options = &self.control.options;
        let open = options.quality.target().is_some() && !self.control.choice.given[1] && self.room.is_none();
        if !open || options.solver != Solver::Xpbd || !self.scene.cloths.iter().any(stiff) {
            return None;
        }
        let with = |polish| {
            let mut settings = options.clone();
            settings.polish = polish;
            let each = self.scene.cloths.iter().enumerate();
            each.map(|(c, cloth)| cloth.len() as f64 * of_step(&self.schedule(c, &settings), options)).sum::<f64>()
        };
        // The last tethers of a step without polish are part of the first round.
        let round = with(2) - with(1);
        Some(round / (with(1) - round))
    }
}

/// Time of a step.
fn of_step(schedule: &Schedule, options: &Settings) -> f64 {
    let sum = |passes: &[Pass]| passes.iter().map(of_pass).sum::<f64>();
    let coarse = if options.pyramid > 0 { sum(&schedule.coarse) / f64::from(options.pyramid) } else { 0.0 };
    sum(&schedule.step) + coarse + f64::from(options.iterations) * sum(&schedule.relax)
}
