//! What makes frames: a stepper and, on the GPU, where it is submitted.

use gimage_runtime::{Backend, ClothBuffers, Error, Options, Result, Scene, Span, Stepper, read_back};

use crate::figures::V3;
use crate::gpu::Gpu;

/// A scene in motion.
pub struct Host<'a> {
    pub stepper: Stepper,
    gpu: Option<&'a Gpu>,
}

impl<'a> Host<'a> {
    /// A scene at its start.
    pub fn new(scene: Scene, options: Options, gpu: Option<&'a Gpu>) -> Result<Self> {
        let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
        let stepper = Stepper::new(scene, Options { backend, ..options }, gpu.map(|g| (&g.device, &g.queue)))?;
        Ok(Host { stepper, gpu })
    }

    /// Makes a frame of `seconds`.
    pub fn frame(&mut self, seconds: f64) -> Result<()> {
        let Some(gpu) = self.gpu else { return self.stepper.advance(seconds).map(|_| ()) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.stepper.record(&mut encoder, seconds)?;
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Positions of the cloth \[m\].
    pub fn now(&self) -> Result<Vec<V3>> {
        self.list(self.stepper.positions(0), |b| &b.now)
    }

    /// The same a step before.
    pub fn before(&self) -> Result<Vec<V3>> {
        self.list(self.stepper.previous(0), |b| &b.before)
    }

    fn list(&self, here: Option<&[[f32; 4]]>, which: fn(&ClothBuffers) -> &Span) -> Result<Vec<V3>> {
        let there = self.gpu.zip(self.stepper.buffers(0));
        let read = there.map(|(gpu, b)| read_back(&gpu.device, &gpu.queue, which(b)));
        let list = match (here, read) {
            (Some(list), _) => list.to_vec(),
            (None, Some(read)) => read?,
            (None, None) => return Err(Error::NoGpu("reading positions")),
        };
        Ok(list.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect())
    }
}
