//! One module a command.

pub mod batch;
pub mod build;
pub mod character;
pub mod check_crossings;
mod crossed;
mod device;
pub mod doctor;
mod engine;
pub mod export;
mod faults;
pub mod fit_colliders;
pub mod inspect;
pub mod list;
mod png;
pub mod reconstruct;
pub mod render;
mod scene;
pub mod simulate;
pub mod surface;
pub mod validate;
