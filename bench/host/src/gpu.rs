//! The device that benchmarks step on.

use gimage_runtime::{device_limits, wgpu};

use crate::clock::Clock;

/// A device, its queue and its adapter.
pub struct Gpu {
    /// Its device.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// The name and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    /// Its clock, if it has one.
    pub(crate) clock: Option<Clock>,
}

impl Gpu {
    /// The fastest adapter, with what it offers of what the runtime can use.
    pub fn new() -> Result<Self, Box<dyn std::error::Error>> {
        Self::with(device_limits)
    }

    /// The fastest adapter, with the limits that every device of WebGPU has.
    pub fn of_the_web() -> Result<Self, Box<dyn std::error::Error>> {
        Self::with(|_| wgpu::Limits::default())
    }

    fn with(limits: impl Fn(&wgpu::Adapter) -> wgpu::Limits) -> Result<Self, Box<dyn std::error::Error>> {
        let power_preference = wgpu::PowerPreference::HighPerformance;
        let wish = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
        let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&wish))?;
        let required_features = adapter.features() & Clock::FEATURES;
        let wish =
            wgpu::DeviceDescriptor { required_limits: limits(&adapter), required_features, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wish))?;
        let clock = Clock::new(&device, &queue);
        Ok(Gpu { device, queue, info: adapter.get_info(), clock })
    }
}
