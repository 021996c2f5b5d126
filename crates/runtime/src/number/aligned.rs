//! Lists of numbers that begin on a cache line, so that whole blocks of lanes do too.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};

use super::lanes::LANES;
use super::real::Real;

/// A block of numbers on whole cache lines.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Single([f32; LANES]);

/// The same in double precision.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Double([f64; LANES]);

/// A list of fixed length.
#[derive(Clone, Debug)]
pub struct Aligned<T: Real> {
    blocks: Vec<T::Block>,
    len: usize,
}

impl<T: Real> Aligned<T> {
    /// `len` zeros.
    pub fn zeros(len: usize) -> Self {
        Aligned { blocks: vec![T::Block::zeroed(); len.div_ceil(LANES)], len }
    }
}

impl<T: Real> Default for Aligned<T> {
    fn default() -> Self {
        Aligned::zeros(0)
    }
}

impl<T: Real> Deref for Aligned<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &cast_slice(&self.blocks)[..self.len]
    }
}

impl<T: Real> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut cast_slice_mut(&mut self.blocks)[..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_begin_on_a_cache_line_and_have_their_length() {
        for len in [0, 1, 16, 33] {
            let (mut a, b) = (Aligned::<f32>::zeros(len), Aligned::<f64>::zeros(len));
            assert_eq!((a.len(), b.len()), (len, len));
            assert!(a.iter().all(|x| *x == 0.0));
            assert_eq!([a.as_ptr().align_offset(64), b.as_ptr().align_offset(64)], [0, 0]);
            a.fill(2.0);
            assert_eq!(a.clone().iter().sum::<f32>(), 2.0 * len as f32);
        }
    }
}
