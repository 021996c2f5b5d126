//! Work of a stepper on the host's device.

use super::Stepper;
use super::self_check::consider;
use crate::clock::Progress;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::fused::Room;
use crate::gpu::{ClothBuffers, Compiled, Gpu, Pipelines, UploadCount, guard};
use crate::handle::ClothRef;
use crate::limits::Warning;
use crate::options::{Backend, Options, Solver};
use crate::scene::Scene;
use crate::world::World;

impl Stepper {
    /// Makes a stepper for a scene. `gpu` is the host's device and queue, if it has them: then positions and normals lie in
    /// buffers on either backend ([`Stepper::buffers`]). Errors on settings out of range, on [`Backend::Gpu`] without a
    /// device, where a cloth does not fit the device, and on a device that is lost or has no memory left.
    ///
    /// The first stepper on a device runs its [`crate::self_check`], some milliseconds, unless the backend is [`Backend::Cpu`]. [`Backend::Auto`]
    /// does not use a device that fails, [`Backend::Gpu`] does; [`Stepper::warnings`] has the reason.
    ///
    /// On the GPU backend cloths with [`crate::Cloth::contact`] that cross at the start are taken apart before ([`Scene::take_apart`]), with a warning.
    ///
    /// Compiles the pipelines that a frame runs ([`Stepper::compiled`], [`Stepper::another`]).
    pub fn new(scene: Scene, options: Options, gpu: Option<(&wgpu::Device, &wgpu::Queue)>) -> Result<Self> {
        Stepper::checked(scene, options, gpu, None)
    }

    /// [`Stepper::new`] with the host's pipeline cache: pipelines that the driver finds there need no compilation, and those that are compiled
    /// go into it. The host makes the cache on the same device, from what [`wgpu::PipelineCache::get_data`] returned in an earlier run,
    /// and keeps that. The device needs the feature `PIPELINE_CACHE`, which wgpu has on Vulkan. Steppers made from this one share
    /// the cache.
    pub fn with_cache(
        scene: Scene,
        options: Options,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        cache: &wgpu::PipelineCache,
    ) -> Result<Self> {
        Stepper::checked(scene, options, Some((device, queue)), Some(Pipelines::new(device, Some(cache))))
    }

    /// Makes a stepper for another scene on the same device, as [`Stepper::new`]. The two share their pipelines: each is
    /// compiled once, by the one that first needs it.
    pub fn another(&self, scene: Scene, options: Options) -> Result<Self> {
        let gpu = self.gpu.as_ref();
        Stepper::checked(scene, options, gpu.map(Gpu::handles), gpu.map(Gpu::share_pipelines))
    }

    fn checked(
        scene: Scene,
        options: Options,
        gpu: Option<(&wgpu::Device, &wgpu::Queue)>,
        pipelines: Option<Pipelines>,
    ) -> Result<Self> {
        let mut warning = None;
        let mut options = options;
        if let Some(handles) = gpu.filter(|_| options.backend != Backend::Cpu) {
            let (on_cpu, found) = consider(options.backend, handles, pipelines.as_ref())?;
            options.backend = if on_cpu { Backend::Cpu } else { options.backend };
            warning = found;
        }
        let mut stepper = Stepper::unchecked(scene, options, gpu, pipelines)?;
        stepper.world.host.adapter = warning;
        Ok(stepper)
    }

