//! Pipelines, made when a pass first needs them and kept.

use std::collections::HashMap;

use crate::gpu::layout::{FrameRow, StepRow};
use crate::passes::Pass;
use crate::shaders::{Bound, Slot, Source};

/// A pipeline and the layout of what it binds.
pub struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// By pass, constants and parts included.
#[derive(Default)]
pub struct Pipelines(HashMap<Pass, Pipeline>);

impl Pipelines {
    /// The pipeline of a pass.
    pub fn get(&mut self, device: &wgpu::Device, pass: Pass, source: &Source) -> &Pipeline {
        self.0.entry(pass).or_insert_with(|| make(device, source))
    }
}

fn make(device: &wgpu::Device, source: &Source) -> Pipeline {
    let entries: Vec<_> = source.bindings.iter().map(entry).collect();
    let label = Some(source.stem);
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(source.text().into()),
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        ..Default::default()
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        // What a workgroup has in its memory, a shader writes before it reads.
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &source.constants,
            zero_initialize_workgroup_memory: false,
        },
        cache: None,
    });
    Pipeline { pipeline, layout }
}

fn entry(bound: &Bound) -> wgpu::BindGroupLayoutEntry {
    let size = match bound.slot {
        Slot::Step => size_of::<StepRow>(),
        Slot::Frame => size_of::<FrameRow>(),
        _ => 0,
    };
    let uniform = size > 0;
    let read_only = !bound.writes;
    wgpu::BindGroupLayoutEntry {
        binding: bound.slot as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: if uniform { wgpu::BufferBindingType::Uniform } else { wgpu::BufferBindingType::Storage { read_only } },
            has_dynamic_offset: uniform,
            min_binding_size: std::num::NonZeroU64::new(size as u64),
        },
        count: None,
    }
}
