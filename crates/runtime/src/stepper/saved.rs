//! States in buffers of the GPU: saved and loaded in the order of an encoder, without waiting.

use bytemuck::pod_collect_to_vec;
use wgpu::{BufferUsages, CommandEncoder};

use super::Stepper;
use crate::error::{Error, Result, StateProblem};
use crate::gpu::{Span, block_on, bytes};
use crate::handle::ClothRef;
use crate::state::{ClothState, Head, Layout};

/// The state of a cloth in a buffer of the host, as [`Stepper::record_state`] has recorded it.
#[derive(Clone, Debug)]
pub struct SavedState {
    head: Head,
    pinned: Vec<u32>,
    place: Span,
}

impl SavedState {
    /// The part of the buffer that holds it, [`Stepper::state_bytes`] long at that time.
    pub fn span(&self) -> &Span {
        &self.place
    }

    /// The same state in the host's memory. `bytes` are the bytes of the span, for example mapped once the submission is
    /// done: the call itself does not wait. Errors if there are fewer or more.
    pub fn read(&self, bytes: &[u8]) -> Result<ClothState> {
        if bytes.len() as u64 != self.place.size {
            return Err(Error::StateBytes { what: "state", problem: "they are not as many as the span has" });
        }
        Ok(ClothState::new(self.head.clone(), pod_collect_to_vec(bytes)))
    }
}

impl Stepper {
    /// Bytes that the state of a cloth takes in a buffer now: 48 per particle, 64 of a material. After the first cut 20 more,
    /// and 8 per tether.
    pub fn state_bytes(&self, cloth: impl Into<ClothRef>) -> Result<u64> {
        let cloth = self.world.find(cloth.into())?;
        Ok(4 * self.world.head(cloth).layout.words() as u64)
    }

    /// Records copies of the state of a cloth into a buffer of the host, from `offset` \[bytes\] on: up to seven copies on the
    /// device, and no wait. Pins, cuts and transforms that wait for the next frame are recorded first. GPU backend only.
    ///
    /// The buffer has [`Stepper::state_bytes`] bytes from there on, and the usage `COPY_DST`; `COPY_SRC` too if the state is to
    /// be loaded from it ([`Stepper::record_set_state`]), or `MAP_READ` if it is to be read ([`SavedState::read`]). A ring of
    /// buffers makes a rollback of a few frames. Errors if there is no such cloth, on the CPU backend, on an offset that is not a
    /// multiple of 4, and if the buffer is too small or lacks a usage; then nothing is recorded.
    pub fn record_state(
        &mut self,
        encoder: &mut CommandEncoder,
        cloth: impl Into<ClothRef>,
        buffer: &wgpu::Buffer,
        offset: u64,
    ) -> Result<SavedState> {
        let cloth = self.world.find(cloth.into())?;
        let bytes = self.state_bytes(cloth)?;
        let place = Span { buffer: buffer.clone(), offset, size: bytes };
        self.refuse_cpu("Stepper::record_state", "Stepper::state")?;
        self.fits(cloth, &place, (BufferUsages::COPY_DST, "COPY_DST"), "its state")?;
        self.guarded(|stepper| {
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_state"))?;
            gpu.act_now(&mut stepper.world, encoder);
            Ok(())
        })?;
        let gpu = self.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_state"))?;
        let head = self.world.head(cloth);
        gpu.save(encoder, cloth, &head.layout, (buffer, offset));
        let particles = self.world.scene.cloths[cloth].particles();
        let pinned = (0..particles.len() as u32).filter(|k| particles[*k as usize].is_pinned()).collect();
        Ok(SavedState { head, pinned, place })
    }

    /// Records that a cloth is put into a state from a buffer, as [`Stepper::set_state`] does it from the host's memory: up to seven
    /// copies on the device. It takes effect in the order of the encoder, for frames that are recorded from here on.
    ///
    /// Errors as [`Stepper::record_state`] (the usage is `COPY_SRC`), if the state does not fit the cloth, and if steps have
    /// another length than when it was saved, as nothing scales velocities here ([`StateProblem::Step`]).
    pub fn record_set_state(
        &mut self,
        encoder: &mut CommandEncoder,
        cloth: impl Into<ClothRef>,
        saved: &SavedState,
    ) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        saved.head.check(of, &self.world.runs[cloth].tethers)?;
        let refuse = |problem| Err(Error::State { cloth: of.name().into(), problem });
        let Layout { good, lost, .. } =
            Layout::of(of, &self.world.runs[cloth].tethers, self.world.control.options.solver);
        if (good, lost) != (saved.head.layout.good, saved.head.layout.lost) {
            return refuse(StateProblem::Solver);
        }
        let (found, expected) = (saved.head.step, self.world.control.clock.dt_old);
        if found != expected {
            return refuse(StateProblem::Step { found, expected });
        }
        self.refuse_cpu("Stepper::record_set_state", "Stepper::set_state")?;
        self.fits(cloth, &saved.place, (BufferUsages::COPY_SRC, "COPY_SRC"), "its state")?;
        self.guarded(|stepper| {
            stepper.make_ready(&[(cloth, &saved.head, saved.pinned.clone())]);
            let gpu = stepper.gpu.as_mut().ok_or(Error::NoGpu("Stepper::record_set_state"))?;
            let place = (&saved.place.buffer, saved.place.offset);
            gpu.load(&stepper.world, encoder, cloth, &saved.head.layout, place);
            Ok(())
        })
    }

    /// The states of some cloths, by one copy and one wait.
    pub(super) fn read_states(&mut self, cloths: &[usize]) -> Result<Vec<ClothState>> {
        let gpu = self.gpu.as_mut().ok_or(Error::NoGpu("Stepper::state"))?;
        let (device, queue) = (gpu.handles().0.clone(), gpu.handles().1.clone());
        let mut encoder = device.create_command_encoder(&Default::default());
        gpu.act_now(&mut self.world, &mut encoder);
        let heads: Vec<Head> = cloths.iter().map(|cloth| self.world.head(*cloth)).collect();
        let size = |head: &Head| 4 * head.layout.words() as u64;
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("states"),
            size: heads.iter().map(size).sum::<u64>().max(4),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut offset = 0;
        for (cloth, head) in cloths.iter().zip(&heads) {
            gpu.save(&mut encoder, *cloth, &head.layout, (&staging, offset));
            offset += size(head);
        }
        queue.submit([encoder.finish()]);
        let words: Vec<u32> = block_on(&device, bytes(&device, &staging, pod_collect_to_vec))?;
        let mut rest = &words[..];
        let mut states = Vec::new();
        for head in heads {
            let (own, more) = rest.split_at(head.layout.words());
            rest = more;
            states.push(ClothState::new(head, own.to_vec()));
        }
        Ok(states)
    }
}
