//! Work that brings the clock of a device to the speed of a game in which it is never idle.

use std::time::{Duration, Instant};

use gimage_runtime::wgpu;

/// How long it works. A GPU that has been idle runs at a fraction of its clock for some tens of milliseconds.
const LENGTH: Duration = Duration::from_millis(200);
const WORKGROUPS: u32 = 1024;

/// Keeps a device busy for a fifth of a second; a software adapter has no such clock.
pub fn wake(device: &wgpu::Device, queue: &wgpu::Queue) {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu {
        return;
    }
    let module = device.create_shader_module(wgpu::include_wgsl!("wake.wgsl"));
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("wake"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("wake"),
        size: u64::from(4 * 256 * WORKGROUPS),
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("wake"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
    });
    let start = Instant::now();
    while start.elapsed() < LENGTH {
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(WORKGROUPS, 1, 1);
        }
        queue.submit([encoder.finish()]);
        // A lost device shows in the next call.
        let _ = device.poll(wgpu::PollType::wait_indefinitely());
    }
}
