//! Cost of a round of polish against a substep, from the passes of both.

use super::World;
use crate::choose::stiff;
use crate::options::Solver;
use crate::passes::{Air, Pass, Schedule, Soft};

/// Colliders of which each adds to the time of contact; of more than these, most are out of reach.
const MAX_COLLIDERS: usize = 4;

/// Time per particle of a pass on the CPU among a number of colliders, that of a colour of structural springs being 1
/// (1.3e-3 ms on 64 x 64 particles). Fitted to the times of frames of 0 to 16 rounds: hanging sheets with and without tethers
/// and wind, a sheet on a sphere, a T-shirt on four capsules.
fn of_pass(pass: &Pass, colliders: usize) -> f64 {
    match *pass {
        Pass::Stretch { soft: Soft::Constant | Soft::Image, .. } => 1.8,
        // Diagonal springs share their loads.
        Pass::Stretch { direction, .. } if direction >= 2 => 0.5,
        Pass::Stretch { .. } | Pass::Polish { .. } => 1.0,
        Pass::Tethers { slots } => 1.7 * f64::from(slots),
        Pass::Seams => 3.0,
        Pass::Integrate(Air::Push) | Pass::IntegrateExact(Air::Push) => 22.0,
        Pass::Wind { .. } => 10.0,
        Pass::Contact(_) => 12.0 * colliders.min(MAX_COLLIDERS) as f64,
        Pass::Pyramid { .. } | Pass::Refine { .. } => 20.0,
        // Counted with those above.
        Pass::CoarseLevel { .. } | Pass::CoarseTies { .. } => 0.0,
        Pass::Membrane { .. } | Pass::Moments { .. } | Pass::Bend => 5.0,
        _ => 2.0,
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
            each.map(|(c, cloth)| cloth.len() as f64 * self.of_step(c, &self.schedule(c, &settings))).sum::<f64>()
        };
        // Tethers that come with the first round alone count as a part of the substep.
        let round = with(2) - with(1);
        Some(round / (with(1) - round))
    }

    /// Time of a step per particle.
    fn of_step(&self, cloth: usize, schedule: &Schedule) -> f64 {
        let (options, colliders) = (&self.control.options, self.solid_count(cloth));
        let sum = |passes: &[Pass]| passes.iter().map(|p| of_pass(p, colliders)).sum::<f64>();
        let coarse = if options.pyramid > 0 { sum(&schedule.coarse) / f64::from(options.pyramid) } else { 0.0 };
        sum(&schedule.air) / f64::from(self.hold(cloth))
            + sum(&schedule.step)
            + coarse
            + f64::from(options.iterations) * sum(&schedule.relax)
    }
}

#[cfg(test)]
#[path = "work_tests.rs"]
mod tests;
