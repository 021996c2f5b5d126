//! Cloths that have changed their level a short time ago, as the meshes that are bound to them see it.
//!
//! The surfaces of two levels differ, so that a bound vertex would jump at the change. It keeps the way of that jump in its frame on the new
//! level, and loses it little by little.

use std::sync::{Arc, OnceLock};

use super::World;
use crate::coarser::Coarser;
use crate::cpu::jump;
use crate::cpu::rows::Threads;
use crate::cpu::wrap::{Jumps, Sheet};
use crate::error::Result;
use crate::layout::JumpRow;
use crate::render_mesh::{Bound, RenderMesh};

/// How long \[s\] a vertex takes to lose the way of a jump.
const FADE_S: f64 = 0.25;

/// The share of the way that is left some time \[s\] after a jump: a smooth step from 1 to 0. 0 at a time before it, to which a saved state leads.
pub fn share(seconds: f64) -> f32 {
    if seconds < -FADE_S {
        return 0.0;
    }
    let t = (seconds / FADE_S).clamp(0.0, 1.0);
    (1.0 - t * t * (3.0 - 2.0 * t)) as f32
}

/// Positions and normals of a cloth on one level.
pub struct Surface {
    pub positions: Vec<[f32; 4]>,
    pub normals: Vec<[f32; 4]>,
}

/// A change of level of a cloth that the CPU steps.
pub struct Arrival {
    /// When \[s\].
    pub since: f64,
    /// The steps from the finest level to the one that it has left.
    pub steps: Vec<Coarser>,
    pub left: Surface,
    pub reached: Surface,
    /// The change before, if vertices had not lost its jump then.
    pub earlier: Option<Arc<Arrival>>,
    /// The jumps of the first mesh that was asked for.
    pub jumps: OnceLock<(Arc<Bound>, Arc<Vec<JumpRow>>)>,
}

impl Surface {
    fn sheet(&self) -> Sheet<'_> {
        Sheet { now: &self.positions, before: &self.positions, normals: &self.normals, fraction: 1.0 }
    }
}

impl Arrival {
    /// The share of the jumps that is left at a time \[s\].
    pub fn share(&self, time: f64) -> f32 {
        share(time - self.since)
    }

    /// The jumps of the vertices of a mesh, which are bound to the new level by `bound`.
    pub fn jumps(
        &self,
        threads: &Threads,
        cloth: &str,
        mesh: &RenderMesh,
        bound: &Arc<Bound>,
    ) -> Result<Arc<Vec<JumpRow>>> {
        if let Some((_, known)) = self.jumps.get().filter(|known| Arc::ptr_eq(&known.0, bound)) {
            return Ok(known.clone());
        }
        let (old, mut vertices) = (mesh.binding.on(cloth, &self.steps)?, Vec::new());
        let rows = self.earlier.as_ref().map(|earlier| earlier.jumps(threads, cloth, mesh, &old)).transpose()?;
        let share = self.earlier.as_ref().map_or(0.0, |earlier| earlier.share(self.since));
        let jumps = rows.as_ref().map(|rows| Jumps { rows, share });
        old.run(threads, cloth, (&self.left.sheet(), jumps), &mut vertices)?;
        let jumps = Arc::new(jump::run(self.reached.sheet(), &bound.rows, &vertices));
        // Another mesh of the same cloth is looked up afresh in each call.
        _ = self.jumps.set((bound.clone(), jumps.clone()));
        Ok(jumps)
    }
}

impl World {
    /// The steps from the finest level of a cloth to the one that it is on.
    pub fn steps(&self, cloth: usize) -> Vec<Coarser> {
        self.runs[cloth].finer.iter().map(|finer| finer.coarser.clone()).collect()
    }

    /// The time \[s\] at a fraction of the last step.
    pub fn time_at(&self, fraction: f32) -> f64 {
        let [time, dt, _] = self.control.clock.numbers();
        time - (1.0 - f64::from(fraction)) * dt
    }

    /// Forgets changes of level whose jumps are lost.
    pub fn forget_arrivals(&mut self) {
        // A host may still draw between the last two steps.
        let time = self.time_at(0.0);
        for run in &mut self.runs {
            run.arrival.take_if(|arrival| arrival.share(time) == 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_lost_little_by_little() {
        let shares: Vec<f32> = (0..=30).map(|n| share(f64::from(n) / 100.0)).collect();
        assert_eq!((shares[0], shares[25], shares[30], share(-0.1), share(-10.0)), (1.0, 0.0, 0.0, 1.0, 0.0));
        assert!(shares.windows(2).all(|s| s[1] <= s[0] && s[0] - s[1] < 0.07), "{shares:?}");
    }
}
