//! The bundle.
mod error;
pub use error::Error;
