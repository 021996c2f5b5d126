//! Steps garments of geometry images as cloth.

mod cloth;
mod collider;
mod error;
pub mod scene;
mod wind;

pub use cloth::{Cloth, Flat, Grid, Mass, Particle, Parts, Rest};
pub use collider::{Collider, Shape};
pub use error::{Error, Result};
pub use scene::Scene;
pub use wind::{Wind, WindForce};
