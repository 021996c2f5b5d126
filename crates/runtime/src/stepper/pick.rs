//! Picking in the cloths of a stepper.

use super::Stepper;
use crate::error::{Error, Result};
#[cfg(feature = "gpu")]
use crate::pick::{Answer, PickTicket, unit};
use crate::pick::{Hit, pick};

impl Stepper {
    /// The nearest hit of all cloths, as [`pick`]. CPU backend only.
    pub fn pick(&self, origin: [f32; 3], direction: [f32; 3]) -> Result<Option<Hit>> {
        let mut best: Option<Hit> = None;
        for (index, cloth) in self.world.scene.cloths.iter().enumerate() {
            let positions = self.positions(index).ok_or(Error::GpuOnly("Stepper::pick"))?;
            let hit = pick(cloth, positions, self.holes(index), origin, direction)?;
            let hit = hit.map(|h| Hit { cloth: index, handle: Some(self.world.handles[index]), ..h });
            best = best.into_iter().chain(hit).reduce(|a, b| if b.distance < a.distance { b } else { a });
        }
        Ok(best)
    }

    /// Records the same search on the GPU, in positions as they are at that place of the encoder. Two dispatches and
    /// three small buffers per cloth; nothing is read back until the host asks the ticket. On the CPU backend the ticket
    /// knows the answer at once. Errors on numbers that are not finite, no direction, and no device.
    #[cfg(feature = "gpu")]
    pub fn record_pick(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        origin: [f32; 3],
        direction: [f32; 3],
    ) -> Result<PickTicket> {
        if self.cpu.is_some() {
            return Ok(PickTicket(Answer::Known(self.pick(origin, direction)?)));
        }
        let direction = unit(origin, direction)?;
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_pick"))?;
            Ok(PickTicket(Answer::Pending(gpu.pick(&stepper.world, encoder, origin, direction))))
        })
    }
}
