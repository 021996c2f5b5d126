//! Turns a garment mesh into geometry images.
//!
//! The modules are the pipeline, in order: [`import`] reads files into a [`mesh::Mesh`], [`repair`] makes it an
//! oriented manifold, [`component`] tells pieces from accessories, and so on down to the bundle.

pub mod component;
pub mod error;
pub mod halfedge;
pub mod import;
pub mod mesh;
pub mod record;
pub mod repair;
pub mod surface;
mod vec3;

pub use error::{Error, Result};
pub use mesh::Mesh;
