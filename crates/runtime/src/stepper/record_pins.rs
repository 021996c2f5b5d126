//! Pins from a buffer on the GPU.

use wgpu::{BufferUsages, CommandEncoder};

use super::Stepper;
use crate::error::{Error, Result};
use crate::gpu::Span;
use crate::handle::ClothRef;

impl Stepper {
    /// Records that particles, and their seam duplicates, are put at positions that lie in a buffer of the host, and at rest:
    /// [`Stepper::set_pins`] without the way through the host's memory. 8 bytes of upload per particle, and one dispatch. Calls
    /// that wait for the next frame are recorded first. GPU backend only.
    ///
    /// `positions` is an array of `vec4<f32>` \[m\], one per particle, whose w is not read; the buffer has the usage `STORAGE`, and
    /// the span begins at a multiple of 256 bytes. Nothing looks whether positions are finite: a frame with one that is
    /// not is taken back ([`crate::ClothBuffers::faults`]). Errors if there is no such cloth or particle, on the CPU backend, and if the
    /// span is too small, too far out or lacks the usage; then nothing is recorded.
    pub fn record_pins(
        &mut self,
        encoder: &mut CommandEncoder,
        cloth: impl Into<ClothRef>,
        particles: &[u32],
        positions: &Span,
    ) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let all = self.world.scene.cloths[cloth].with_duplicates(particles)?;
        self.refuse_cpu("Stepper::record_pins", "Stepper::set_pins")?;
        let need = Span { size: positions.size.min(16 * particles.len() as u64), ..positions.clone() };
        if need.size < 16 * particles.len() as u64 || !need.offset.is_multiple_of(256) {
            let hint = "give 16 bytes per particle, from a multiple of 256 on";
            return Err(self.wrong_buffer(
                cloth,
                "positions of pins",
                16 * particles.len() as u64,
                positions.size,
                "STORAGE",
                hint,
            ));
        }
        self.fits(cloth, &need, (BufferUsages::STORAGE, "STORAGE"), "positions of pins")?;
        self.refuse_joined(cloth, all.iter().map(|[k, _]| *k))?;
        if all.is_empty() {
            return Ok(());
        }
        self.world.wake(cloth);
        // How fast these pins are, the host alone knows.
        self.world.control.follow.stir();
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_pins"))?;
            gpu.act_now(&mut stepper.world, encoder);
            gpu.place_from(encoder, cloth, &all, &need);
            stepper.world.host.touched = true;
            Ok(())
        })
    }
}
