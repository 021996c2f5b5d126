//! Twin of shaders/skin.wgsl: where the joints of a cloth put its particles. Speeds follow from where they were put before
//! (`Fabric::lead`), which the shader works out again.

use crate::cloth::{Poses, Skin};
use crate::number::real::{Real, V3};

/// Where some particles are by the poses of their joints \[m\].
pub fn run<T: Real>(skin: &Skin, particles: impl Iterator<Item = u32>, poses: &Poses<T>) -> Vec<V3<T>> {
    particles.map(|k| skin.at(poses, k as usize)).collect()
}

/// Where points \[m\] are that move as some particles, from where they are at rest.
pub fn points<T: Real>(skin: &Skin, points: &[(u32, [f32; 3])], poses: &Poses<T>) -> Vec<V3<T>> {
    points.iter().map(|(k, p)| skin.point_at(poses, *k as usize, *p)).collect()
}
