//! Turns a garment mesh into geometry images.
//!
//! The modules are the pipeline, in order: [`import`] reads files into a [`mesh::Mesh`], [`repair`] makes it an
//! oriented manifold, [`component`] tells pieces from accessories, and so on down to the bundle.

pub mod component;
mod border;
mod cut;
mod decimate;
mod disk;
pub mod error;
mod graph;
mod grow;
pub mod fit;
pub mod halfedge;
pub mod import;
mod layout;
pub mod mesh;
pub mod parameterize;
pub mod record;
pub mod repair;
pub mod piece;
mod resample;
pub mod surface;
mod transfer;
mod vec3;

pub use error::{Error, Result};
pub use mesh::Mesh;
