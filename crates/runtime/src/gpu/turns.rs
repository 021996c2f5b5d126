//! Tiles write positions to other buffers than they read, which then change places.

use super::buffers::ClothBuffers;
use crate::shaders::{Slot, Source};

/// Slots that tiles read, and the slots they write instead.
pub(super) const TURNS: [(Slot, Slot); 4] =
    [(Slot::Now, Slot::Next), (Slot::Before, Slot::Passed), (Slot::Lost, Slot::Losing), (Slot::Sums, Slot::Summing)];

/// The slot that holds the contents of `slot` after the turns.
pub(super) fn lies(turned: [bool; 4], slot: Slot) -> Slot {
    let turn = TURNS.iter().zip(turned).find(|((a, b), turned)| *turned && (*a == slot || *b == slot));
    turn.map_or(slot, |((a, b), _)| if *a == slot { *b } else { *a })
}

/// Which of them lie in the other buffers after a dispatch.
pub(super) fn turned(before: [bool; 4], source: &Source) -> [bool; 4] {
    std::array::from_fn(|n| before[n] != source.binds(TURNS[n].1))
}

impl ClothBuffers {
    /// Notes which buffers have changed places after a dispatch of tiles.
    pub(super) fn turn(&mut self, source: &Source) {
        self.turned = turned(self.turned, source);
    }

    /// Brings positions back to where hosts look for them. Nothing goes on from the multipliers of a frame.
    pub(super) fn turn_back(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let places = [Some(&self.now), Some(&self.before), self.others.get(&Slot::Lost)];
        for ((to, (_, slot)), turned) in places.into_iter().zip(TURNS).zip(std::mem::take(&mut self.turned)) {
            if let (Some(to), Some(from), true) = (to, self.others.get(&slot), turned) {
                encoder.copy_buffer_to_buffer(&from.buffer, from.offset, &to.buffer, to.offset, to.size);
            }
        }
    }
}
