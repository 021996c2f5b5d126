//! Turns a garment mesh into geometry images.
//!
//! The modules are the pipeline, in order: [`import`] reads files into a [`mesh::Mesh`], [`repair`] makes it an
//! oriented manifold, [`component`] tells pieces from accessories, and so on down to the bundle.

mod accessory;
mod assemble;
mod attributes;
mod bend;
mod border;
mod budget;
pub mod closest;
pub mod component;
mod cut;
mod decimate;
mod disk;
pub mod error;
pub mod export;
mod facing;
mod fit;
mod frame;
pub mod gate;
mod graph;
pub mod grid;
mod grow;
pub mod halfedge;
pub mod import;
pub mod judge;
pub mod ladder;
mod layout;
mod locate;
pub mod mass;
pub mod measure;
pub mod mesh;
mod normal;
pub mod options;
mod order;
mod parameterize;
mod piece;
pub mod pins;
pub mod pipeline;
pub mod progress;
pub mod reconstruct;
pub mod record;
pub mod repair;
pub mod report;
mod resample;
mod sample;
mod seal;
#[cfg(test)]
mod shapes;
mod split;
pub mod springs;
pub mod stretch;
pub mod surface;
mod symmetry;
pub mod topology;
mod transfer;
mod vec3;
mod words;

pub use error::{Error, Result};
pub use mesh::Mesh;
