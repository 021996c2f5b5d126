//! Devices that are lost, and what goes on after them.

use super::Stepper;
use super::self_check::consider;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::fused::Room;
use crate::gpu::{Gpu, Pipelines, guard};
use crate::state::{ClothState, Head};

impl Stepper {
    /// Goes on with another device, after [`Error::DeviceLost`], or with the same one after [`Error::OutOfMemory`]. Handles,
    /// colliders, wind and settings stay.
    ///
    /// Each cloth continues from the last state that the stepper has seen in the host's memory: by [`Stepper::state`], [`Stepper::snapshot`],
    /// [`Stepper::set_state`] or [`Stepper::restore`]; clock and numbers of substeps from the last snapshot. The continuation has the same bits
    /// as after [`Stepper::set_state`] or [`Stepper::restore`] with them, on a device with the same results. A cloth without such a state
    /// begins again where it began, uncut, with the pins that it has now. A state of another level ([`Stepper::set_levels`]) is carried to
    /// the present one. A state that was read otherwise, such as by
    /// [`crate::SavedState::read`], is set after the call. Pins, cuts and transforms that wait for the next frame are dropped. On the CPU backend
    /// nothing is lost: only the buffers for drawing are made again.
    ///
    /// Costs what [`Stepper::new`] costs for the same scene: it compiles pipelines and, on an adapter that was not checked yet, runs the
    /// [`crate::self_check`], with the same consequences. Buffers of the old device ([`Stepper::buffers`], [`crate::SavedState`]), picks and
    /// renderers ([`crate::draw::Draw`]) cannot be used any more. Index buffers and tangents are made by the next call
    /// that asks for them, and [`Stepper::bounds`] is `None` until a box has arrived. Errors without a device, and if the new device is lost or has no memory left: then
    /// call it again with another one.
    pub fn recover(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<()> {
        if self.gpu.is_none() {
            return Err(Error::NoGpu("Stepper::recover"));
        }
        let handles = (device, queue);
        if self.cpu.is_some() {
            return self.draw_with(handles);
        }
        let (on_cpu, warning) = consider(self.options().backend, handles, None)?;
        let cpu = if on_cpu { Some(Threads::new(self.options().threads)?) } else { None };
        let (tuning, cloths) = (self.options().tuning, self.world.scene.cloths.len());
        self.world.start_again((!on_cpu).then(|| Room::of(device).tuned(tuning).among(cloths)));
        self.gpu = Some(guard(device, || Gpu::new(&self.world, handles, Pipelines::new(device, None), on_cpu))?);
        self.cpu = cpu.map(|threads| (self.world.bodies(), threads));
        self.world.host.adapter = warning;
        guard(device, || {
            self.continue_from_kept();
            Ok(())
        })?;
        if on_cpu { self.draw_with(handles) } else { Ok(()) }
    }

    /// Makes the buffers for drawing what the CPU steps.
    fn draw_with(&mut self, handles: (&wgpu::Device, &wgpu::Queue)) -> Result<()> {
        let Some((bodies, threads)) = &self.cpu else { return Ok(()) };
        let world = &self.world;
        let made = guard(handles.0, || {
            let mut gpu = Gpu::new(world, handles, Pipelines::new(handles.0, None), true)?;
            for (cloth, body) in bodies.iter().enumerate() {
                gpu.renew(world, cloth);
                gpu.upload_one(cloth, body, threads);
            }
            Ok(gpu)
        });
        self.gpu = Some(made?);
        Ok(())
    }

    /// Puts cloths into their last states on the host.
    fn continue_from_kept(&mut self) {
        let all = 0..self.world.runs.len();
        let kept: Vec<(usize, ClothState)> = all.filter_map(|c| Some((c, self.world.kept_state(c)?))).collect();
        let heads: Vec<(usize, &Head, Vec<u32>)> = kept.iter().map(|(c, s)| (*c, &s.head, s.pinned())).collect();
        self.make_ready(&heads);
        if let Some(control) = self.world.kept {
            self.world.resume_control(&control);
        }
        for (cloth, state) in &kept {
            self.put(*cloth, state);
        }
    }

    /// Runs a call that uses the device, where there is one. Errors of the device are its result.
    pub(super) fn guarded<T>(&mut self, run: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let Some(gpu) = &mut self.gpu else { return run(self) };
        gpu.check()?;
        let device = gpu.handles().0.clone();
        let result = guard(&device, || run(self));
        if let Some(gpu) = &mut self.gpu {
            match &result {
                Ok(_) => gpu.succeeded(),
                Err(error) => gpu.fail(error),
            }
        }
        result
    }
}
