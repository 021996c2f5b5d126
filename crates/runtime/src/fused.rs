//! Which cloths run their whole frame in one dispatch, a workgroup a cloth, and which of them share it.
//!
//! A cloth whose positions fit the memory of a workgroup needs no dispatch a colour: barriers part the colours, and
//! between the first step and the last nothing but its previous positions leaves the workgroup. Cloths whose frames need
//! the same code are steps of one dispatch, however many and however different in size and material they are.

mod batches;

pub use batches::arenas;
#[cfg(feature = "gpu")]
pub use batches::{Batch, room_of};

use crate::cloth::Cloth;
use crate::passes::{Air, Kinds, Pass, Schedule, Soft};
use crate::shaders::{Slot, source};

/// A whole frame of XPBD in one dispatch, described by the variants compiled into its shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fused {
    /// Not [`Air::Field`].
    pub air: Air,
    /// Whether integration keeps what rounding takes.
    pub exact: bool,
    /// Whether cloth is stiff against bending.
    pub bends: bool,
    /// Whether a membrane carries tension, in place of springs.
    pub membrane: bool,
    /// Which spring directions there are.
    pub directions: [bool; 4],
    /// Whether rest lengths come from an image.
    pub image: bool,
    /// Where compliance comes from.
    pub soft: Soft,
    /// Whether multipliers are summed over several relaxations.
    pub again: bool,
    /// Anchors per particle.
    pub slots: u32,
    /// Further rounds of a relaxation.
    pub polish: u32,
    /// Whether there are seams.
    pub seams: bool,
    /// Which colliders there are.
    pub contact: Option<Kinds>,
    /// Whether positions leave no room in the memory of a workgroup for a list of the colliders that are near.
    pub full: bool,
    /// Whether normals are made.
    pub normals: bool,
    /// Whether the largest stretch is measured.
    pub strain: bool,
    /// Whether speeds are measured.
    pub watch: bool,
    /// Where positions are during the frame.
    pub hold: Hold,
    /// Particles that the memory of a workgroup has room for.
    pub places: u32,
    /// Threads of a workgroup.
    pub threads: u32,
}

/// Where a workgroup stores the positions of its cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hold {
    /// In its memory, with inverse masses and previous positions: 28 bytes per particle.
    Both,
    /// In its memory, with inverse masses: 16 bytes per particle.
    Wide,
    /// In its memory, alone: 12 bytes per particle.
    Narrow,
    /// In storage. For cloths that are too large, where there are many of them.
    Stored,
}

/// What a device has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Bytes of a workgroup's memory.
    pub(crate) memory: u32,
    /// Threads of a workgroup.
    pub(crate) threads: u32,
    /// Storage buffers that a shader may bind.
    pub(crate) buffers: u32,
    /// Workgroups that keep it busy.
    pub(crate) busy: u32,
    /// Bytes of one of them.
    pub(crate) bytes: u64,
}

/// Bytes of a workgroup's memory that shaders/part/notes.wgsl takes.
pub(crate) const NOTES: u32 = 152;
/// Threads of a workgroup, at least.
const LEAST: u32 = 64;

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
            buffers: limits.max_storage_buffers_per_shader_stage,
            busy: if software { 8 } else { 256 },
            bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
        }
    }

    /// Where a cloth is held if `beside` bytes of the memory serve other purposes.
    fn hold(&self, particles: usize, beside: u32) -> Hold {
        match self.memory.saturating_sub(beside) as usize / particles.next_multiple_of(64) {
            28.. => Hold::Both,
            16.. => Hold::Wide,
            12.. => Hold::Narrow,
            _ => Hold::Stored,
        }
    }
}

