//! Bringing speeds and stretch of all cloths, and which of them contact wakes, back by one small buffer per frame, without waiting.

use std::collections::{HashMap, VecDeque};

use wgpu::Buffer;

use super::Gpu;
use super::lost::poll;
use super::staging::{Parcel, Staging};
use crate::error::Result;
use crate::handle::follow;
use crate::levels::joint::{COUNT_FORCED, COUNT_FORCED_MOST, COUNT_SLOWED, COUNT_SLOWED_MOST};
use crate::passes::Pass;
use crate::world::World;

/// Measurements on their way to the host.
#[derive(Default)]
pub(super) struct Watch {
    staging: Staging,
    /// In the order of recording. If no buffer is free, a frame is measured together with the next one.
    under_way: VecDeque<Measured>,
    /// Time stepped since the last measurement of each cloth \[s\].
    seconds: Vec<f64>,
    /// Memory of frames that have been recorded, or have arrived, which the next ones use again.
    parts: Parts,
    found: Vec<Found>,
    spare: Vec<Vec<Probe>>,
}

/// A cloth that is measured, and where its speed, its stretch and whether contact wakes it lie: the part, and the place in the part's buffer.
type Found = (usize, [Option<(usize, u64)>; 3]);

/// The part that each count of contact that is safe is in, and its place there.
type Held = [(usize, u64); 4];

/// The measurements of one frame.
struct Measured {
    parcel: Parcel,
    probes: Vec<Probe>,
    /// Where the counts of contact that is safe lie: pins that it could not give way to, and particles that are too fast, each in the last step and in
    /// all steps before it.
    held: Option<[usize; 4]>,
}

/// The measurements of one cloth.
struct Probe {
    /// Its index now; none if it has left.
    cloth: Option<usize>,
    /// Where in the parcel the speed lies, and what counts as calm; none where no cloth falls asleep.
    fastest: Option<(usize, f64)>,
    /// Where the stretch lies and the substeps of the frame, where it was measured.
    strain: Option<(usize, u32)>,
    /// Of cloth that is asleep: where a number lies that is not 0 if contact wakes it.
    struck: Option<usize>,
    seconds: f64,
    changes: u64,
}

/// Parts of buffers that are copied one after the other: those of cloths that share a buffer as one.
#[derive(Default)]
struct Parts {
    list: Vec<Part>,
    places: HashMap<Buffer, usize>,
}

/// From a place of a buffer to another \[bytes\], and where it begins in the copy.
struct Part {
    buffer: Buffer,
    from: u64,
    to: u64,
    start: u64,
}

impl Parts {
    /// Takes in four bytes; returns the part that they are in.
    fn add(&mut self, (buffer, at): (&Buffer, u64)) -> usize {
        let last = self.list.len().checked_sub(1).filter(|n| self.list[*n].buffer == *buffer);
        let known = last.or_else(|| self.places.get(buffer).copied());
        if let Some(place) = known {
            let part = &mut self.list[place];
            (part.from, part.to) = (part.from.min(at), part.to.max(at + 4));
            return place;
        }
        self.places.insert(buffer.clone(), self.list.len());
        self.list.push(Part { buffer: buffer.clone(), from: at, to: at + 4, start: 0 });
        self.list.len() - 1
    }

    /// Puts one behind the other; the end of the last.
    fn join(&mut self) -> u64 {
        let mut end = 0;
        for part in &mut self.list {
            part.start = end;
            end += part.to - part.from;
        }
        end
    }

    /// Where in the copy a place of a part lies.
    fn place(&self, (part, at): (usize, u64)) -> usize {
        let Part { start, from, .. } = &self.list[part];
        (start + at - from) as usize
    }

    fn clear(&mut self) {
        self.list.clear();
        self.places.clear();
    }
}

impl Watch {
    /// For a number of cloths.
    pub fn new(cloths: usize) -> Self {
        Watch { seconds: vec![0.0; cloths], ..Watch::default() }
    }

    /// Takes in that a cloth comes.
    pub fn join(&mut self) {
        self.seconds.push(0.0);
    }

    /// Lets a cloth go. The measurements of those behind it follow their cloths.
    pub fn leave(&mut self, cloth: usize) {
        self.seconds.remove(cloth);
        for probe in self.under_way.iter_mut().flat_map(|m| &mut m.probes) {
            if !probe.cloth.as_mut().is_some_and(|index| follow(index, cloth)) {
                probe.cloth = None;
            }
        }
    }

