//! What shaders only read of cloths, for one cloth or several that lie one after the other.

use std::collections::HashMap;

use bytemuck::{Pod, cast_slice};
use wgpu::{Buffer, BufferUsages};

use super::buffers::{grid_rows, soft_row, upload};
use crate::fused::room_of;
use crate::layout::JobRow;
use crate::shaders::Slot;
use crate::world::World;

/// Lists as shaders lay them out, and where each cloth lies in them.
#[derive(Default)]
pub(super) struct Contents {
    lists: HashMap<Slot, Vec<u8>>,
    /// What is where, without numbers of a step.
    pub jobs: Vec<JobRow>,
}

impl Contents {
    /// Those of an index list of cloths.
    pub fn new(world: &World, cloths: &[usize]) -> Self {
        let mut all = Contents::default();
        for (row, &index) in cloths.iter().enumerate() {
            all.add(world, index, row);
        }
        if let Some(last) = all.jobs.last() {
            let end = all.lists.get(&Slot::Members).map_or(0, |m| m.len() as u32 / 4);
            if last.ring + last.rings > 0 {
                all.add_rows(Slot::Starts, &[end]);
            }
        }
        all
    }

    fn add(&mut self, world: &World, index: usize, row: usize) {
        let (cloth, held) = (&world.scene.cloths[index], &world.runs[index].tethers);
        let first = self.jobs.last().map_or(0, |job| job.first + room_of(job.count as usize) as u32);
        let count = |list: &Self, slot, size: usize| list.lists.get(&slot).map_or(0, |l| l.len() / size) as u32;
        self.jobs.push(JobRow {
            first,
            count: cloth.len() as u32,
            grid: count(self, Slot::Grids, 32),
            grids: cloth.grids().len() as u32,
            ring: count(self, Slot::Starts, 4),
            rings: cloth.ring_count() as u32,
            row: row as u32,
            ..bytemuck::Zeroable::zeroed()
        });
        self.add_rows(Slot::Grids, &grid_rows(cloth, first, soft_row(cloth, world.control.clock.dt)));
        for slot in Slot::ALL {
            if let Some((each, mut bytes)) = slot.texels(cloth, held, first) {
                if *slot == Slot::Targets {
                    // Teleports may have moved them.
                    bytes = cast_slice(&world.runs[index].targets(cloth)).to_vec();
                }
                // What lies between cloths is not read.
                let list = self.lists.entry(*slot).or_default();
                list.resize(first as usize * each, 0);
                list.extend(bytes);
            }
        }
        if let Some(membrane) = cloth.membrane() {
            let [weft, warp, shear] = membrane.soft;
            self.add_rows(Slot::Yielding, &[[weft, warp, shear, 0.0]]);
        }
        if cloth.ring_count() > 0 {
            let (starts, members) = cloth.rings();
            let so_far = count(self, Slot::Members, 4);
            let starts: Vec<u32> = starts[..starts.len() - 1].iter().map(|s| s + so_far).collect();
            self.add_rows(Slot::Starts, &starts);
            self.add_rows(Slot::Members, &members.iter().map(|m| m + first).collect::<Vec<u32>>());
        }
    }

    fn add_rows<T: Pod>(&mut self, slot: Slot, rows: &[T]) {
        self.lists.entry(slot).or_default().extend_from_slice(cast_slice(rows));
    }

    /// Their buffers.
    pub fn upload(&self, device: &wgpu::Device) -> HashMap<Slot, Buffer> {
        // What a cut changes is copied.
        let buffer =
            |(slot, bytes): (&Slot, &Vec<u8>)| (*slot, upload(device, slot.name(), bytes, BufferUsages::COPY_SRC));
        self.lists.iter().filter(|(_, bytes)| !bytes.is_empty()).map(buffer).collect()
    }
}
