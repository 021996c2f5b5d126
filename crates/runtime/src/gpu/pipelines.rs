//! Pipelines, compiled once and shared by steppers that are made from one another.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use web_time::Instant;

use crate::form::Form;
use crate::layout::{FrameRow, StepRow};
use crate::shaders::{Bound, Slot, Source, source};

/// A pipeline, the layout of what it binds, and its entry in the table of shaders.
pub struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
    pub source: Source,
}

impl Pipeline {
    /// Its bindings, `buffer` being where a slot lies.
    pub fn bind<'a>(
        &self,
        device: &wgpu::Device,
        buffer: impl Fn(Slot) -> Option<wgpu::BufferBinding<'a>>,
    ) -> wgpu::BindGroup {
        let entry = |bound: &Bound| {
            let resource = wgpu::BindingResource::Buffer(buffer(bound.slot)?);
            Some(wgpu::BindGroupEntry { binding: bound.slot as u32, resource })
        };
        let entries: Vec<_> = self.source.bindings.iter().filter_map(entry).collect();
        let (label, layout) = (Some(self.source.stem), &self.layout);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries })
    }
}

/// The pipelines that a stepper has compiled so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compiled {
    /// Pipelines, without those that a stepper had compiled that this one was made from ([`crate::Stepper::another`]).
    pub pipelines: u32,
    /// Wall time of their compilation \[ms\].
    pub ms: f64,
}

/// By form, constants and parts included.
type ByForm = HashMap<Form, Arc<Pipeline>>;

/// The pipelines of a stepper. Steppers made from one another share what they compile. A device alone does not tell whose
/// pipelines fit: those of different wgpu instances may be equal.
pub struct Pipelines {
    device: wgpu::Device,
    shared: Arc<Mutex<ByForm>>,
    /// Those that this stepper has used, without a lock.
    used: ByForm,
    pub compiled: Compiled,
}

impl Pipelines {
    /// None yet.
    pub fn new(device: &wgpu::Device) -> Self {
        let (shared, used) = (Arc::default(), ByForm::new());
        Pipelines { device: device.clone(), shared, used, compiled: Compiled::default() }
    }

    /// For another stepper on the same device.
    pub fn share(&self) -> Self {
        Pipelines { shared: self.shared.clone(), ..Pipelines::new(&self.device) }
    }

    /// The pipeline of a form.
    pub fn get(&mut self, form: &Form) -> &Pipeline {
        self.find(form, |_| None)
    }

    /// A pipeline that does what that of a form does: where that is not compiled, one with room for larger cloths if there is any, so
    /// that the cloths of a frame change without a compilation.
    pub fn fitting(&mut self, form: &Form) -> &Pipeline {
        let Form::Whole(small) = form else { return self.get(form) };
        let room = |other: &Form| match other {
            Form::Whole(f) if small.fits(f) => Some((f.threads, f.places)),
            _ => None,
        };
        self.find(form, |made| {
            let rooms = made.iter().filter_map(|(other, pipeline)| Some((room(other)?, pipeline)));
            rooms.min_by_key(|(room, _)| *room).map(|(_, pipeline)| pipeline.clone())
        })
    }

    /// The pipeline of a form, or what takes its place where it is not compiled.
    fn find(&mut self, form: &Form, instead: impl Fn(&ByForm) -> Option<Arc<Pipeline>>) -> &Pipeline {
        let Pipelines { device, shared, used, compiled } = self;
        if !used.contains_key(form) {
            let mut made = shared.lock().unwrap_or_else(PoisonError::into_inner);
            let known = made.get(form).cloned().or_else(|| instead(&made));
            let pipeline = known.unwrap_or_else(|| {
                let start = Instant::now();
                let pipeline = Arc::new(make(device, source(form)));
                compiled.pipelines += 1;
                compiled.ms += start.elapsed().as_secs_f64() * 1e3;
                made.insert(form.clone(), pipeline.clone());
                pipeline
            });
            used.insert(form.clone(), pipeline);
        }
        &used[form]
    }
}

fn make(device: &wgpu::Device, source: Source) -> Pipeline {
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
    Pipeline { pipeline, layout, source }
}

fn entry(bound: &Bound) -> wgpu::BindGroupLayoutEntry {
    let size = match bound.slot {
        Slot::Step => size_of::<StepRow>(),
        Slot::Frame => size_of::<FrameRow>(),
        Slot::Batch => 16,
        _ => 0,
    };
    let uniform = size > 0;
    let read_only = !bound.writes;
    wgpu::BindGroupLayoutEntry {
        binding: bound.slot as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: if uniform { wgpu::BufferBindingType::Uniform } else { wgpu::BufferBindingType::Storage { read_only } },
            has_dynamic_offset: uniform && bound.slot != Slot::Batch,
            min_binding_size: std::num::NonZeroU64::new(size as u64),
        },
        count: None,
    }
}
