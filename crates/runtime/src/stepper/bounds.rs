//! Boxes around cloths, for culling.

use super::Stepper;
use crate::bounds::Bounds;
use crate::cpu::bounds;
#[cfg(feature = "gpu")]
use crate::error::{Error, Result};
use crate::handle::ClothRef;

impl Stepper {
    /// The box around a cloth. On the CPU backend as it is now, from one pass over the particles. On the GPU backend the last one that has
    /// arrived ([`Stepper::record_bounds`]), with its age: [`Bounds::grown`] allows for what has happened since. `None` for a
    /// cloth that does not exist or has no particle, and on the GPU backend before the first box has arrived, after the cloth was
    /// teleported or put into another state, and after the device was lost. Boxes follow their cloths where other cloths come and go.
    pub fn bounds(&self, cloth: impl Into<ClothRef>) -> Option<Bounds> {
        let cloth = self.world.find(cloth.into()).ok()?;
        match (&self.cpu, &self.gpu) {
            (Some((bodies, _)), _) => {
                let body = &bodies[cloth];
                let extent = bounds::run(body.now(), body.before())?;
                Some(Bounds::new(&extent, self.world.control.clock.dt_old))
            }
            (None, Some(gpu)) => gpu.bounds(&self.world, cloth),
            (None, None) => None,
        }
    }

    /// Records the measurement of the boxes of all cloths, at that place of the encoder: after [`Stepper::record`] for the positions
    /// that are drawn. Nothing waits: [`Stepper::settle`], called once a frame after the submission, takes in what has arrived, one to three
    /// frames later, for [`Stepper::bounds`]. Teleports and states that wait for the next frame are recorded first.
    ///
    /// One dispatch per cloth, of 32 bytes read per particle, and a copy of 256 bytes per cloth. A call is skipped while four
    /// measurements are under way. Does nothing on the CPU backend. Errors without a device, and if it is lost or has no memory left.
    #[cfg(feature = "gpu")]
    pub fn record_bounds(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<()> {
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_bounds"))?;
            if stepper.cpu.is_none() {
                if !stepper.world.host.actions.is_empty() {
                    gpu.act_now(&mut stepper.world, encoder);
                }
                let all: Vec<_> = (0..stepper.world.runs.len()).collect();
                gpu.record_bounds(&mut stepper.world, encoder, &all);
            }
            Ok(())
        })
    }

    /// Drops the boxes of a cloth, as it is somewhere else.
    pub(super) fn forget_bounds(&mut self, cloth: usize) {
        if let Some(gpu) = &mut self.gpu {
            gpu.forget_bounds(cloth);
        }
    }
}
