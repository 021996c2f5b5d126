//! What makes frames: a stepper and, on the GPU, where it is submitted.

use std::time::Instant;

use gimage_runtime::{Options, Progress, Scene, Stepper, read_back, wgpu};

use crate::Failure;
use crate::gpu::Gpu;

/// Length of a frame \[s\].
const FRAME: f64 = 1.0 / 60.0;

/// A scene in motion.
pub struct Host<'a> {
    stepper: Stepper,
    gpu: Option<&'a Gpu>,
}

impl<'a> Host<'a> {
    /// A scene at its start.
    pub fn new(scene: Scene, options: Options, gpu: Option<&'a Gpu>) -> Result<Self, Failure> {
        let stepper = Stepper::new(scene, options, gpu.map(|g| (&g.device, &g.queue)))?;
        Ok(Host { stepper, gpu })
    }

    /// Makes a frame; its milliseconds, from recording to the end of the work.
    pub fn frame(&mut self) -> Result<f64, Failure> {
        let start = Instant::now();
        let Some(gpu) = self.gpu else {
            let Progress { .. } = self.stepper.advance(FRAME)?;
            return Ok(start.elapsed().as_secs_f64() * 1e3);
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.stepper.record(&mut encoder, FRAME)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    /// Steps per frame, as they are made: no fewer than the solver can do with.
    pub fn substeps(&self) -> u32 {
        self.stepper.options().substeps
    }

    /// Positions of the cloth.
    pub fn positions(&self) -> Result<Vec<[f32; 4]>, Failure> {
        match (self.gpu, self.stepper.buffers(0)) {
            (Some(gpu), Some(buffers)) => Ok(read_back(&gpu.device, &gpu.queue, &buffers.now)?),
            _ => Ok(self.stepper.positions(0).unwrap_or_default().to_vec()),
        }
    }
}
