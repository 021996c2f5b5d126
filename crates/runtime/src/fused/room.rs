//! The capacity of a device, as far as the forms of passes depend on it.

#[cfg(feature = "gpu")]
use crate::cloth::Cloth;
use crate::form::Hold;
#[cfg(feature = "gpu")]
use crate::tuning::MIN_THREADS as LEAST;
use crate::tuning::Tuning;

/// Capacity of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Bytes of a workgroup's memory.
    pub(crate) memory: u32,
    /// Threads of a workgroup.
    pub(crate) threads: u32,
    /// Storage buffers that a shader may bind.
    pub(crate) buffers: u32,
    /// Iterations that all loops of a thread may make in a dispatch.
    pub(crate) loops: u32,
    /// Workgroups that keep it busy.
    pub(crate) busy: u32,
    /// Bytes of one of them.
    pub(crate) bytes: u64,
    /// Most particles of a cloth among few that runs its whole frame in one workgroup.
    pub(crate) whole: u32,
    /// Cloths that the scene starts with.
    pub(crate) cloths: usize,
    /// Sizes that the host has measured.
    pub(crate) tuning: Tuning,
}

/// [`Room::whole`] of a GPU. A workgroup takes .070, .104 and .154 ms for 8 steps of 32, 48 and 64 particles per side on an H200, tiles of any of them about
/// .09 ms.
#[cfg(feature = "gpu")]
const WHOLE: u32 = 2048;
/// Cloths that are few: whole frames of more keep the cores of a small GPU busy.
const FEW: usize = 4;
/// Particles of a thread in whole frames: with 2 a thread has one spring of each colour. Cloths of 32 x 32 particles take .8 to .9 of the time that they take with 4, and
/// 1,000 of them, which keep an H200 busy, 1.1 of it.
const PER_THREAD: u32 = 2;
const PER_BUSY_THREAD: u32 = 4;

/// Bytes of a workgroup's memory that shaders/part/notes.wgsl takes.
pub(crate) const NOTES: u32 = 152;

impl Room {
    /// That of a device.
    #[cfg(feature = "gpu")]
    pub fn of(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        let most = limits.max_compute_invocations_per_workgroup.min(limits.max_compute_workgroup_size_x);
        // A core that plays a workgroup pays for each of its threads at every barrier, and gains by none.
        let software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        Room {
            memory: limits.max_compute_workgroup_storage_size,
            threads: if software { LEAST } else { most.max(LEAST) },
            // llvmpipe ends all loops of a thread after 65,535 in total, without an error. Compilers make loops of what is none in a
            // shader, and count the end of one, so a quarter of them is used.
            loops: if software { 65_535 / 4 } else { u32::MAX },
            buffers: limits.max_storage_buffers_per_shader_stage,
            busy: if software { 8 } else { 256 },
            bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            // Each core plays whole workgroups, and tiles are more work.
            whole: if software { u32::MAX } else { WHOLE },
            cloths: 1,
            tuning: Tuning::NONE,
        }
    }

    /// The same with sizes that the host gives.
    #[cfg(feature = "gpu")]
    pub fn tuned(self, tuning: Option<Tuning>) -> Self {
        Room { tuning: tuning.unwrap_or_default(), ..self }
    }

    /// That of a scene that starts with this number of cloths. Cloths that come or go later do not change the forms of others.
    pub(crate) fn among(self, cloths: usize) -> Self {
        Room { cloths, ..self }
    }

    /// Most particles of a cloth that runs its whole frame in one workgroup, if it fits there.
    pub(crate) fn most_whole(&self) -> usize {
        let few = || self.tuning.whole_particles.unwrap_or(self.whole) as usize;
        if self.cloths > FEW { usize::MAX } else { few() }
    }

    /// Particles of a thread in whole frames.
    pub(super) fn per_thread(&self) -> u32 {
        if self.cloths > self.busy as usize { PER_BUSY_THREAD } else { PER_THREAD }
    }

    /// Whether the positions of a cloth fit the memory of a workgroup.
    #[cfg(feature = "gpu")]
    pub(crate) fn holds(&self, cloth: &Cloth) -> bool {
        self.hold(cloth.len(), 0).is_some()
    }

    /// Where a cloth is held if `beside` bytes of the memory serve other purposes; `None` where it does not fit.
    pub(super) fn hold(&self, particles: usize, beside: u32) -> Option<Hold> {
        match self.memory.saturating_sub(beside) as usize / particles.next_multiple_of(64) {
            28.. => Some(Hold::Both),
            16.. => Some(Hold::Wide),
            12.. => Some(Hold::Narrow),
            _ => None,
        }
    }
}
