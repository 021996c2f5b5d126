//! Data of cloths that changes: in the buffers of one cloth, or of several that lie one after the other.

use std::collections::HashMap;

use wgpu::{Buffer, BufferUsages};

use super::contents::firsts;
use super::span::Span;
use super::upload::{DRAWN, upload};
use crate::cpu::start::Start;
use crate::fused::room_of;
use crate::layout::{FAULT_BYTES, FAULT_STRIDE};
use crate::options::Solver;
use crate::shaders::{LASTING, Slot};
use crate::world::World;

/// Positions, normals, faults and good frames of cloths. A cloth that shares nothing is a store of one.
pub(super) struct Store {
    state: State<Buffer>,
}

/// Data that changes in a frame.
pub(super) struct State<B> {
    pub now: B,
    pub before: B,
    pub normals: B,
    /// Data that only steps need: counters of faults, the last good frame, and remainders too small for positions.
    pub others: HashMap<Slot, B>,
}

impl Store {
    /// Uploads the cloths of an index list as they begin, and returns where each of them lies. `draw_only`: without what only
    /// steps need.
    pub fn new(
        device: &wgpu::Device,
        world: &World,
        cloths: &[usize],
        draw_only: bool,
    ) -> (Self, Vec<(usize, State<Span>)>) {
        let at: Vec<_> = firsts(world, cloths);
        let count = |cloth: usize| world.scene.cloths[cloth].len();
        let cloths: Vec<_> = cloths.iter().zip(at).map(|(c, at)| (*c, at as usize, count(*c))).collect();
        let mut lists: [Vec<[f32; 4]>; 3] = Default::default();
        for (cloth, first, _) in &cloths {
            let dt = world.control.clock.dt_old;
            let start = Start::<f32>::new(&world.scene.cloths[*cloth], &world.control.options, dt);
            for (list, data) in lists.iter_mut().zip([&start.now, &start.before, &start.normals]) {
                // Between cloths there are no particles.
                list.resize(*first, [0.0, 0.0, 0.0, -1.0]);
                list.extend(data);
            }
        }
        let none = BufferUsages::empty();
        let [now, before, normals] = lists;
        let mut others = HashMap::new();
        if world.control.options.solver == Solver::Xpbd && !draw_only {
            let faults = vec![0u32; FAULT_STRIDE as usize * cloths.len()];
            others.insert(Slot::Faults, upload(device, "faults", &faults, BufferUsages::COPY_SRC));
            let exact = cloths.iter().any(|(c, ..)| world.scene.cloths[*c].is_exact());
            let room = room_of(now.len());
            let mut lasting = now.clone();
            lasting.resize(if exact { 2 * room } else { now.len() }, [0.0; 4]);
            others.insert(Slot::Lasting, upload(device, "lasting", &lasting, none));
        }
        let [now, before, normals] = [("now", now), ("before", before), ("normals", normals)]
            .map(|(name, list)| upload(device, name, &list, DRAWN));
        let state = State { now, before, normals, others };
        let spans = state.spans(&cloths);
        (Store { state }, spans)
    }

    /// Where a cloth lies by its row, first particle and number of particles.
    pub fn span(&self, row: usize, first: usize, count: usize) -> State<Span> {
        self.state.span(row, first, count)
    }

    /// Particles that there is room for.
    pub fn room(&self) -> usize {
        room_of(self.state.now.size() as usize / 16)
    }

    /// The whole buffer of a slot.
    pub fn get(&self, slot: Slot) -> Option<&Buffer> {
        match slot {
            Slot::Now => Some(&self.state.now),
            Slot::Before => Some(&self.state.before),
            Slot::Normals => Some(&self.state.normals),
            other => self.state.others.get(&other),
        }
    }
}

impl State<Buffer> {
    /// Where each of some cloths lies: index, first particle and their number.
    fn spans(&self, cloths: &[(usize, usize, usize)]) -> Vec<(usize, State<Span>)> {
        let each = cloths.iter().enumerate();
        each.map(|(row, (cloth, first, count))| (*cloth, self.span(row, *first, *count))).collect()
    }

    /// Where a cloth lies.
    fn span(&self, row: usize, first: usize, count: usize) -> State<Span> {
        let span = |buffer: &Buffer, offset: usize, size: usize| Span {
            buffer: buffer.clone(),
            offset: offset as u64,
            size: size as u64,
        };
        let list = |buffer: &Buffer| span(buffer, 16 * first, 16 * count);
        let State { now, before, normals, others } = self;
        let mut own = HashMap::new();
        if let Some(faults) = others.get(&Slot::Faults) {
            own.insert(Slot::Faults, span(faults, 4 * FAULT_STRIDE as usize * row, FAULT_BYTES));
        }
        if let Some(lasting) = others.get(&Slot::Lasting) {
            let room = room_of(now.size() as usize / 16);
            let begins = LASTING.iter().enumerate().map(|(n, slot)| (*slot, n * room + first));
            let there = begins.filter(|(_, begins)| ((16 * begins) as u64) < lasting.size());
            own.extend(there.map(|(slot, begins)| (slot, span(lasting, 16 * begins, 16 * count))));
        }
        State { now: list(now), before: list(before), normals: list(normals), others: own }
    }
}
