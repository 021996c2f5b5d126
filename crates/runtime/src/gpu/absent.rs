//! The GPU backend of a build without the feature `gpu`: a type without values, so that no call of it can happen.

use crate::bounds::Bounds;
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::error::Result;
use crate::world::World;

/// Stands for the device's side of a stepper, which never has one.
pub enum Gpu {}

impl Gpu {
    pub fn open(&mut self, _: &World) {
        match *self {}
    }

    pub fn set_colliders(&mut self, _: &World, _: bool) {
        match *self {}
    }

    pub fn renew(&mut self, _: &World, _: usize) {
        match *self {}
    }

    pub fn upload_one(&mut self, _: usize, _: &Body<f32>, _: &Threads) {
        match *self {}
    }

    pub fn bounds(&self, _: &World, _: usize) -> Option<Bounds> {
        match *self {}
    }

    pub fn forget_indices(&mut self, _: usize) {
        match *self {}
    }

    pub fn forget_bounds(&mut self, _: usize) {
        match *self {}
    }

    pub fn bytes(&self) -> [u64; 2] {
        match *self {}
    }

    pub fn times_frames(&self) -> bool {
        match *self {}
    }

    pub fn settle(&mut self, _: &mut World) -> Result<()> {
        match *self {}
    }
}
