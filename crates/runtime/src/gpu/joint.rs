//! The buffers of cloths whose contact is computed together, and the dispatches that they share.

use std::collections::HashMap;

use wgpu::{Buffer, BufferUsages};

use super::buffers::ClothBuffers;
use super::pipelines::Pipeline;
use super::span::Span;
use super::upload::{empty, upload};
use crate::cloth::Cloth;
use crate::cpu::fabric::meeting::others::MAX_OTHERS;
use crate::error::{Error, Result};
use crate::handle::ClothHandle;
use crate::levels::joint;
use crate::levels::safe::ROUNDS;
use crate::passes::FOLLOW_STEPS;
use crate::shaders::{Bound, Slot};
use crate::world::{World, is_safe};

/// Bytes of a particle in the longest list.
const LONGEST: u64 = 16 * MAX_OTHERS as u64;

/// The cloths of a scene that have contact, where more than one has or contact is safe.
pub(super) struct Joint {
    /// The cloths and their numbers of particles; where these change, other buffers are needed.
    key: Vec<(ClothHandle, usize)>,
    /// Contact distances \[m\], which stay as they were when a cloth came.
    distances: Vec<f32>,
    /// The cloths by index.
    pub cloths: Vec<usize>,
    /// Whether the shadow of a cloth is that of cloth that is asleep.
    pub still: Vec<bool>,
    /// Whether the contact of a cloth is safe.
    pub safe: Vec<bool>,
    /// Whether particles of cloth that is asleep are where it sleeps.
    pub shown: Vec<bool>,
    /// Whether free particles were put elsewhere, or anything was done to cloths, since steps were held back last.
    pub put: bool,
    pub touched: bool,
    /// Where the numbers of the rounds lie in this frame.
    pub rounds: [u32; ROUNDS as usize],
    pub layout: joint::Joint,
    buffers: HashMap<Slot, Buffer>,
    /// By what they bind, with the buffer of the numbers of a frame.
    groups: HashMap<Vec<Bound>, (Buffer, wgpu::BindGroup)>,
}

impl Joint {
    /// That of a world's cloths now; `known` is that of the last frame, which is kept if it still holds. None where no cloth needs it.
    pub fn follow(known: Option<Box<Joint>>, device: &wgpu::Device, world: &World) -> Option<Box<Joint>> {
        let cloths = world.meeting();
        if cloths.len() < 2 && !world.has_safe() {
            return None;
        }
        let key: Vec<_> = cloths.iter().map(|c| (world.handles[*c], world.scene.cloths[*c].len())).collect();
        if let Some(mut joint) = known {
            if joint.key == key {
                joint.cloths = cloths;
                return Some(joint);
            }
            return Some(Box::new(Joint::new(device, world, (cloths, key), &joint)));
        }
        Some(Box::new(Joint::new(device, world, (cloths, key), &Joint::none())))
    }

    fn none() -> Self {
        Joint {
            key: Vec::new(),
            distances: Vec::new(),
            cloths: Vec::new(),
            still: Vec::new(),
            safe: Vec::new(),
            shown: Vec::new(),
            put: true,
            touched: true,
            rounds: [0; ROUNDS as usize],
            layout: joint::Joint::default(),
            buffers: HashMap::new(),
            groups: HashMap::new(),
        }
    }

