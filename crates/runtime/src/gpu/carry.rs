//! Motion that passes carry from one image of a cloth to another, without the host.

use std::sync::Arc;

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::span::Span;
use super::upload::{empty, filled, upload};
use super::{Gpu, begin};
use crate::coarser::{Beside, Table};
use crate::passes::Pass;
use crate::shaders::{Slot, list};
use crate::state::Part;
use crate::world::Leg;

/// A cloth whose motion is to be carried.
pub struct Carried {
    pub cloth: usize,
    /// Its positions on the level that it has left, now and one step before.
    pub from: [Span; 2],
    pub legs: Vec<Leg>,
}

/// The tables of images between which cloths change.
#[derive(Default)]
pub(super) struct Tables {
    there: Vec<(Arc<Table>, Span)>,
}

impl Tables {
    /// The buffer of a table. Those of images that no cloth has any more are dropped.
    fn buffer(&mut self, device: &wgpu::Device, table: &Arc<Table>) -> Span {
        self.there.retain(|(known, _)| Arc::strong_count(known) > 1);
        if let Some((_, span)) = self.there.iter().find(|(known, _)| Arc::ptr_eq(known, table)) {
            return span.clone();
        }
        let span: Span = filled(device, "table", cast_slice(table.words()), BufferUsages::STORAGE).into();
        self.there.push((table.clone(), span.clone()));
        span
    }

    /// Their bytes.
    pub fn bytes(&self) -> u64 {
        self.there.iter().map(|(_, span)| span.size).sum()
    }
}

impl Gpu {
    /// Where the motion of a cloth lies, now and one step before.
    pub fn motion(&self, cloth: usize) -> [Span; 2] {
        let of = &self.cloths[cloth];
        [of.now.clone(), of.before.clone()]
    }

    /// Records that cloths whose buffers are new begin with their motion of before. Lists between levels are buffers of their own, so
    /// cloths do not wait for one another.
    pub fn carry(&mut self, encoder: &mut wgpu::CommandEncoder, cloths: &[Carried]) {
        let mut pass = begin(encoder, "levels");
        let mut arrived = Vec::new();
        for Carried { cloth, from, legs } in cloths {
            let mut motion = from.clone();
            for leg in legs {
                let beside = self.beside(*cloth, leg);
                motion = self.leg(&mut pass, leg, &motion, &beside);
            }
            arrived.push((*cloth, motion));
        }
        drop(pass);
        for (cloth, [now, before]) in &arrived {
            for (from, part) in [(now, Part::Now), (before, Part::Before), (now, Part::Good)] {
                if let Some(to) = self.part(*cloth, part) {
                    encoder.copy_buffer_to_buffer(&from.buffer, from.offset, &to.buffer, to.offset, to.size);
                }
            }
        }
    }

    /// The list of pins between coarse texels. After a device was lost it is that of the start.
    fn beside(&mut self, cloth: usize, leg: &Leg) -> Span {
        let levels = &mut self.cloths[cloth].beside;
        let known = if leg.down { None } else { levels.pop() };
        let span =
            known.unwrap_or_else(|| upload(&self.device, "beside", &rows(&leg.beside), BufferUsages::empty()).into());
        if leg.down {
            levels.push(span.clone());
        }
        span
    }

    /// Records one leg. Returns where the motion on that level lies.
    fn leg(&mut self, pass: &mut wgpu::ComputePass, leg: &Leg, [now, before]: &[Span; 2], beside: &Span) -> [Span; 2] {
        let start: Vec<_> = leg.inverse_masses.iter().map(|w| [0.0, 0.0, 0.0, *w]).collect();
        let to: Span = upload(&self.device, "level", &start, BufferUsages::empty()).into();
        let list_of = |label: &str, lists: u64| -> Span {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            empty(&self.device, label, lists * to.size, usage).into()
        };
        let (to_before, spare) = (list_of("level before", 1), leg.down.then(|| list_of("spare", 2)));
        let table = self.tables.buffer(&self.device, &leg.table);
        let what = if leg.down { Pass::Restrict } else { Pass::Prolong };
        let pipeline = self.pipelines.get(&what.into());
        let group = pipeline.bind(&self.device, |slot| match slot {
            Slot::Now => Some(to.binding()),
            Slot::Before => Some(to_before.binding()),
            Slot::Origin => Some(now.binding()),
            Slot::OriginBefore => Some(before.binding()),
            Slot::Table => Some(table.binding()),
            Slot::Beside => Some(beside.binding()),
            Slot::Spare => spare.as_ref().map(Span::binding),
            _ => None,
        });
        let [x, y, z] = if leg.down { [1; 3] } else { list(start.len()) };
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, z);
        [to, to_before]
    }
}

/// Two rows for each pin, as shaders read them; without pins those of none.
fn rows(beside: &Beside) -> Vec<[u32; 4]> {
    let row = |(k, c, way): &(u32, u32, [f32; 3])| {
        [[*k, *c, 0, 0], [way[0].to_bits(), way[1].to_bits(), way[2].to_bits(), 0]]
    };
    let rows: Vec<_> = beside.iter().flat_map(row).collect();
    if rows.is_empty() { vec![[u32::MAX; 4]; 2] } else { rows }
}

#[cfg(test)]
#[path = "carry_tests.rs"]
mod tests;
