//! The host that benchmarks of the runtime share: a device, and a stepper on it or on the CPU.

mod clock;
mod gpu;
mod wake;

use std::time::Instant;

use gimage_runtime::{Backend, ClothBuffers, Error, Options, Result, Scene, Span, Stepper, read_back, wgpu};

pub use gpu::Gpu;

/// Length of a frame at 60 Hz \[s\].
pub const FRAME: f64 = 1.0 / 60.0;

/// The least and the middle one of a frame's times by the clock of a device, as two columns of CSV: empty where there are none.
pub fn device_columns(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    match *times {
        [] => ",".to_owned(),
        [least, ..] => format!("{least:.4},{:.4}", times[times.len() / 2]),
    }
}

/// A scene in motion, on the GPU if there is one and on the CPU otherwise.
pub struct Host<'a> {
    /// Its stepper.
    pub stepper: Stepper,
    gpu: Option<&'a Gpu>,
}

impl<'a> Host<'a> {
    /// A scene at its start, on a GPU that is awake; the backend follows from `gpu`, whatever the options say.
    pub fn new(scene: Scene, options: Options, gpu: Option<&'a Gpu>) -> Result<Self> {
        let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
        let stepper = Stepper::new(scene, Options { backend, ..options }, gpu.map(|g| (&g.device, &g.queue)))?;
        gpu.iter().for_each(|gpu| wake::wake(&gpu.device, &gpu.queue));
        Ok(Host { stepper, gpu })
    }

    /// Makes a frame of this length \[s\]. On the GPU it is submitted, not waited for.
    pub fn frame(&mut self, seconds: f64) -> Result<()> {
        let Some(gpu) = self.gpu else {
            self.stepper.advance(seconds)?;
            // Where they are asked for, they are part of the time.
            (0..self.stepper.scene().cloths.len()).for_each(|cloth| _ = self.stepper.normals(cloth));
            return Ok(());
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        gpu.clock.iter().for_each(|clock| clock.begin(&mut encoder));
        self.stepper.record(&mut encoder, seconds)?;
        gpu.clock.iter().for_each(|clock| clock.end(&mut encoder));
        gpu.queue.submit([encoder.finish()]);
        self.stepper.settle()
    }

    /// Makes a frame of this length \[s\] and returns its time \[ms\], from recording to the end of the work.
    pub fn timed(&mut self, seconds: f64) -> Result<f64> {
        let start = Instant::now();
        self.frame(seconds)?;
        if let Some(gpu) = self.gpu {
            // A lost device shows in the next call.
            let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        }
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    /// Milliseconds that the device worked on the last frame, by its own clock and waited for; none on the CPU and on a device
    /// without timestamps.
    pub fn device_ms(&self) -> Option<f64> {
        let gpu = self.gpu?;
        gpu.clock.as_ref()?.ms(&gpu.device)
    }

    /// Positions of the first cloth \[m\].
    pub fn now(&self) -> Result<Vec<[f32; 4]>> {
        self.positions(0)
    }

    /// Positions of the first cloth one step before \[m\].
    pub fn before(&self) -> Result<Vec<[f32; 4]>> {
        self.previous(0)
    }

    /// Positions of a cloth \[m\].
    pub fn positions(&self, cloth: usize) -> Result<Vec<[f32; 4]>> {
        self.list(self.stepper.positions(cloth), cloth, |b| &b.now)
    }

    /// Positions of a cloth one step before \[m\].
    pub fn previous(&self, cloth: usize) -> Result<Vec<[f32; 4]>> {
        self.list(self.stepper.previous(cloth), cloth, |b| &b.before)
    }

    fn list(
        &self,
        here: Option<&[[f32; 4]]>,
        cloth: usize,
        which: fn(&ClothBuffers) -> &Span,
    ) -> Result<Vec<[f32; 4]>> {
        match (here, self.gpu.zip(self.stepper.buffers(cloth))) {
            (Some(list), _) => Ok(list.to_vec()),
            (None, Some((gpu, buffers))) => read_back(&gpu.device, &gpu.queue, which(buffers)),
            (None, None) => Err(Error::NoGpu("reading positions")),
        }
    }
}
