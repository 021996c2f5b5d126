//! Steps a scene, frame by frame.

mod actions;
mod bounds;
mod colliders;
#[cfg(feature = "gpu")]
mod device;
mod drag;
#[cfg(feature = "gpu")]
mod host_buffer;
mod indices;
mod joints;
mod levels;
mod members;
mod moving_frame;
mod pick;
mod pins;
#[cfg(feature = "gpu")]
mod prepare;
#[cfg(feature = "gpu")]
mod record_pins;
#[cfg(feature = "gpu")]
mod recover;
#[cfg(feature = "gpu")]
mod saved;
mod script;
#[cfg(feature = "gpu")]
mod self_check;
mod settings;
mod state;
mod take_apart;
mod tangents;
#[cfg(feature = "gpu")]
mod times;
#[cfg(feature = "gpu")]
mod tune;
mod wrap;

pub use drag::Drag;
pub use levels::level_at;
#[cfg(feature = "gpu")]
pub use saved::SavedState;
#[cfg(all(feature = "gpu", not(target_family = "wasm")))]
pub use self_check::self_check;
#[cfg(feature = "gpu")]
pub use self_check::{Mismatch, SelfCheck, self_check_async};
pub use take_apart::TakenApart;

use crate::choose::Choice;
use crate::clock::Progress;
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::findings::{Finding, Watchdog};
use crate::gpu::Gpu;
use crate::handle::ClothRef;
use crate::health::Health;
use crate::memory::{Memory, Tally};
use crate::options::{Backend, Options, Solver};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::wind::Wind;
use crate::world::World;

/// A scene in motion. It keeps handles to the host's device and queue, and never submits, waits or reads back after
/// [`Stepper::new`].
pub struct Stepper {
    world: World,
    cpu: Option<(Vec<Body<f32>>, Threads)>,
    gpu: Option<Gpu>,
}

impl Stepper {
    /// Makes a stepper for a scene on the CPU backend, without buffers: [`Stepper::advance`] steps it. Errors
    /// on settings out of range and on [`Backend::Gpu`].
    pub fn on_cpu(scene: Scene, options: Options) -> Result<Self> {
        if options.backend == Backend::Gpu {
            return Err(Error::NoGpu("Backend::Gpu"));
        }
        let classic = options.solver == Solver::Classic;
        let world = if classic { World::without_bodies(scene, options)? } else { World::new(scene, options)? };
        let threads = Threads::new(world.control.options.threads)?;
        Ok(Stepper { cpu: Some((world.bodies(), threads)), gpu: None, world })
    }

    /// The backend that runs: `Gpu` or `Cpu`.
    pub fn backend(&self) -> Backend {
        if self.cpu.is_some() { Backend::Cpu } else { Backend::Gpu }
    }

    /// Makes the steps that are due after `dt` \[s\] of the host's time, without a device. CPU backend only.
    pub fn advance(&mut self, dt: f64) -> Result<Progress> {
        let (bodies, threads) = self.cpu.as_mut().ok_or(Error::GpuOnly("Stepper::advance"))?;
        self.world.measure_sleepers(bodies);
        let changed = self.world.drive(dt);
        let progress = self.world.begin(dt);
        if self.world.repose(changed)
            && let Some(gpu) = &mut self.gpu
        {
            gpu.set_colliders(&self.world, true);
        }
        if self.world.act(bodies, threads) || progress.steps > 0 {
            self.world.run(bodies, threads, progress.steps);
        }
        Ok(progress)
    }

    /// The passes and bindings of a frame of [`Options::step`].
    pub fn plan(&self) -> Plan {
        Plan::new(&self.world)
    }

    /// Bytes of the cloths and of their states, without pyramids and passing buffers. Takes time linear in the number of cloths.
    pub fn memory(&self) -> Memory {
        let mut tally = Tally::default();
        for (cloth, run) in self.world.scene.cloths.iter().zip(&self.world.runs) {
            cloth.tally(&mut tally);
            tally.image(&run.tethers.anchors);
        }
        self.cpu.iter().flat_map(|(bodies, _)| bodies).for_each(|body| body.tally(&mut tally));
        self.world.safe.iter().for_each(|safe| safe.tally(&mut tally));
        self.world.tangles.tally(&mut tally);
        tally.with_device(self.gpu.as_ref().map_or([0; 2], Gpu::bytes))
    }

    /// The scene, with colliders, wind and pins as they are now and cloths as they were at the start.
    pub fn scene(&self) -> &Scene {
        &self.world.scene
    }

