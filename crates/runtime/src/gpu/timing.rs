//! Times of frames and of their passes, from timestamp queries of the device, brought back without waiting.

use std::collections::VecDeque;

use super::Gpu;
use super::recording::Recording;
use super::staging::{Parcel, Staging};
use super::upload::empty;
use crate::error::Result;

/// The time of all dispatches of one shader in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The shader file's stem, as in [`crate::PlannedPass::shader`].
    pub shader: &'static str,
    /// The number of dispatches.
    pub dispatches: u32,
    /// From the beginning of the first of a run of them to the end of the last, over all runs \[ms\].
    pub ms: f64,
}

/// Largest number of compute passes per frame that are timed, by two queries each: a query set has at most 4,096.
const MAX_PASSES: u32 = 2048;
/// The same if only whole frames are timed.
const MAX_PASSES_WHOLE: u32 = 4;

/// The timestamps of frames: those under way, and the times that have arrived.
#[derive(Default)]
pub(super) struct Timing {
    /// Whether each pass is timed, not only the frame as a whole.
    pub each: bool,
    queries: Option<Queries>,
    staging: Staging,
    /// In the order of recording.
    under_way: VecDeque<Timed>,
    /// Of the last frame that has arrived, with each of its passes.
    pub passes: Vec<PassTime>,
    /// Whether the time of any frame has arrived.
    pub known: bool,
}

/// A set of queries, and where they are resolved to.
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Compute passes that they are enough for.
    most: u32,
}

/// Timestamps on their way to the host.
struct Timed {
    parcel: Parcel,
    /// The shader and the dispatches of each compute pass.
    spans: Vec<(&'static str, u32)>,
    each: bool,
    steps: u32,
}

impl Timing {
    /// Begins the compute passes of a frame, timed where that is asked for or the frame has to keep to a budget.
    pub fn begin<'a>(
        &'a mut self,
        device: &wgpu::Device,
        encoder: &'a mut wgpu::CommandEncoder,
        budget: bool,
    ) -> Recording<'a> {
        let timed = self.each || budget && can_time(device);
        let each = self.each;
        Recording::new(encoder, timed.then(|| self.queries(device)), each)
    }

    /// The queries for a frame that is to be timed.
    fn queries(&mut self, device: &wgpu::Device) -> (&wgpu::QuerySet, u32) {
        let most = if self.each { MAX_PASSES } else { MAX_PASSES_WHOLE };
        let last = self.queries.take().filter(|q| q.most == most);
        let new = || {
            let (ty, count) = (wgpu::QueryType::Timestamp, 2 * most);
            let set = device.create_query_set(&wgpu::QuerySetDescriptor { label: Some("times"), ty, count });
            let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
            Queries { set, resolved: empty(device, "times", 16 * u64::from(most), usage), most }
        };
        let queries = self.queries.insert(last.unwrap_or_else(new));
        (&queries.set, queries.most)
    }

    /// Copies what the queries of a frame have found to where the host may read it; nothing while four are under way.
    pub fn copy(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        spans: Vec<(&'static str, u32)>,
        steps: u32,
    ) {
        let (Some(queries), false) = (&self.queries, spans.is_empty()) else { return };
        let size = queries.resolved.size();
        let Some(parcel) = self.staging.take(device, "times", size) else { return };
        let count = spans.len() as u32;
        encoder.resolve_query_set(&queries.set, 0..2 * count, &queries.resolved, 0);
        encoder.copy_buffer_to_buffer(&queries.resolved, 0, &parcel.staging, 0, 16 * u64::from(count));
        self.under_way.push_back(Timed { parcel, spans, each: self.each, steps });
    }

    /// Asks for what was recorded.
    pub fn ask(&mut self) {
        self.under_way.iter_mut().for_each(|timed| timed.parcel.ask());
    }

    /// Takes in what has arrived; calls `whole` with the steps and the time \[ms\] of each frame that was timed as a whole. A tick
    /// is `period` \[ns\].
    pub fn settle(&mut self, period: f32, mut whole: impl FnMut(u32, f64)) -> Result<()> {
        while let Some(timed) = self.under_way.front() {
            let read = |bytes: &[u8]| -> Vec<[u64; 2]> {
                let one = |k: usize| bytemuck::pod_read_unaligned(&bytes[16 * k..16 * (k + 1)]);
                (0..timed.spans.len()).map(one).collect()
            };
            let Some(stamps) = timed.parcel.open(read)? else { break };
            let Some(timed) = self.under_way.pop_front() else { break };
            let ms = |from: u64, to: u64| to.saturating_sub(from) as f64 * f64::from(period) * 1e-6;
            if timed.each {
                self.passes.clear();
                for ((shader, dispatches), [from, to]) in timed.spans.iter().zip(&stamps) {
                    match self.passes.iter_mut().find(|p| p.shader == *shader) {
                        Some(p) => (p.dispatches, p.ms) = (p.dispatches + dispatches, p.ms + ms(*from, *to)),
                        None => self.passes.push(PassTime { shader, dispatches: *dispatches, ms: ms(*from, *to) }),
                    }
                }
            } else if let (Some([from, _]), Some([_, to])) = (stamps.first(), stamps.last()) {
                self.known = true;
                whole(timed.steps, ms(*from, *to));
            }
            self.staging.put_back(timed.parcel);
        }
        Ok(())
    }
}

/// Whether a device has timestamps.
fn can_time(device: &wgpu::Device) -> bool {
    device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
}

impl Gpu {
    /// Begins or ends timing each pass. False if the device has no timestamps.
    pub fn time_passes(&mut self, on: bool) -> bool {
        self.timing.each = on && can_time(&self.device);
        self.timing.each == on
    }

    /// Times of passes in the last frame that has arrived.
    pub fn pass_times(&self) -> &[PassTime] {
        &self.timing.passes
    }

    /// Whether frames are timed without the host.
    pub fn times_frames(&self) -> bool {
        self.timing.known
    }
}

/// The features of an adapter that the runtime can use: timestamp queries, for [`crate::Stepper::time_passes`] and
/// [`crate::Quality::Budget`]. It needs none of them.
pub fn device_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    adapter.features() & wgpu::Features::TIMESTAMP_QUERY
}
