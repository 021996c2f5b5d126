//! The host of a stepper: it owns the device, submits and waits.

use gimage_runtime::wgpu;
use gimage_runtime::{Backend, Options, Scene, Stepper, read_back};

use crate::exit::Failure;

/// A stepper and, on the GPU, what it runs on.
pub struct Engine {
    pub stepper: Stepper,
    /// What computes, in words.
    pub adapter: String,
    gpu: Option<(wgpu::Device, wgpu::Queue)>,
}

impl Engine {
    /// Looks for an adapter unless the CPU is asked for. Auto takes no software adapter: the CPU backend is quicker.
    pub fn new(scene: Scene, mut options: Options) -> Result<Self, Failure> {
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
        Ok(Engine { stepper, adapter, gpu })
    }

    /// Steps a frame of `dt` seconds and waits for it.
    pub fn frame(&mut self, dt: f64) -> Result<(), Failure> {
        let Some((device, queue)) = &self.gpu else {
            self.stepper.advance(dt)?;
            return Ok(());
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        self.stepper.record(&mut encoder, dt)?;
        queue.submit([encoder.finish()]);
        let wait = device.poll(wgpu::PollType::wait_indefinitely());
        wait.map(|_| ()).map_err(|e| Failure::refused(format!("the GPU stopped: {e}")))
    }

    /// Positions of a cloth as they are now.
    pub fn positions(&self, cloth: usize) -> Result<Vec<[f32; 4]>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth)) {
            (Some((device, queue)), Some(buffers)) => Ok(read_back(device, queue, &buffers.now)?),
            _ => Ok(self.stepper.positions(cloth).unwrap_or_default().to_vec()),
        }
    }
}

/// The fastest adapter, with the limits that every one has but the larger buffers that it offers.
fn device() -> Result<(wgpu::AdapterInfo, wgpu::Device, wgpu::Queue), String> {
    let instance = wgpu::Instance::default();
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let wish = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    let adapter = pollster::block_on(instance.request_adapter(&wish)).map_err(|e| format!("no GPU: {e}"))?;
    let offered = adapter.limits();
    let required_limits = wgpu::Limits {
        max_buffer_size: offered.max_buffer_size,
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
        ..wgpu::Limits::default()
    };
    let wish = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&wish)).map_err(|e| format!("no GPU: {e}"))?;
    Ok((adapter.get_info(), device, queue))
}
