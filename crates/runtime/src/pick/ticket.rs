//! The search on the GPU, whose answer comes later.

use super::{Hit, place};
use crate::error::{Error, Result};
use crate::gpu::{Pending, bytes, is_lost};
#[cfg(not(target_family = "wasm"))]
use crate::gpu::{block_on, guard};

/// The answer to [`crate::Stepper::record_pick`].
pub struct PickTicket(pub(crate) Answer);

pub(crate) enum Answer {
    Known(Option<Hit>),
    Pending(Pending),
}

impl PickTicket {
    /// The buffer to map for reading once the encoder is submitted; its bytes are for [`PickTicket::decode`]. `None` on
    /// the CPU backend, where the answer is known.
    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        match &self.0 {
            Answer::Known(_) => None,
            Answer::Pending(pending) => Some(&pending.staging),
        }
    }

    /// The answer in the bytes of the buffer; of the nearest cloth, the first of equals. On the CPU backend the bytes
    /// have no meaning.
    pub fn decode(&self, bytes: &[u8]) -> Option<Hit> {
        let pending = match &self.0 {
            Answer::Known(hit) => return *hit,
            Answer::Pending(pending) => pending,
        };
        let words: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&bytes[..bytes.len() / 64 * 64]);
        let each = words.chunks_exact(4).zip(&pending.grids).enumerate();
        let hits = each.filter(|(_, (found, _))| found[0][0] != u32::MAX).map(|(cloth, (found, grids))| {
            let [distance, code, v, w] = found[0];
            let hit = place(grids, code, f32::from_bits(distance), [v, w].map(f32::from_bits));
            let corner = |n: usize| [0, 1, 2].map(|c| f32::from_bits(found[n + 1][c]));
            let particles = [found[1][3], found[2][3], found[3][3]];
            Hit { cloth, handle: pending.handles.get(cloth).copied(), particles, corners: [0, 1, 2].map(corner), ..hit }
        });
        hits.reduce(|a, b| if b.distance < a.distance { b } else { a })
    }

    /// Waits for the answer. The encoder must have been submitted; a game should rather map [`PickTicket::buffer`], and a page in a
    /// browser awaits [`PickTicket::answer`].
    #[cfg(not(target_family = "wasm"))]
    pub fn wait(&self, device: &wgpu::Device) -> Result<Option<Hit>> {
        guard(device, || block_on(device, self.answer(device)))
    }

    /// The answer without waiting, as [`crate::read_back_async`]. The encoder must have been submitted. An error while another answer of the
    /// same ticket is under way.
    pub async fn answer(&self, device: &wgpu::Device) -> Result<Option<Hit>> {
        match &self.0 {
            Answer::Known(hit) => Ok(*hit),
            Answer::Pending(_) if is_lost(device) => Err(Error::DeviceLost),
            Answer::Pending(pending) => bytes(device, &pending.staging, |bytes| self.decode(bytes)).await,
        }
    }
}
