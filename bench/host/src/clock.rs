//! The clock of a device: the time that it works on a frame, without what the host adds.

use gimage_runtime::wgpu;

/// Bytes of two timestamps.
const BYTES: u64 = 16;

/// Two timestamps, around the work of a frame.
pub struct Clock {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// Length of a tick \[ns\].
    period: f32,
}

impl Clock {
    /// Features that a device has to have for it.
    pub const FEATURES: wgpu::Features =
        wgpu::Features::TIMESTAMP_QUERY.union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

    /// The clock of a device, if it has one.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        device.features().contains(Self::FEATURES).then(|| {
            let buffer = |usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("clock"),
                    size: BYTES,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let (label, ty) = (Some("clock"), wgpu::QueryType::Timestamp);
            Clock {
                set: device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count: 2 }),
                resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                staging: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
                period: queue.get_timestamp_period(),
            }
        })
    }

    /// Notes the time before the work that is recorded next.
    pub fn begin(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.write_timestamp(&self.set, 0);
    }

    /// Notes the time after the work that was recorded.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.write_timestamp(&self.set, 1);
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES);
    }

    /// Milliseconds between both in the last frame that was submitted, waited for; none from a lost device.
    pub fn ms(&self, device: &wgpu::Device) -> Option<f64> {
        self.staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        let stamps = {
            let bytes = self.staging.slice(..).get_mapped_range().ok()?;
            [0, 8].map(|k| u64::from_le_bytes(std::array::from_fn(|i| bytes[k + i])))
        };
        self.staging.unmap();
        Some(stamps[1].saturating_sub(stamps[0]) as f64 * f64::from(self.period) * 1e-6)
    }
}
