//! The buffers of cloth that has contact with cloth.

use wgpu::{Buffer, BufferUsages};

use super::upload::{empty, upload};
use crate::cloth::Cloth;
use crate::cpu::fabric::partners::MAX_PARTNERS;
use crate::levels::boxes;
use crate::shaders::Slot;

/// Its numbers, where particles are at rest, boxes, partners and pushes.
pub(super) fn buffers(device: &wgpu::Device, cloth: &Cloth, thickness: f32) -> Vec<(Slot, Buffer)> {
    let homes: Vec<[f32; 4]> = cloth.positions().iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    let count = cloth.len() as u64;
    let room =
        |slot: Slot, bytes| (slot, empty(device, slot.name(), bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC));
    vec![
        (Slot::Kin, upload(device, "kin", &boxes::kin(cloth, thickness), BufferUsages::empty())),
        (Slot::Homes, upload(device, "homes", &homes, BufferUsages::empty())),
        room(Slot::Boxes, 32 * boxes::count(cloth) as u64),
        room(Slot::Partners, 8 * MAX_PARTNERS as u64 * count),
        room(Slot::Pushes, 32 * count),
    ]
}
