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
use crate::passes::FOLLOW_STEPS;
use crate::shaders::{Bound, Slot};
use crate::world::World;

/// Bytes of a particle in the longest list.
const LONGEST: u64 = 16 * MAX_OTHERS as u64;

/// The cloths of a scene that have contact, where more than one has.
pub(super) struct Joint {
    /// The cloths and their numbers of particles; where these change, other buffers are needed.
    key: Vec<(ClothHandle, usize)>,
    /// Contact distances \[m\], which stay as they were when a cloth came.
    distances: Vec<f32>,
    /// The cloths by index.
    pub cloths: Vec<usize>,
    /// Whether the shadow of a cloth is that of cloth that is asleep.
    pub still: Vec<bool>,
    pub layout: joint::Joint,
    buffers: HashMap<Slot, Buffer>,
    /// By what they bind, with the buffer of the numbers of a frame.
    groups: HashMap<Vec<Bound>, (Buffer, wgpu::BindGroup)>,
}

impl Joint {
    /// That of a world's cloths now; `known` is that of the last frame, which is kept if it still holds. None where fewer than two cloths
    /// have contact.
    pub fn follow(known: Option<Box<Joint>>, device: &wgpu::Device, world: &World) -> Option<Box<Joint>> {
        let cloths = world.meeting();
        if cloths.len() < 2 {
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
        let mut homes = vec![[0.0f32; 4]; layout.particles];
        let crossed = world.crossed_at_rest(&cloths);
        for ((cloth, first), crossed) in of.iter().zip(&layout.firsts).zip(&crossed) {
            for (k, [x, y, z]) in cloth.positions().iter().enumerate() {
                let crosses = crossed.get(k).is_some_and(|crossed| *crossed);
                homes[*first as usize + k] = [*x, *y, *z, f32::from(u8::from(crosses))];
            }
        }
        let none = BufferUsages::empty();
        let particles = layout.particles as u64;
        let room = |slot: Slot, bytes: u64| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            (slot, empty(device, slot.name(), bytes, usage))
        };
        let buffers = HashMap::from([
            (Slot::Grids, upload(device, "grids", &layout.grids, none)),
            (Slot::Kin, upload(device, "kin", &layout.table, none)),
            (Slot::Homes, upload(device, "homes", &homes, none)),
            room(Slot::Boxes, 32 * layout.boxes as u64),
            room(Slot::Shadows, 32 * particles),
            room(Slot::Others, LONGEST * particles),
            room(Slot::Struck, 4 * cloths.len() as u64),
        ]);
        let still = vec![false; cloths.len()];
        Joint { key, distances, cloths, still, layout, buffers, groups: HashMap::new() }
    }

    /// Hands a cloth its parts of the buffers.
    pub fn share(&self, member: usize, cloth: &mut ClothBuffers, numbers: &Buffer) {
        let (first, count) = (u64::from(self.layout.firsts[member]), self.key[member].1 as u64);
        let own = |slot, each| {
            let buffer: &Buffer = &self.buffers[&slot];
            Span { buffer: buffer.clone(), offset: each * first, size: each * count }
        };
        cloth.replace(Slot::Shadow, own(Slot::Shadows, 32));
        cloth.replace(Slot::Others, own(Slot::Others, LONGEST));
        cloth.replace(Slot::Shadows, self.buffers[&Slot::Shadows].clone().into());
        cloth.replace(Slot::Part, Span { buffer: numbers.clone(), offset: 0, size: 16 });
    }

    /// Where it is noted that a cloth, by its place among these, has to wake.
    pub fn struck(&self, member: usize) -> (&Buffer, u64) {
        (&self.buffers[&Slot::Struck], 4 * member as u64)
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
        let own = self.buffers.iter().filter(|(slot, _)| ![Slot::Shadows, Slot::Others].contains(slot));
        own.map(|(_, buffer)| buffer.size()).sum()
    }
}

/// Rows of numbers in a frame of `steps` steps at most: one per cloth and one for all, where others are seen.
pub(super) fn rows(world: &World, steps: u32) -> u64 {
    let count = world.meeting().len() as u64;
    if count > 1 { (count + 1) * u64::from(steps.div_ceil(FOLLOW_STEPS)) } else { 0 }
}

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
