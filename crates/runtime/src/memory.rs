//! The memory of a scene, and the share of it that instances of a cloth have in common.

use std::collections::BTreeSet;

/// Bytes of a stepper, as [`crate::Stepper::memory`] counts them.
///
/// Images are the lists that stepping only reads: particle kinds, rest lengths, masses, seams, tethers, compliance, membrane and bending. Cloths
/// of one bundle share them. States are what each cloth has of its own: positions, previous positions, normals, and scratch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Images in the host's memory, each list once.
    pub images: u64,
    /// The same if every cloth had its own lists.
    pub images_unshared: u64,
    /// States in the host's memory.
    pub states: u64,
    /// Images on the device.
    pub device_images: u64,
    /// States on the device.
    pub device_states: u64,
}

/// Counts lists, those that are shared once.
#[derive(Default)]
pub struct Tally {
    seen: BTreeSet<usize>,
    memory: Memory,
}

impl Tally {
    /// Takes in a list that is only read.
    pub fn image<T>(&mut self, list: &[T]) {
        let bytes = size_of_val(list) as u64;
        self.memory.images_unshared += bytes;
        if bytes > 0 && self.seen.insert(list.as_ptr() as usize) {
            self.memory.images += bytes;
        }
    }

    /// Takes in a list of the cloth's own; shared ones count once.
    pub fn state<T>(&mut self, list: &[T]) {
        if !list.is_empty() && self.seen.insert(list.as_ptr() as usize) {
            self.memory.states += size_of_val(list) as u64;
        }
    }

    /// The sum, with the bytes of images and states on the device.
    pub fn with_device(self, [device_images, device_states]: [u64; 2]) -> Memory {
        Memory { device_images, device_states, ..self.memory }
    }
}
