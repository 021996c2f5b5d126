//! Shared types and helpers of the stages: meshes, surfaces and images, and the geometry and graphs they are worked on with.

pub(crate) mod apart;
pub mod closest;
pub(crate) mod decimate;
pub(crate) mod frame;
pub(crate) mod graph;
pub mod grid;
pub mod halfedge;
pub(crate) mod joints;
pub(crate) mod least_squares;
pub(crate) mod locate;
pub(crate) mod memory;
pub mod mesh;
pub(crate) mod order;
pub(crate) mod rebuild;
pub(crate) mod scatter;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod stray;
pub mod surface;
pub mod topology;
pub(crate) mod vec3;
pub(crate) mod words;