    /// The same without a self-check, which itself needs it.
    pub(super) fn unchecked(
        scene: Scene,
        options: Options,
        gpu: Option<(&wgpu::Device, &wgpu::Queue)>,
        pipelines: Option<Pipelines>,
    ) -> Result<Self> {
        let on_cpu = match options.backend {
            Backend::Cpu => true,
            Backend::Auto => gpu.is_none(),
            Backend::Gpu if gpu.is_none() => return Err(Error::NoGpu("Backend::Gpu")),
            Backend::Gpu => false,
        };
        let mut scene = scene;
        let taken = if on_cpu { None } else { scene.take_apart(&options)? };
        let mut world = if options.solver == Solver::Xpbd {
            World::new(scene, options)?
        } else {
            World::without_bodies(scene, options)?
        };
        world.host.start = taken.map(|taken| Warning::Crossed { done: taken.to_string(), left: taken.left });
        let cpu = if on_cpu { Some((world.bodies(), Threads::new(world.control.options.threads)?)) } else { None };
        if let (false, Some((device, _))) = (on_cpu, gpu) {
            let tuning = world.control.options.tuning;
            let cloths = world.scene.cloths.len();
            world.make_room(Room::of(device).tuned(tuning).among(cloths));
        }
        let make = |handles: (&wgpu::Device, &wgpu::Queue)| {
            let pipelines = pipelines.unwrap_or_else(|| Pipelines::new(handles.0, None));
            guard(handles.0, || Gpu::new(&world, handles, pipelines, on_cpu))
        };
        let mut gpu = gpu.map(make).transpose()?;
        gpu.iter_mut().for_each(Gpu::succeeded);
        Ok(Stepper { world, cpu, gpu })
    }

    /// Records a frame of `dt` \[s\] of the host's time: as many steps as are due, then normals. On the CPU backend the
    /// steps are made at once, and the result is written to the buffers by the queue. Needs a device.
    ///
    /// [`Error::DeviceLost`] if the device is lost: nothing is recorded and no time passes until [`Stepper::recover`] gives the
    /// stepper another one. [`Error::OutOfMemory`] if a buffer that this frame is the first to need could not be made: drop the
    /// encoder, and recover with the same device.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, dt: f64) -> Result<Progress> {
        self.guarded(|stepper| stepper.record_frame(encoder, dt))
    }

    fn record_frame(&mut self, encoder: &mut wgpu::CommandEncoder, dt: f64) -> Result<Progress> {
        let gpu = self.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record"))?;
        if let Some((bodies, _)) = &self.cpu {
            self.world.measure_sleepers(bodies);
        }
        let changed = self.world.drive(dt);
        let progress = self.world.begin(dt);
        if self.world.repose(changed) {
            gpu.set_colliders(&self.world, true);
        }
        if progress.steps == 0 && !self.world.host.is_pending() {
            return Ok(progress);
        }
        match &mut self.cpu {
            Some((bodies, threads)) => {
                self.world.act(bodies, threads);
                self.world.run(bodies, threads, progress.steps);
                gpu.upload(bodies, threads, &self.world.runs);
                for (cloth, body) in bodies.iter().enumerate() {
                    gpu.upload_indices(&self.world, cloth, body);
                    gpu.upload_render_indices(cloth, body);
                }
            }
            None => {
                gpu.begin(&self.world, progress.steps);
                gpu.act(&mut self.world, encoder);
                gpu.record(&mut self.world, encoder, progress.steps);
                gpu.flush();
            }
        }
        Ok(progress)
    }

    /// The buffers that a vertex shader reads. They stay where they are until the cloth is removed; its holes come with the first
    /// cut. `None` without a device and for a cloth that does not exist.
    pub fn buffers(&self, cloth: impl Into<ClothRef>) -> Option<&ClothBuffers> {
        self.gpu.as_ref()?.buffers(self.world.find(cloth.into()).ok()?)
    }

    /// Writes of this stepper by the host's queue so far. On the GPU backend a frame makes one write at most: numbers
    /// of steps, colliders, pins and lists of actions of up to 64 KiB go together, and none is made where nothing has
    /// changed. On the CPU backend a frame makes three writes per cloth that is awake. `None` without a device.
    pub fn uploads(&self) -> Option<UploadCount> {
        self.gpu.as_ref().map(Gpu::uploads)
    }

    /// The pipelines that this stepper has compiled, and how long that took. [`Stepper::new`] compiles all that a frame
    /// runs; actions and changed settings may add to them. `None` without a device.
    pub fn compiled(&self) -> Option<Compiled> {
        self.gpu.as_ref().map(Gpu::compiled)
    }
}
