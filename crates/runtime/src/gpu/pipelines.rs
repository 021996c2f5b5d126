//! Pipelines, compiled once and shared by steppers that are made from one another.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use web_time::Instant;

use crate::form::Form;
use crate::layout::{FrameRow, StepRow};
use crate::shaders::{Bound, Slot, Source, source};

/// A pipeline, the layout of what it binds, and its entry in the table of shaders.
pub struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
    pub source: Source,
    /// Whether a device has raised an error in a call that compiled it: then it may not work.
    failed: AtomicBool,
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

/// By form, constants and parts included. A pipeline that is being compiled has its place already.
type ByForm = HashMap<Form, Arc<OnceLock<Arc<Pipeline>>>>;

/// The pipelines of steppers that are made from one another. Others compile meanwhile: the list is locked while a place is looked up,
/// and a place while its own pipeline is compiled.
#[derive(Clone)]
pub struct Shared {
    device: wgpu::Device,
    cache: Option<wgpu::PipelineCache>,
    made: Arc<Mutex<ByForm>>,
}

impl Shared {
    /// Whether there is a pipeline of a form.
    pub fn has(&self, form: &Form) -> bool {
        self.lock().get(form).is_some_and(|place| place.get().is_some())
    }

    /// The pipeline of a form, compiled now if there is none, which `compiled` counts.
    pub fn make(&self, form: &Form, compiled: &mut Compiled) -> Arc<Pipeline> {
        let place = self.lock().entry(form.clone()).or_default().clone();
        let compile = || {
            let start = Instant::now();
            let pipeline = Arc::new(make(&self.device, self.cache.as_ref(), source(form)));
            compiled.pipelines += 1;
            compiled.ms += start.elapsed().as_secs_f64() * 1e3;
            pipeline
        };
        place.get_or_init(compile).clone()
    }

    /// Drops the pipeline of a form, which may have failed, also where other steppers use it.
    pub fn forget(&self, form: &Form) {
        let place = self.lock().remove(form);
        if let Some(pipeline) = place.as_ref().and_then(|place| place.get()) {
            pipeline.failed.store(true, Ordering::Relaxed);
        }
    }

    /// Of the pipelines that there are, what `choose` returns the least key for.
    fn least<K: Ord>(&self, choose: impl Fn(&Form) -> Option<K>) -> Option<Arc<Pipeline>> {
        let made = self.lock();
        let chosen = made.iter().filter_map(|(form, place)| Some((choose(form)?, place.get()?)));
        chosen.min_by(|a, b| a.0.cmp(&b.0)).map(|(_, pipeline)| pipeline.clone())
    }

    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    fn lock(&self) -> MutexGuard<'_, ByForm> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The pipelines of a stepper. Steppers made from one another share what they compile. A device alone does not tell whose
/// pipelines fit: those of different wgpu instances may be equal.
pub struct Pipelines {
    shared: Shared,
    /// Those that this stepper has used, without a lock.
    used: HashMap<Form, Arc<Pipeline>>,
    /// Those that it has compiled in a call that has not ended.
    fresh: Vec<Form>,
    pub compiled: Compiled,
}

impl Pipelines {
    /// None yet. Those that the driver has in a cache need no compilation.
    pub fn new(device: &wgpu::Device, cache: Option<&wgpu::PipelineCache>) -> Self {
        let shared = Shared { device: device.clone(), cache: cache.cloned(), made: Arc::default() };
        Pipelines::of(&shared)
    }

    /// For another stepper on the same device.
    pub fn share(&self) -> Self {
        Pipelines::of(&self.shared)
    }

    fn of(shared: &Shared) -> Self {
        Pipelines { shared: shared.clone(), used: HashMap::new(), fresh: Vec::new(), compiled: Compiled::default() }
    }

    /// The host's cache of them.
    #[cfg(not(target_family = "wasm"))]
    pub fn cache(&self) -> Option<&wgpu::PipelineCache> {
        self.shared.cache.as_ref()
    }

    /// Keeps what was compiled in a call that has ended without an error.
    pub fn keep(&mut self) {
        self.fresh.clear();
    }

    /// Drops what was compiled in a call that has failed.
    pub fn forget(&mut self) {
        self.fresh.drain(..).for_each(|form| self.shared.forget(&form));
    }

    /// Those of all steppers.
    pub fn shared(&self) -> &Shared {
        &self.shared
    }

    /// The pipeline of a form.
    pub fn get(&mut self, form: &Form) -> &Pipeline {
        if self.used.get(form).is_none_or(|pipeline| pipeline.failed.load(Ordering::Relaxed)) {
            let before = self.compiled.pipelines;
            let pipeline = self.shared.make(form, &mut self.compiled);
            if self.compiled.pipelines > before {
                self.fresh.push(form.clone());
            }
            self.used.insert(form.clone(), pipeline);
        }
        &self.used[form]
    }

    /// A pipeline that does what that of a form does: where that is not compiled, one with room for larger cloths if there is any, so
    /// that the cloths of a frame change without a compilation.
    pub fn fitting(&mut self, form: &Form) -> &Pipeline {
        let Form::Whole(small) = form else { return self.get(form) };
        if !self.used.contains_key(form) && !self.shared.has(form) {
            let room = |other: &Form| match other {
                Form::Whole(f) if small.fits(f) => Some((f.threads, f.places)),
                _ => None,
            };
            if let Some(pipeline) = self.shared.least(room) {
                self.used.insert(form.clone(), pipeline);
            }
        }
        self.get(form)
    }
}

/// A stepper that is dropped in the call that makes it has failed.
impl Drop for Pipelines {
    fn drop(&mut self) {
        self.forget();
    }
}

fn make(device: &wgpu::Device, cache: Option<&wgpu::PipelineCache>, source: Source) -> Pipeline {
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
        // Shaders write the memory of a workgroup before they read it.
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &source.constants,
            zero_initialize_workgroup_memory: false,
        },
        cache,
    });
    Pipeline { pipeline, layout, source, failed: AtomicBool::new(false) }
}

fn entry(bound: &Bound) -> wgpu::BindGroupLayoutEntry {
    let size = match bound.slot {
        Slot::Step => size_of::<StepRow>(),
        Slot::Frame => size_of::<FrameRow>(),
        Slot::Batch | Slot::Part => 16,
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

#[cfg(test)]
#[path = "pipelines_tests.rs"]
mod tests;
