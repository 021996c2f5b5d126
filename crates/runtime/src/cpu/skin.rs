//! Twin of shaders/skin.wgsl: where the joints of a cloth put its particles.

use crate::cloth::{Rows, Skin, skinned};
use crate::number::real::{Real, V3, cast, scale, sub};

/// Where some particles are to be at the end of a frame \[m\], and how fast each gets there \[m/s\]: from where `from` puts it, if that is
/// given, `rate` \[1/s\] being one over the length of the frame.
pub fn run<T: Real>(
    skin: &Skin,
    particles: &[u32],
    (from, to): (Option<&[Rows]>, &[Rows]),
    rate: T,
) -> Vec<[V3<T>; 2]> {
    let list = |rows: &[Rows]| -> Vec<[[T; 4]; 3]> { rows.iter().map(|r| r.map(cast)).collect() };
    let (from, to) = (from.map(list), list(to));
    let at = |matrices: &[[[T; 4]; 3]], k: usize| {
        skinned(matrices, &skin.influences[k * skin.sets..(k + 1) * skin.sets], cast(skin.rest[k]))
    };
    let one = |k: &u32| {
        let end = at(&to, *k as usize);
        let speed = |from: &Vec<_>| scale(sub(end, at(from, *k as usize)), rate);
        [end, from.as_ref().map_or([T::of(0.0); 3], speed)]
    };
    particles.iter().map(one).collect()
}
