//! Twin of shaders/skin.wgsl: where the joints of a cloth put its particles. Speeds follow from where they were put before
//! (`Fabric::lead`), which the shader works out again.

use crate::cloth::{Rows, Skin, skinned};
use crate::number::real::{Real, V3, cast};

/// Where some particles are by the matrices of their joints \[m\].
pub fn run<T: Real>(skin: &Skin, particles: impl Iterator<Item = u32>, matrices: &[Rows]) -> Vec<V3<T>> {
    let matrices: Vec<[[T; 4]; 3]> = matrices.iter().map(|r| r.map(cast)).collect();
    let at = |k: usize| skinned(&matrices, &skin.influences[k * skin.sets..(k + 1) * skin.sets], cast(skin.rest[k]));
    particles.map(|k| at(k as usize)).collect()
}

/// Where points \[m\] are that move as some particles, from where they are at rest.
pub fn points<T: Real>(skin: &Skin, points: &[(u32, [f32; 3])], matrices: &[Rows]) -> Vec<V3<T>> {
    let matrices: Vec<[[T; 4]; 3]> = matrices.iter().map(|r| r.map(cast)).collect();
    let own = |k: usize| &skin.influences[k * skin.sets..(k + 1) * skin.sets];
    points.iter().map(|(k, p)| skinned(&matrices, own(*k as usize), cast(*p))).collect()
}
