//! Bringing speeds and stretch back without waiting.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::Gpu;
use super::lost::poll;
use super::read_back::MAPPED;
use super::upload::empty;
use crate::error::{Error, Result};
use crate::passes::Pass;
use crate::world::World;

/// Measurements of one cloth on their way to the host.
#[derive(Default)]
pub(super) struct Watch {
    free: Vec<wgpu::Buffer>,
    made: u32,
    /// In the order of recording.
    under_way: VecDeque<Probe>,
    /// Time stepped since the last one \[s\].
    seconds: f64,
}

struct Probe {
    staging: wgpu::Buffer,
    mapping: Option<Receiver<std::result::Result<(), wgpu::BufferAsyncError>>>,
    /// What counts as calm; none where no cloth falls asleep.
    limit: Option<f64>,
    /// In the frame, where stretch was measured.
    substeps: Option<u32>,
    seconds: f64,
    changes: u64,
}

/// Most read-backs in flight; a frame beyond is measured with the next.
const MOST: u32 = 4;

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
            let Some(staging) = watch.staging(&self.device) else { continue };
            for ((from, at), to) in fastest.map(|f| (f, 0)).into_iter().chain(strain.map(|s| (s, 4))) {
                encoder.copy_buffer_to_buffer(from, at, &staging, to, 4);
            }
            let (seconds, changes) = (std::mem::take(&mut watch.seconds), world.runs[index].calm.changes);
            let (limit, substeps) = (fastest.and(limit), strain.map(|_| world.control.options.substeps));
            watch.under_way.push_back(Probe { staging, mapping: None, limit, substeps, seconds, changes });
        }
    }

    /// Takes in what has arrived, in order, and asks for the rest. Does not wait.
    pub fn settle(&mut self, world: &mut World) -> Result<()> {
        let failed = |e: &dyn std::fmt::Display| Error::ReadBack(e.to_string());
        for probe in self.watches.iter_mut().flat_map(|w| &mut w.under_way).filter(|p| p.mapping.is_none()) {
            let (send, receive) = channel();
            probe.staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                // Nobody listens if the stepper is gone.
                let _ = send.send(result);
            });
            probe.mapping = Some(receive);
        }
        poll(&self.device, wgpu::PollType::Poll)?;
        for (index, watch) in self.watches.iter_mut().enumerate() {
            while let Some(mapping) = watch.under_way.front().and_then(|p| p.mapping.as_ref()) {
                match mapping.try_recv() {
                    Err(TryRecvError::Empty) => break,
                    Err(e) => return Err(failed(&e)),
                    Ok(result) => result.map_err(|e| failed(&e))?,
                }
                let Some(probe) = watch.under_way.pop_front() else { break };
                let bytes = probe.staging.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
                let [fastest, strain]: [f32; 2] = bytemuck::pod_read_unaligned(&bytes[..8]);
                drop(bytes);
                probe.staging.unmap();
                watch.free.push(probe.staging);
                if let Some(limit) = probe.limit.filter(|_| probe.changes == world.runs[index].calm.changes) {
                    world.note(index, f64::from(fastest) <= limit, probe.seconds);
                }
                // With another number of substeps it was another question.
                if probe.substeps == Some(world.control.options.substeps) {
                    world.control.chooser.measured(f64::from(strain));
                }
            }
        }
        Ok(())
    }
}

impl Watch {
    fn staging(&mut self, device: &wgpu::Device) -> Option<wgpu::Buffer> {
        if let Some(staging) = self.free.pop() {
            return Some(staging);
        }
        self.made += u32::from(self.made <= MOST);
        (self.made <= MOST).then(|| empty(device, "measured", 8, MAPPED))
    }
}