    /// Takes in what has arrived, in order.
    fn settle(&mut self, world: &mut World) -> Result<()> {
        while let Some(measured) = self.under_way.front() {
            let number = |bytes: &[u8], at: usize| f64::from(bytemuck::pod_read_unaligned::<f32>(&bytes[at..at + 4]));
            let read = |bytes: &[u8]| -> Vec<[Option<f64>; 3]> {
                let places = |p: &Probe| [p.fastest.map(|f| f.0), p.strain.map(|s| s.0), p.struck];
                let of = |p: &Probe| places(p).map(|at| Some(number(bytes, at?)));
                measured.probes.iter().map(of).collect()
            };
            let whole = |bytes: &[u8], at: usize| bytemuck::pod_read_unaligned::<u32>(&bytes[at..at + 4]) as usize;
            let both = |bytes: &[u8]| (read(bytes), measured.held.map(|held| held.map(|at| whole(bytes, at))));
            let Some((numbers, held)) = measured.parcel.open(both)? else { break };
            let Some(measured) = self.under_way.pop_front() else { break };
            if let Some([forced, forced_before, slowed, slowed_before]) = held {
                world.note_held(forced.max(forced_before), slowed.max(slowed_before));
            }
            for (probe, [fastest, strain, struck]) in measured.probes.iter().zip(numbers) {
                let Some(cloth) = probe.cloth else { continue };
                if let (Some(fastest), Some((_, limit))) = (fastest, probe.fastest)
                    && probe.changes == world.runs[cloth].calm.changes
                {
                    world.note(cloth, fastest <= limit, probe.seconds, || None);
                }
                if struck.is_some_and(|struck| struck > 0.0) && probe.changes == world.runs[cloth].calm.changes {
                    world.wake(cloth);
                }
                // With another number of substeps it was another question.
                if let (Some(strain), Some((_, substeps))) = (strain, probe.strain)
                    && substeps == world.control.options.substeps
                {
                    world.control.chooser.measured(strain);
                }
            }
            self.staging.put_back(measured.parcel);
            self.spare.push(measured.probes);
        }
        Ok(())
    }
}

impl Gpu {
    /// Copies the speeds and the stretch of cloths that are awake to where the host may read them.
    pub(super) fn watch(&mut self, world: &World, encoder: &mut wgpu::CommandEncoder, steps: u32) {
        let limit = world.calm_below();
        let counts = self.joint.as_ref().and_then(|joint| joint.counts());
        if steps == 0 || limit.is_none() && counts.is_none() && world.control.options.quality.target().is_none() {
            return;
        }
        let (mut parts, mut found) = (std::mem::take(&mut self.watch.parts), std::mem::take(&mut self.watch.found));
        for index in (0..self.cloths.len()).filter(|c| !world.runs[*c].asleep) {
            let cloth = &self.cloths[index];
            let shared = world.is_shared(index);
            let fastest = limit.and_then(|_| cloth.fastest(shared));
            let measured = world.runs[index].schedule.frame.iter().any(|p| matches!(p, Pass::Strain { .. }));
            let strain = if measured { cloth.strain(shared) } else { None };
            if fastest.is_some() || strain.is_some() {
                self.watch.seconds[index] += f64::from(steps) * world.control.clock.dt;
                found.push((index, [fastest, strain, None].map(|from| Some((parts.add(from?), from?.1)))));
            }
        }
        for (member, cloth) in self.joint.iter().flat_map(|joint| joint.cloths.iter().enumerate()) {
            let from = self.joint.as_ref().and_then(|joint| joint.struck(member));
            if let Some(from) = from.filter(|_| world.runs[*cloth].asleep) {
                found.push((*cloth, [None, None, Some((parts.add(from), from.1))]));
            }
        }
        const COUNTED: [usize; 4] = [COUNT_FORCED, COUNT_FORCED_MOST, COUNT_SLOWED, COUNT_SLOWED_MOST];
        let held = counts.map(|counts| COUNTED.map(|n| (parts.add((counts, 4 * n as u64)), 4 * n as u64)));
        self.measure(world, encoder, (&mut parts, &found, held));
        parts.clear();
        found.clear();
        (self.watch.parts, self.watch.found) = (parts, found);
    }

    /// Copies what was found to where the host may read it, if a buffer is free.
    fn measure(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        (parts, found, held): (&mut Parts, &[Found], Option<Held>),
    ) {
        let size = parts.join();
        if found.is_empty() && held.is_none() {
            return;
        }
        // Cloths that fall asleep one by one need no other buffers.
        let Some(parcel) = self.watch.staging.take(&self.device, "measured", size.next_power_of_two()) else { return };
        for Part { buffer, from, to, start } in &parts.list {
            encoder.copy_buffer_to_buffer(buffer, *from, &parcel.staging, *start, to - from);
        }
        let (seconds, limit) = (&mut self.watch.seconds, world.calm_below());
        let probe = |&(index, [fastest, strain, struck]): &Found| Probe {
            cloth: Some(index),
            fastest: fastest.map(|at| parts.place(at)).zip(limit),
            strain: strain.map(|at| (parts.place(at), world.control.options.substeps)),
            struck: struck.map(|at| parts.place(at)),
            seconds: std::mem::take(&mut seconds[index]),
            changes: world.runs[index].calm.changes,
        };
        let mut probes = self.watch.spare.pop().unwrap_or_default();
        probes.clear();
        probes.extend(found.iter().map(probe));
        let held = held.map(|held| held.map(|at| parts.place(at)));
        self.watch.under_way.push_back(Measured { parcel, probes, held });
    }

    /// Takes in what has arrived, in order, and asks for the rest. Does not wait.
    pub fn settle(&mut self, world: &mut World) -> Result<()> {
        self.watch.under_way.iter_mut().for_each(|measured| measured.parcel.ask());
        self.boxes.ask();
        self.timing.ask();
        poll(&self.device, wgpu::PollType::Poll)?;
        self.boxes.settle(world)?;
        let chooser = &mut world.control.chooser;
        self.timing.settle(self.writer.queue.get_timestamp_period(), |steps, ms| chooser.took(steps, ms))?;
        self.watch.settle(world)?;
        world.forget_paths();
        Ok(())
    }
}
