//! The device of this machine that the cloth may run on.

use gimage_runtime::wgpu;
use gimage_runtime::{SelfCheck, device_features, device_limits, self_check};

/// A device, and the adapter that it is from.
pub struct Device {
    pub info: wgpu::AdapterInfo,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

impl Device {
    /// That of the fastest adapter, with the limits that the runtime can use. The error says why there is none.
    pub fn fastest() -> Result<Self, String> {
        let power_preference = wgpu::PowerPreference::HighPerformance;
        let wish = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
        let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&wish));
        Device::of(&adapter.map_err(|e| format!("no GPU: {e}"))?)
    }

    /// That of an adapter.
    pub fn of(adapter: &wgpu::Adapter) -> Result<Self, String> {
        let (required_limits, required_features) = (device_limits(adapter), device_features(adapter));
        let wish = wgpu::DeviceDescriptor { required_limits, required_features, ..Default::default() };
        let found = pollster::block_on(adapter.request_device(&wish));
        let (device, queue) = found.map_err(|e| format!("no GPU: {e}"))?;
        Ok(Device { info: adapter.get_info(), device, queue })
    }

    /// Whether it is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Its self-check, which runs once in a process.
    pub fn check(&self) -> SelfCheck {
        self_check(&self.device, &self.queue)
    }
}
