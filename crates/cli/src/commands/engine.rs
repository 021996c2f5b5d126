//! The host of a stepper: it owns the device, submits and waits.

use std::time::Instant;

use gimage_runtime::scene::Script;
use gimage_runtime::wgpu;
use gimage_runtime::{Backend, Options, Progress, Scene, Stepper, device_limits, read_back};

use crate::exit::Failure;
use crate::output::{Output, Tone};

/// A stepper and, on the GPU, what it runs on.
pub struct Engine {
    pub stepper: Stepper,
    /// What computes, in words.
    pub adapter: String,
    gpu: Option<(wgpu::Device, wgpu::Queue)>,
    script: Script,
    /// Of the host \[s\] since the start.
    time: f64,
}

impl Engine {
    /// Looks for an adapter unless the CPU is asked for. Auto takes no software adapter: the CPU backend is quicker.
    pub fn new(scene: Scene, script: Script, mut options: Options) -> Result<Self, Failure> {
        let mut adapter = "this machine's cores".to_owned();
        let mut gpu = None;
        if options.backend != Backend::Cpu {
            match device() {
                Ok((info, device, queue)) => {
                    let software = info.device_type == wgpu::DeviceType::Cpu;
                    if options.backend == Backend::Gpu || !software {
                        adapter = info.name;
                        gpu = Some((device, queue));
                    }
                }
                Err(words) if options.backend == Backend::Gpu => {
                    let hint =
                        "install a Vulkan driver (Debian: libvulkan1 and that of the card, or mesa-vulkan-drivers)";
                    return Err(Failure::refused(format!("{words}; {hint}, or use --backend cpu")));
                }
                Err(_) => {}
            }
        }
        if gpu.is_none() {
            options.backend = Backend::Cpu;
        }
        let stepper = Stepper::new(scene, options, gpu.as_ref().map(|(d, q)| (d, q)))?;
        Ok(Engine { stepper, adapter, gpu, script, time: 0.0 })
    }

    /// Says which settings were beyond the solver's limits, and were changed.
    pub fn warn(&self, out: &Output) {
        let each = self.stepper.warnings();
        each.iter().for_each(|warning| out.remark(Tone::Warning, "warning", &warning.to_string()));
    }

    /// Does what the script has for the next `dt` seconds, steps through them and waits.
    pub fn frame(&mut self, dt: f64) -> Result<Progress, Failure> {
        self.script.frame(&mut self.stepper, self.time, dt)?;
        self.time += dt;
        let start = Instant::now();
        let progress = self.step(dt)?;
        self.stepper.took(progress.steps, start.elapsed().as_secs_f64() * 1e3);
        Ok(progress)
    }

    fn step(&mut self, dt: f64) -> Result<Progress, Failure> {
        let Some((device, queue)) = &self.gpu else { return Ok(self.stepper.advance(dt)?) };
        let mut encoder = device.create_command_encoder(&Default::default());
        let progress = self.stepper.record(&mut encoder, dt)?;
        queue.submit([encoder.finish()]);
        let wait = device.poll(wgpu::PollType::wait_indefinitely());
        wait.map_err(|e| Failure::refused(format!("the GPU stopped: {e}")))?;
        if self.stepper.options().quality.target().is_some() {
            self.stepper.settle()?;
        }
        Ok(progress)
    }

    /// Time \[s\] of the last frame.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Device and queue on the GPU backend.
    pub fn gpu(&self) -> Option<&(wgpu::Device, wgpu::Queue)> {
        self.gpu.as_ref()
    }

    /// Positions of a cloth as they are now.
    pub fn positions(&self, cloth: usize) -> Result<Vec<[f32; 4]>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth)) {
            (Some((device, queue)), Some(buffers)) => Ok(read_back(device, queue, &buffers.now)?),
            _ => Ok(self.stepper.positions(cloth).unwrap_or_default().to_vec()),
        }
    }
}

/// The fastest adapter, with what it offers of what the runtime can use.
fn device() -> Result<(wgpu::AdapterInfo, wgpu::Device, wgpu::Queue), String> {
    let instance = wgpu::Instance::default();
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let wish = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    let adapter = pollster::block_on(instance.request_adapter(&wish)).map_err(|e| format!("no GPU: {e}"))?;
    let wish = wgpu::DeviceDescriptor { required_limits: device_limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&wish)).map_err(|e| format!("no GPU: {e}"))?;
    Ok((adapter.get_info(), device, queue))
}
