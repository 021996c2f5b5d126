//! One module a command.

pub mod batch;
pub mod build;
pub mod inspect;
pub mod reconstruct;
pub mod simulate;
pub mod validate;
