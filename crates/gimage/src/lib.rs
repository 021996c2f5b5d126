//! Turns a garment mesh into geometry images.
//!
//! The modules are the pipeline, in order: [`import`] reads files into a [`mesh::Mesh`], [`repair`] makes it an
//! oriented manifold, [`component`] tells pieces from accessories, and so on down to the bundle.

pub mod closest;
pub mod component;
mod disjoint;
pub mod error;
pub mod export;
mod frame;
pub mod grid;
pub mod halfedge;
pub mod import;
pub mod mass;
pub mod measure;
pub mod mesh;
pub mod reconstruct;
pub mod record;
pub mod repair;
mod sample;
pub mod springs;
pub mod stretch;
pub mod surface;
pub mod topology;
mod vec3;

pub use error::{Error, Result};
pub use mesh::Mesh;
