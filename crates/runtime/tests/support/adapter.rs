//! The device that tests of the GPU run on. A test without one prints one line and counts as skipped; with
//! GIMAGE_REQUIRE_GPU=1 it fails.

#[path = "../../../../tests/src/skip.rs"]
mod skip;

pub use skip::skip;

/// A device that has what every WebGPU implementation has.
pub fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    device_with(|_| wgpu::Limits::default())
}

/// Any adapter.
pub fn any() -> Option<wgpu::Adapter> {
    let found = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()));
    found.map_or_else(|error| lacking(&format!("no GPU adapter: {error}")), Some)
}

/// A device with other limits.
pub fn device_with(limits: impl Fn(&wgpu::Adapter) -> wgpu::Limits) -> Option<(wgpu::Device, wgpu::Queue)> {
    let adapter = any()?;
    let wish = wgpu::DeviceDescriptor { required_limits: limits(&adapter), ..Default::default() };
    let found = pollster::block_on(adapter.request_device(&wish));
    let name = adapter.get_info().name;
    found.map_or_else(|error| lacking(&format!("the adapter {name} gives no device: {error}")), Some)
}

/// Skips the test for what the adapter lacks, or fails where a GPU is required.
pub fn lacking<T>(what: &str) -> Option<T> {
    let required = std::env::var("GIMAGE_REQUIRE_GPU").is_ok_and(|v| v == "1");
    assert!(!required, "GIMAGE_REQUIRE_GPU is 1, but: {what}; install mesa-vulkan-drivers");
    skip(what);
    None
}
