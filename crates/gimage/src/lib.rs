//! Turns a garment mesh into geometry images.
//!
//! [`pipeline::build`] turns a file into a bundle. [`stage`] has what it is made of, in order.

mod base;
pub mod error;
pub mod options;
pub mod pipeline;
pub mod progress;
pub mod record;
pub mod report;
pub mod stage;

pub use base::{closest, grid, halfedge, mesh, surface, topology};
pub use stage::assemble::{mass, pins, springs};
pub use stage::image::{judge, ladder};
pub use stage::measure::stretch;
pub use stage::{component, export, gate, import, measure, reconstruct, repair};

pub use error::{Error, Result};
pub use mesh::Mesh;
