//! The buffers of coarser grids.

use wgpu::{Buffer, BufferUsages};

use super::upload::upload;
use crate::cloth::Cloth;
use crate::layout::LinkRow;
use crate::levels::{levels, links::ALL, masses, rows, ties};
use crate::shaders::Slot;

/// The table of levels, their nodes (where one is, where it was), their limits, and what ties them across seams.
pub(super) fn buffers(device: &wgpu::Device, cloth: &Cloth) -> Vec<(Slot, Buffer)> {
    let (grids, mass) = (cloth.grids().len(), masses(cloth));
    let (mut table, mut nodes, mut limits) = (vec![[0u32; 4]; grids], Vec::new(), Vec::new());
    for grid in 0..grids {
        let levels = levels(cloth, grid, &mass);
        table[grid] = [table.len() as u32, levels.len() as u32, 0, 0];
        for level in levels {
            // Links of nodes come after those of particles.
            let links = (cloth.len() + limits.len()) as u32;
            table.push([limits.len() as u32, level.width, level.height, links]);
            nodes.extend(level.inverse_mass.iter().flat_map(|w| [[0.0; 4], [0.0, 0.0, 0.0, *w]]));
            limits.extend(level.limits);
        }
    }
    let none = BufferUsages::empty();
    let mut all = vec![
        (Slot::Levels, upload(device, "levels", &table, none)),
        (Slot::Nodes, upload(device, "nodes", &nodes, none)),
        (Slot::Limits, upload(device, "limits", &limits, none)),
    ];
    if cloth.ring_count() > 0 {
        let first = |grid: usize, n: usize| table[table[grid][0] as usize + n][0];
        let rows = ties::rows(&ties::ties(cloth), first);
        all.push((Slot::Ties, upload(device, "ties", &rows, none)));
    }
    all
}

/// Links of cloth that is not cut yet; shaders/cut_levels.wgsl finds those of nodes.
pub(super) fn links(device: &wgpu::Device, cloth: &Cloth) -> Buffer {
    let follows = u32::from(ALL);
    let particles = masses(cloth).into_iter().map(|mass| LinkRow { follows, mass: mass as f32 });
    let nodes = std::iter::repeat_n(LinkRow { follows, mass: 0.0 }, rows(cloth).1);
    upload(device, "links", &particles.chain(nodes).collect::<Vec<_>>(), BufferUsages::empty())
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
