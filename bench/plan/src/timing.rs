//! Frames on a clock.

use std::time::Instant;

use gimage_runtime::{Options, Result, Stepper, wgpu};

use crate::gpu::Gpu;
use crate::scenes::{Action, Case};

const FRAME: f64 = 1.0 / 60.0;
/// Frames before the clock starts: pipelines are made, and buffers first touched.
const WARM_UP: u32 = 3;

/// A stepper and, on the GPU, where it is submitted.
pub struct Host<'a> {
    /// It.
    pub stepper: Stepper,
    gpu: Option<&'a Gpu>,
}

impl<'a> Host<'a> {
    /// A case made ready.
    pub fn new(case: &Case, run: &Options, gpu: Option<&'a Gpu>) -> Result<Self> {
        let Options { backend, substeps, threads, .. } = *run;
        let options = Options { backend, substeps, threads, ..case.options.clone() };
        let mut stepper = Stepper::new(case.scene.clone(), options, gpu.map(|g| (&g.device, &g.queue)))?;
        match case.action {
            Action::None => {}
            Action::Cut => stepper.cut([0.5, 0.5, 3.0], [-4.0, 0.4, -2.0], [5.0, 0.4, -2.0])?,
            Action::Sleep => stepper.set_asleep(0, true)?,
        }
        Ok(Host { stepper, gpu })
    }

    fn frame(&mut self) -> Result<()> {
        let Some(gpu) = self.gpu else {
            return self.stepper.advance(FRAME).map(drop_progress);
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.stepper.record(&mut encoder, FRAME)?;
        gpu.queue.submit([encoder.finish()]);
        self.stepper.settle()?;
        // A lost device shows in the next call.
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        Ok(())
    }
}

fn drop_progress(_: gimage_runtime::Progress) {}

/// Milliseconds of each frame, from recording to the end of the work.
pub fn time(host: &mut Host, frames: u32) -> Result<Vec<f64>> {
    (0..WARM_UP).try_for_each(|_| host.frame())?;
    (0..frames)
        .map(|_| {
            let start = Instant::now();
            host.frame()?;
            Ok(start.elapsed().as_secs_f64() * 1e3)
        })
        .collect()
}
