//! Picking on the GPU: two dispatches per cloth, and a small buffer that the host maps when it likes.

use bytemuck::cast_slice;

use super::read_back::MAPPED;
use super::span::Span;
use super::upload::{empty, filled};
use super::{Gpu, begin};
use crate::handle::ClothHandle;
use crate::passes::Pass;
use crate::shaders::{Slot, source};
use crate::world::World;

/// Bytes of the result of a cloth: the candidate and three corners.
pub const FOUND: u64 = 64;

/// A result that is on its way.
pub struct Pending {
    /// [`FOUND`] bytes per cloth, for the host to map.
    pub staging: wgpu::Buffer,
    /// First particle and width of each grid of each cloth.
    pub grids: Vec<Vec<(u32, u32)>>,
    /// The handle of each cloth.
    pub handles: Vec<ClothHandle>,
}

impl Gpu {
    /// Records the search along a ray from `origin` in the unit `direction`.
    pub fn pick(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        origin: [f32; 3],
        direction: [f32; 3],
    ) -> Pending {
        let buffer = |label, size, usage| empty(&self.device, label, size, usage);
        let staging = buffer("picked", FOUND * world.scene.cloths.len().max(1) as u64, MAPPED);
        let storage = wgpu::BufferUsages::STORAGE;
        let found: Vec<_> = (world.scene.cloths.iter())
            .map(|cloth| {
                let groups = source(&Pass::Pick { holes: cloth.is_cut() }.into()).workgroups(cloth);
                let count = groups.iter().map(|n| u64::from(*n)).product::<u64>();
                let found = buffer("found", FOUND, storage | wgpu::BufferUsages::COPY_SRC);
                (buffer("candidates", 16 * count, storage), found, groups)
            })
            .collect();
        let ray = [origin, direction].map(|[x, y, z]| [x, y, z, 0.0]);
        let ray = filled(&self.device, "ray", cast_slice(&ray), storage).into();
        let mut pass = begin(encoder, "pick");
        for (index, (candidates, found, groups)) in found.iter().enumerate() {
            let lists = [candidates, found].map(|buffer| Span::from(buffer.clone()));
            let more = [(Slot::Action, &ray), (Slot::Candidates, &lists[0]), (Slot::Found, &lists[1])];
            let holes = world.scene.cloths[index].is_cut();
            self.once(world, &mut pass, index, Pass::Pick { holes }, &more, *groups);
            self.once(world, &mut pass, index, Pass::PickNearest, &more, [1; 3]);
        }
        drop(pass);
        for (index, (_, found, _)) in found.iter().enumerate() {
            encoder.copy_buffer_to_buffer(found, 0, &staging, FOUND * index as u64, FOUND);
        }
        let grids = world.scene.cloths.iter();
        let grids = grids.map(|c| c.grids().iter().map(|g| (g.first, g.width)).collect()).collect();
        Pending { staging, grids, handles: world.handles.clone() }
    }
}
