//! The lists of coarser grids, of one cloth or of several that lie one after the other.

use bytemuck::cast_slice;
use wgpu::{Buffer, BufferUsages};

use super::upload::upload;
use crate::cloth::Cloth;
use crate::layout::LinkRow;
use crate::levels::{levels, links::ALL, masses, rows, ties};
use crate::shaders::Slot;

/// Heads and rows of levels, nodes, limits, and what ties nodes across seams, as shaders/part/level.wgsl and what it names read them.
#[derive(Default)]
pub(super) struct Coarse {
    /// A row per grid: its first level among `levels`, their number, and where the ties and the nodes of its cloth begin.
    heads: Vec<[u32; 4]>,
    levels: Vec<[u32; 4]>,
    nodes: Vec<[[f32; 4]; 2]>,
    limits: Vec<[f32; 4]>,
    ties: Vec<[u32; 4]>,
    /// Where each cloth begins in these lists.
    begins: Vec<Begin>,
}

/// Lengths of the lists of [`Coarse`]; `ties` where those of the cloth begin.
#[derive(Clone, Copy)]
struct Begin {
    heads: usize,
    levels: usize,
    nodes: usize,
    ties: usize,
}

impl Coarse {
    /// Adds a cloth; `like` is the number of one before that it is an instance of, whose limits and ties it shares.
    pub fn add(&mut self, cloth: &Cloth, like: Option<usize>) {
        let begin = Begin {
            heads: self.heads.len(),
            levels: self.levels.len(),
            nodes: self.nodes.len(),
            ties: like.map_or(self.ties.len(), |other| self.begins[other].ties),
        };
        match like.map(|other| self.begins[other]) {
            Some(other) => self.copy(cloth, (other, begin)),
            None => self.make(cloth, begin),
        }
        self.begins.push(begin);
    }

    fn copy(&mut self, cloth: &Cloth, (from, to): (Begin, Begin)) {
        for grid in 0..cloth.grids().len() {
            let [level, count, ties, _] = self.heads[from.heads + grid];
            let level = level as usize - from.levels + to.levels;
            self.heads.push([level as u32, count, ties, to.nodes as u32]);
        }
        let (level_rows, nodes) = rows(cloth);
        for n in 0..level_rows - cloth.grids().len() {
            let [first, width, height, image] = self.levels[from.levels + n];
            self.levels.push([first - from.nodes as u32 + to.nodes as u32, width, height, image]);
        }
        self.nodes.extend_from_within(from.nodes..from.nodes + nodes);
    }

    fn make(&mut self, cloth: &Cloth, begin: Begin) {
        let mass = masses(cloth);
        let first = |list: usize| list as u32;
        for grid in 0..cloth.grids().len() {
            let levels = levels(cloth, grid, &mass);
            self.heads.push([first(self.levels.len()), levels.len() as u32, first(begin.ties), first(begin.nodes)]);
            for level in levels {
                self.levels.push([first(self.nodes.len()), level.width, level.height, first(self.limits.len())]);
                self.nodes.extend(level.inverse_mass.iter().map(|w| [[0.0; 4], [0.0, 0.0, 0.0, *w]]));
                self.limits.extend(level.limits);
            }
        }
        if cloth.ring_count() > 0 {
            // Nodes are counted from the first one of the cloth.
            let node = |grid: usize, n: usize| {
                let level = self.heads[begin.heads + grid][0] as usize + n;
                self.levels[level][0] - begin.nodes as u32
            };
            let rows = ties::rows(&ties::ties(cloth), node);
            self.ties.extend(rows);
        }
    }

    /// The lists that shaders only read.
    pub fn listed(&self) -> [(Slot, Vec<u8>); 3] {
        let heads = self.heads.iter().map(|[level, rest @ ..]| {
            let [count, ties, nodes] = *rest;
            [level + self.heads.len() as u32, count, ties, nodes]
        });
        let table: Vec<[u32; 4]> = heads.chain(self.levels.iter().copied()).collect();
        let (limits, ties) = (cast_slice(&self.limits), cast_slice(&self.ties));
        [(Slot::Levels, cast_slice(&table).to_vec()), (Slot::Limits, limits.to_vec()), (Slot::Ties, ties.to_vec())]
    }

    /// The buffer of nodes; none without any.
    pub fn nodes(&self, device: &wgpu::Device) -> Option<Buffer> {
        (!self.nodes.is_empty()).then(|| upload(device, "nodes", &self.nodes, BufferUsages::empty()))
    }
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