    /// Cloths that were there before keep their distances.
    fn new(
        device: &wgpu::Device,
        world: &World,
        (cloths, key): (Vec<usize>, Vec<(ClothHandle, usize)>),
        last: &Joint,
    ) -> Self {
        let of: Vec<&Cloth> = cloths.iter().map(|c| &world.scene.cloths[*c]).collect();
        let known = |key: &(ClothHandle, usize)| last.key.iter().position(|k| k == key).map(|n| last.distances[n]);
        let distance = |(key, cloth): (_, &&Cloth)| {
            known(key).unwrap_or_else(|| cloth.contact_distance(world.control.options.thickness))
        };
        let distances: Vec<f32> = key.iter().zip(&of).map(distance).collect();
        let layout = joint::Joint::of(&of, &distances);
        let none = BufferUsages::empty();
        let particles = layout.particles as u64;
        let room = |slot: Slot, bytes: u64| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            (slot, empty(device, slot.name(), bytes, usage))
        };
        let safe: Vec<bool> = of.iter().map(|cloth| is_safe(cloth)).collect();
        let is_any_safe = safe.contains(&true);
        let boxes = if is_any_safe { layout.boxes_of_cells() } else { layout.boxes };
        let mut buffers = HashMap::from([
            (Slot::Grids, upload(device, "grids", &layout.grids, none)),
            (Slot::Kin, upload(device, "kin", &layout.table, none)),
            room(Slot::Boxes, 32 * boxes as u64),
        ]);
        if cloths.len() > 1 {
            let homes = homes(world, (&cloths, &of), &layout);
            buffers.extend([
                (Slot::Homes, upload(device, "homes", &homes, none)),
                room(Slot::Shadows, 32 * particles),
                room(Slot::Others, LONGEST * particles),
                room(Slot::Struck, 4 * cloths.len() as u64),
            ]);
        }
        if is_any_safe {
            let lists = [Slot::Goals, Slot::Places, Slot::Bases, Slot::Ways];
            buffers.extend(lists.map(|slot| room(slot, 16 * particles)));
            buffers.extend([room(Slot::Faces, 4 * particles), room(Slot::Counts, 4 * joint::COUNTS as u64)]);
        }
        let (still, shown, groups) = (vec![false; cloths.len()], vec![false; cloths.len()], HashMap::new());
        let rounds = [0; ROUNDS as usize];
        let (put, touched) = (true, true);
        Joint { key, distances, cloths, still, safe, shown, put, touched, rounds, layout, buffers, groups }
    }

    /// Whether cloths touch one another.
    pub fn meets(&self) -> bool {
        self.cloths.len() > 1
    }

    /// Hands a cloth its parts of the buffers.
    pub fn share(&self, member: usize, cloth: &mut ClothBuffers, numbers: &Buffer) {
        let (first, count) = (u64::from(self.layout.firsts[member]), self.key[member].1 as u64);
        let own = |slot, each| {
            let buffer: &Buffer = &self.buffers[&slot];
            Span { buffer: buffer.clone(), offset: each * first, size: each * count }
        };
        if self.meets() {
            cloth.replace(Slot::Shadow, own(Slot::Shadows, 32));
            cloth.replace(Slot::Others, own(Slot::Others, LONGEST));
            cloth.replace(Slot::Shadows, self.buffers[&Slot::Shadows].clone().into());
        }
        if self.safe[member] {
            cloth.replace(Slot::Goals, own(Slot::Goals, 16));
            cloth.replace(Slot::Places, own(Slot::Places, 16));
            cloth.replace(Slot::Faces, own(Slot::Faces, 4));
        }
        cloth.replace(Slot::Part, Span { buffer: numbers.clone(), offset: 0, size: 16 });
    }

    /// Where it is noted that a cloth, by its place among these, has to wake.
    pub fn struck(&self, member: usize) -> Option<(&Buffer, u64)> {
        Some((self.buffers.get(&Slot::Struck)?, 4 * member as u64))
    }

    /// The counters of cloths whose contact is safe.
    pub fn counts(&self) -> Option<&Buffer> {
        self.buffers.get(&Slot::Counts)
    }

    /// The bindings of a shader, made once.
    pub fn group(&mut self, device: &wgpu::Device, pipeline: &Pipeline, numbers: &Buffer) -> &wgpu::BindGroup {
        let bindings = &pipeline.source.bindings;
        let known = self.groups.get(bindings).is_some_and(|(buffer, _)| buffer == numbers);
        if !known {
            let part = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: std::num::NonZeroU64::new(16) };
            let whole = |buffer| wgpu::BufferBinding { buffer, offset: 0, size: None };
            let group = pipeline.bind(device, |slot| match slot {
                Slot::Part => Some(part(numbers)),
                other => self.buffers.get(&other).map(whole),
            });
            self.groups.insert(bindings.clone(), (numbers.clone(), group));
        }
        &self.groups[bindings].1
    }

    /// Bytes of the buffers that cloths have no part of.
    pub fn bytes(&self) -> u64 {
        const SHARED: [Slot; 5] = [Slot::Shadows, Slot::Others, Slot::Goals, Slot::Places, Slot::Faces];
        let own = self.buffers.iter().filter(|(slot, _)| !SHARED.contains(slot));
        own.map(|(_, buffer)| buffer.size()).sum()
    }
}

/// Where all particles are at rest; w is 1 near lines along which cloths cross there.
fn homes(world: &World, (cloths, of): (&[usize], &[&Cloth]), layout: &joint::Joint) -> Vec<[f32; 4]> {
    let mut homes = vec![[0.0f32; 4]; layout.particles];
    let crossed = world.crossed_at_rest(cloths);
    for ((cloth, first), crossed) in of.iter().zip(&layout.firsts).zip(&crossed) {
        for (k, [x, y, z]) in cloth.positions().iter().enumerate() {
            let crosses = crossed.get(k).is_some_and(|crossed| *crossed);
            homes[*first as usize + k] = [*x, *y, *z, f32::from(u8::from(crosses))];
        }
    }
    homes
}

/// Rows of numbers in a frame of `steps` steps at most: one per cloth and one for all, where others are seen, and one per round.
pub(super) fn rows(world: &World, steps: u32) -> u64 {
    let count = world.meeting().len() as u64;
    let met = if count > 1 { (count + 1) * u64::from(steps.div_ceil(FOLLOW_STEPS)) } else { 0 };
    met + if world.has_safe() { u64::from(ROUNDS) } else { 0 }
}

#[cfg(test)]
#[path = "joint_tests.rs"]
mod tests;

/// Errors where a list of all cloths with contact is larger than the device allows.
pub(super) fn fits(limits: &wgpu::Limits, world: &World) -> Result<()> {
    let cloths = world.meeting();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let need = LONGEST * cloths.iter().map(|c| world.scene.cloths[*c].len().next_multiple_of(64) as u64).sum::<u64>();
    match cloths.last() {
        Some(last) if cloths.len() > 1 && need > limit => {
            let cloth = world.scene.cloths[*last].name().into();
            Err(Error::Limit { cloth, buffer: "particles of other cloths in contact", need, limit })
        }
        _ => Ok(()),
    }
}
