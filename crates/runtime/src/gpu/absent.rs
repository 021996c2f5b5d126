//! The GPU backend of a build without the feature `gpu`: a type without values, so that no call of it can happen.

use crate::error::Result;
use crate::world::World;

/// Stands for the device's side of a stepper, which never has one.
pub enum Gpu {}

impl Gpu {
    pub fn open(&mut self, _: &World) {
        match *self {}
    }

    pub fn set_colliders(&mut self, _: &World) {
        match *self {}
    }

    pub fn set_inverse_mass(&self, _: usize, _: usize, _: f32) {
        match *self {}
    }

    pub fn set_position(&self, _: usize, _: usize, _: [f32; 3]) {
        match *self {}
    }

    pub fn settle(&mut self, _: &mut World) -> Result<()> {
        match *self {}
    }
}
