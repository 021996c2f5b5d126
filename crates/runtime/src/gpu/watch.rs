//! Bringing speeds and stretch back without waiting.

use std::collections::VecDeque;

use super::Gpu;
use super::lost::poll;
use super::staging::{Parcel, Staging};
use crate::error::Result;
use crate::passes::Pass;
use crate::world::World;

/// Measurements of one cloth on their way to the host.
#[derive(Default)]
pub(super) struct Watch {
    staging: Staging,
    /// In the order of recording; a frame for which there is no buffer is measured with the next.
    under_way: VecDeque<Probe>,
    /// Time stepped since the last one \[s\].
    seconds: f64,
}

struct Probe {
    parcel: Parcel,
    /// What counts as calm; none where no cloth falls asleep.
    limit: Option<f64>,
    /// In the frame, where stretch was measured.
    substeps: Option<u32>,
    seconds: f64,
    changes: u64,
}

impl Gpu {
    /// Copies the speeds and the stretch of cloths that are awake to where the host may read them.
    pub(super) fn watch(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, steps: u32) {
        let limit = world.calm_below();
        if limit.is_none() && world.control.options.quality.target().is_none() {
            return;
        }
        for index in (0..self.cloths.len()).filter(|c| !world.runs[*c].asleep) {
            let (watch, cloth) = (&mut self.watches[index], &self.cloths[index]);
            let fused = world.is_fused(index, steps);
            let fastest = limit.and_then(|_| cloth.fastest(fused));
            let measured = world.runs[index].schedule.frame.iter().any(|p| matches!(p, Pass::Strain { .. }));
            let strain = if measured { cloth.strain(fused) } else { None };
            if fastest.is_none() && strain.is_none() {
                continue;
            }
            watch.seconds += f64::from(steps) * world.control.clock.dt;
            let Some(parcel) = watch.staging.take(&self.device, "measured", 8) else { continue };
            for ((from, at), to) in fastest.map(|f| (f, 0)).into_iter().chain(strain.map(|s| (s, 4))) {
                encoder.copy_buffer_to_buffer(from, at, &parcel.staging, to, 4);
            }
            let (seconds, changes) = (std::mem::take(&mut watch.seconds), world.runs[index].calm.changes);
            let (limit, substeps) = (fastest.and(limit), strain.map(|_| world.control.options.substeps));
            watch.under_way.push_back(Probe { parcel, limit, substeps, seconds, changes });
        }
    }

    /// Takes in what has arrived, in order, and asks for the rest. Does not wait.
    pub fn settle(&mut self, world: &mut World) -> Result<()> {
        let (probes, boxes) = (self.watches.iter_mut().flat_map(|w| &mut w.under_way), &mut self.boxes);
        probes.for_each(|probe| probe.parcel.ask());
        boxes.ask();
        poll(&self.device, wgpu::PollType::Poll)?;
        boxes.settle()?;
        for (index, watch) in self.watches.iter_mut().enumerate() {
            while let Some(probe) = watch.under_way.front() {
                let Some(measured) = probe.parcel.open(|bytes| bytemuck::pod_read_unaligned(&bytes[..8]))? else {
                    break;
                };
                let [fastest, strain]: [f32; 2] = measured;
                let Some(probe) = watch.under_way.pop_front() else { break };
                if let Some(limit) = probe.limit.filter(|_| probe.changes == world.runs[index].calm.changes) {
                    world.note(index, f64::from(fastest) <= limit, probe.seconds);
                }
                // With another number of substeps it was another question.
                if probe.substeps == Some(world.control.options.substeps) {
                    world.control.chooser.measured(f64::from(strain));
                }
                watch.staging.put_back(probe.parcel);
            }
        }
        Ok(())
    }
}