impl Fused {
    /// The frame that a schedule asks for, if a fused one is the same: the same passes in the same order.
    fn of(cloth: &Cloth, schedule: &Schedule, room: &Room) -> Option<Self> {
        let mut fused = Fused {
            air: Air::None,
            exact: false,
            bends: false,
            membrane: false,
            directions: [false; 4],
            image: false,
            soft: Soft::None,
            again: false,
            slots: 0,
            polish: 0,
            seams: false,
            contact: None,
            full: false,
            normals: false,
            strain: false,
            watch: false,
            hold: room.hold(cloth.len(), 0),
            places: (cloth.len() as u32).next_multiple_of(64),
            threads: (cloth.len() as u32 / 4).next_power_of_two().clamp(LEAST, room.threads),
        };
        for pass in schedule.step.iter().chain(&schedule.relax).chain(&schedule.frame) {
            match *pass {
                Pass::Integrate(air) => fused.air = air,
                Pass::Advance(air) => (fused.air, fused.exact) = (air, true),
                Pass::Bend => fused.bends = true,
                Pass::Membrane { .. } => fused.membrane = true,
                Pass::Stretch { direction, image, soft, again, .. } => {
                    fused.directions[direction as usize & 3] = true;
                    (fused.image, fused.soft, fused.again) = (image, soft, again);
                }
                Pass::Tethers { slots } => fused.slots = slots,
                Pass::Seams => fused.seams = true,
                Pass::Contact(kinds) => fused.contact = Some(kinds),
                Pass::Normals { .. } => fused.normals = true,
                Pass::Strain { image, soft } => (fused.strain, fused.image, fused.soft) = (true, image, soft),
                Pass::Speed => fused.watch = true,
                // Implied by the others, or beyond the shader, whose schedule then differs.
                Pass::Wind { .. }
                | Pass::Moments { .. }
                | Pass::SeamMoments
                | Pass::Springs { .. }
                | Pass::Forget
                | Pass::Pyramid { .. }
                | Pass::Refine { .. }
                | Pass::SeamSteps
                | Pass::Colliders(_)
                | Pass::Guard
                | Pass::Restore
                | Pass::SeamNormals
                | Pass::Fastest
                | Pass::Tile(_)
                | Pass::Fused(_)
                | Pass::Cut
                | Pass::CutSprings
                | Pass::CutTethers { .. }
                | Pass::CutLevels
                | Pass::Transform
                | Pass::Pick { .. }
                | Pass::PickNearest => {}
            }
        }
        fused.polish = fused.rounds(schedule).saturating_sub(1);
        fused.full = fused.contact.is_some_and(|k| k.many) && room.hold(cloth.len(), NOTES) != fused.hold;
        let bound = source(Pass::Fused(fused)).bindings.iter().filter(|b| b.slot != Slot::Frame).count();
        let same = fused.air != Air::Field && fused.schedule(schedule) == *schedule;
        (same && bound <= room.buffers as usize).then_some(fused)
    }

    /// The passes that the shader makes, in its order. Colours without room for a spring make no difference.
    fn schedule(&self, like: &Schedule) -> Schedule {
        let Fused { image, soft, again, slots, .. } = *self;
        let colours = like.relax.iter().filter(|p| matches!(p, Pass::Stretch { .. }));
        let colours: Vec<_> = colours
            .map(|p| if let Pass::Stretch { direction, parity, .. } = *p { (direction, parity) } else { (0, 0) })
            .collect();
        let order = [2, 3, 0, 1].into_iter().flat_map(|d| [(d, 0), (d, 1)]);
        let colours = order.filter(|c| colours.contains(c));
        let tethers = (slots > 0).then_some(Pass::Tethers { slots });
        let mut s = Schedule::default();
        s.step.push(if self.exact { Pass::Advance(self.air) } else { Pass::Integrate(self.air) });
        if self.bends {
            s.step.push(Pass::Moments { holes: false });
            s.step.extend(self.seams.then_some(Pass::SeamMoments));
            s.step.push(Pass::Bend);
            s.step.extend(self.seams.then_some(Pass::Seams));
        }
        // Nor do those without room for a cell.
        let cells = |(column, row)| Pass::Membrane { column, row, holes: false };
        let cells = [(0, 0), (1, 0), (0, 1), (1, 1)].map(cells);
        s.step.extend(cells.into_iter().filter(|c| like.step.contains(c)));
        s.step.extend(again.then_some(Pass::Forget));
        s.relax.extend(tethers);
        let springs: Vec<_> =
            colours.map(|(direction, parity)| Pass::Stretch { direction, parity, image, soft, again }).collect();
        s.relax.extend(&springs);
        for _ in 0..self.polish {
            s.relax.extend(self.seams.then_some(Pass::Seams));
            s.relax.extend(tethers);
            s.relax.extend(springs.iter().filter(|p| p.is_structural()));
        }
        s.relax.extend(self.seams.then_some(Pass::Seams));
        s.relax.extend(tethers.filter(|_| self.polish == 0));
        s.relax.extend(self.contact.map(Pass::Contact));
        s.frame.extend([Pass::Guard, Pass::Restore]);
        s.frame.extend(self.strain.then_some(Pass::Strain { image, soft }));
        s.frame.extend(self.normals.then_some(Pass::Normals { holes: false }));
        s.frame.extend((self.normals && self.seams).then_some(Pass::SeamNormals));
        s.frame.extend(self.watch.then_some([Pass::Speed, Pass::Fastest]).into_iter().flatten());
        s
    }

    /// How often springs to the right, or else down, are relaxed: as often as the first such pass is there.
    fn rounds(&self, schedule: &Schedule) -> u32 {
        let first = schedule.relax.iter().find(|p| p.is_structural());
        schedule.relax.iter().filter(|p| first == Some(*p)).count() as u32
    }

    /// Without what may differ within a batch.
    fn kind(&self) -> Self {
        Fused { places: 0, threads: 0, ..*self }
    }

    /// Room for both.
    fn with(&self, other: &Self) -> Self {
        Fused { places: self.places.max(other.places), threads: self.threads.max(other.threads), ..*self }
    }
}