    /// The settings as the host gave them; [`Stepper::choice`] has what was chosen for those left open.
    pub fn options(&self) -> &Options {
        self.world.control.options.given()
    }

    /// Steps per [`Options::step`] as of the last frame.
    pub fn substeps(&self) -> u32 {
        self.world.control.options.substeps
    }

    /// Rounds of polish as of the last frame.
    pub fn polish(&self) -> u32 {
        self.world.control.options.polish
    }

    /// The numbers of substeps and of polishing rounds at the start, and the reason.
    pub fn choice(&self) -> &Choice {
        &self.world.control.choice
    }

    /// Positions \[m\] of a cloth, the fourth component 1/mass (0 pinned, -1 no particle). `None` on the GPU backend,
    /// where they stay in [`Stepper::buffers`], and for a cloth that does not exist.
    pub fn positions(&self, cloth: impl Into<ClothRef>) -> Option<&[[f32; 4]]> {
        Some(self.body(cloth.into())?.now())
    }

    /// Positions one step before, as [`Stepper::positions`].
    pub fn previous(&self, cloth: impl Into<ClothRef>) -> Option<&[[f32; 4]]> {
        Some(self.body(cloth.into())?.before())
    }

    /// Unit normals of a cloth; 0 where there is none. Made from its positions when they are first read after a frame, 4 ns per
    /// particle.
    pub fn normals(&self, cloth: impl Into<ClothRef>) -> Option<&[[f32; 4]]> {
        let (_, threads) = self.cpu.as_ref()?;
        Some(self.body(cloth.into())?.normals(threads))
    }

    /// Triangles of a cloth that a cut has taken away, as [`crate::ClothBuffers::holes`]. `None` on the GPU backend, until the
    /// first cut, and for a cloth that does not exist.
    pub fn holes(&self, cloth: impl Into<ClothRef>) -> Option<&[u32]> {
        let holes = &self.body(cloth.into())?.holes;
        (!holes.is_empty()).then_some(holes)
    }

    fn body(&self, cloth: ClothRef) -> Option<&Body<f32>> {
        self.cpu.as_ref()?.0.get(self.world.find(cloth).ok()?)
    }

    /// The frames that were taken back since the last call, oldest first, at most the latest 64: a cloth with particles
    /// that are NaN or farther than 1e8 m away is reset to its last good frame, at rest. With
    /// [`crate::Solver::Xpbd`] only. Empty on the GPU backend, where they are counted in [`crate::ClothBuffers::faults`].
    pub fn take_faults(&mut self) -> Vec<crate::world::Fault> {
        std::mem::take(&mut self.world.host.faults)
    }

    /// Failures so far, one finding of each kind per cloth: cloth out of shape, off its body, falling, or through a
    /// collider. The CPU backend looks by itself; on the GPU backend the host reads positions back, say once per second, and
    /// hands them to [`Stepper::examine`], which finds all but tunnelling and, where cloth or colliders were put elsewhere after the
    /// start, cloth inside colliders.
    pub fn findings(&self) -> &[Finding] {
        &self.world.watchdog.findings
    }

    /// Takes the figures of a cloth from its positions now and one step before, as a host has read them back, and returns
    /// them. The depth of cloth that is worn on the surface of a body includes the depth inside the body. 20 ns per particle; some microseconds per
    /// particle for such cloth. Errors if there is no such cloth, and if a list has another length.
    pub fn examine(&mut self, cloth: impl Into<ClothRef>, now: &[[f32; 4]], before: &[[f32; 4]]) -> Result<Health> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        for list in [now, before] {
            if list.len() != of.len() {
                let (cloth, found, expected) = (of.name().into(), list.len(), of.len());
                return Err(Error::Length { cloth, what: "positions", found, expected });
            }
        }
        let mut watchdog = std::mem::replace(&mut self.world.watchdog, Watchdog::new(0));
        let solids = self.world.solids();
        watchdog.examine(&self.world.sight(cloth, (now, before), &solids[self.world.runs[cloth].coat], 0.0));
        self.world.watchdog = watchdog;
        if self.cpu.is_none() {
            self.world.look_at_crossings(cloth, now);
        }
        let health = self.health(cloth).map_or_else(Health::default, |h| h.0);
        let matrices = self.world.runs[cloth].joints.as_ref().map_or(&[][..], |joints| joints.now());
        let inside = self.world.scene.cloths[cloth].depth_in_body(now, matrices);
        Ok(Health { depth: health.depth.max(inside), ..health })
    }

    /// The last figures of a cloth, and the largest 99th percentile of its extension so far. On the CPU backend taken 0.2 s
    /// after its start and then twice per second, on either by [`Stepper::examine`].
    pub fn health(&self, cloth: impl Into<ClothRef>) -> Option<(Health, f64)> {
        self.world.watchdog.of(self.world.find(cloth.into()).ok()?)
    }

    /// Warnings about settings beyond the solver's limits: masses, tethers and cloth that will not rest, as found when the
    /// cloth came, and the current number of substeps. [`crate::Solver::Classic`] has none of these. A failed [`crate::self_check`] of
    /// the device comes first.
    pub fn warnings(&self) -> Vec<crate::limits::Warning> {
        let World { host, runs, .. } = &self.world;
        let cloths = runs.iter().flat_map(|run| &run.warnings);
        let contact = self.world.contact_warnings();
        host.adapter.iter().chain(&host.start).chain(cloths).chain(&host.raised).cloned().chain(contact).collect()
    }

    /// Changes the wind, or ends it. Wakes every cloth.
    pub fn set_wind(&mut self, wind: Option<Wind>) -> Result<()> {
        wind.iter().try_for_each(Wind::check)?;
        self.world.scene.wind = wind;
        self.changed();
        Ok(())
    }

    /// Changes gravity \[m/s^2\]. Wakes every cloth.
    pub fn set_gravity(&mut self, gravity: [f32; 3]) -> Result<()> {
        let before = std::mem::replace(&mut self.world.scene.gravity, gravity);
        if let Err(error) = self.world.scene.check() {
            self.world.scene.gravity = before;
            return Err(error);
        }
        self.changed();
        Ok(())
    }

    /// Reports the time of a frame \[ms\], for [`crate::Quality::Budget`]: `steps` as in [`Progress::steps`]. It may come late. Frames
    /// without a step and times not above 0 do not count. The median of the last 15 times per step is used, from the fifth time
    /// on. A GPU with timestamp queries times its frames by itself ([`Stepper::settle`]): from the first of these times on, those
    /// of the host do not count.
    pub fn took(&mut self, steps: u32, ms: f64) {
        if !self.gpu.as_ref().is_some_and(Gpu::times_frames) {
            self.world.control.chooser.took(steps, ms);
        }
    }

    /// The largest stretch in the last measured frame, for [`crate::Quality::Error`]; `None` before the first measurement.
    pub fn estimated_error(&self) -> Option<f64> {
        self.world.control.chooser.error
    }

    /// Lets a cloth sleep where it is, at no per-frame cost, or wakes it. Any change of the cloth wakes it too, and so does a collider
    /// that may touch it on its path. On the GPU backend any collider that changes does until the box around the cloth has arrived, one to
    /// three frames later, by [`Stepper::settle`].
    pub fn set_asleep(&mut self, cloth: impl Into<ClothRef>, asleep: bool) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        if !(asleep && self.world.runs[cloth].asleep) {
            self.world.wake(cloth);
            self.world.runs[cloth].asleep = asleep;
            if let Some((bodies, _)) = &self.cpu {
                self.world.measure_sleepers(bodies);
            }
        }
        Ok(())
    }

    /// Whether a cloth is asleep; not where there is none.
    pub fn is_asleep(&self, cloth: impl Into<ClothRef>) -> bool {
        self.world.find(cloth.into()).is_ok_and(|cloth| self.world.runs[cloth].asleep)
    }

    /// Lets cloths fall asleep on the GPU backend if [`crate::Options::sleep`] is set, and substeps be chosen by
    /// [`crate::Quality::Error`]: call it once a frame, after everything that was recorded has been submitted. It reads the
    /// measurements that have arrived, eight bytes per cloth some frames late, and never waits. Boxes (`record_bounds`) and
    /// pass times arrive by the same call. Without it no cloth falls asleep and no error is known there. The CPU backend
    /// needs no call.
    pub fn settle(&mut self) -> Result<()> {
        self.guarded(|stepper| stepper.gpu.as_mut().map_or(Ok(()), |gpu| gpu.settle(&mut stepper.world)))
    }

    /// Without a device no call fails on one.
    #[cfg(not(feature = "gpu"))]
    fn guarded<T>(&mut self, run: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        run(self)
    }

    fn changed(&mut self) {
        self.world.wake_all();
        self.world.reschedule();
    }
}
