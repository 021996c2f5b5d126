//! The twin in f64, to measure what f32 and a coarse step cost.

use crate::collider::Collider;
use crate::cpu::body::Body;
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::options::Options;
use crate::scene::Scene;
use crate::world::World;

/// Steps a scene in f64 on the caller's thread. The passes, their order and the settings are those of the stepper.
pub struct Reference {
    world: World,
    bodies: Vec<Body<f64>>,
    threads: Threads,
}

/// Positions now and one step before, by particle.
type NowAndBefore<'a> = (&'a [[f64; 4]], &'a [[f64; 4]]);

impl Reference {
    /// Takes a scene over; `options.backend` and `threads` have no meaning here. Errors on settings out of range.
    pub fn new(scene: Scene, options: Options) -> Result<Self> {
        let world = World::new(scene, options)?;
        Ok(Reference { bodies: world.bodies(), world, threads: Threads::new(1)? })
    }

    /// The colliders as they are now.
    pub fn colliders(&self) -> &[Collider] {
        &self.world.scene.colliders
    }

    /// Replaces all colliders by as many others. Errors on numbers out of range.
    pub fn set_colliders(&mut self, colliders: Vec<Collider>) -> Result<()> {
        colliders.iter().try_for_each(Collider::check)?;
        self.world.scene.colliders = colliders;
        self.world.reschedule();
        Ok(())
    }

    /// Makes `steps` steps of [`Options::step`] / [`Options::substeps`], then normals.
    pub fn step(&mut self, steps: u32) {
        self.world.run(&mut self.bodies, &self.threads, steps);
    }

    /// Positions now and one step before, as [`crate::Stepper::positions`]. Errors where there is no such cloth.
    pub fn positions(&self, cloth: usize) -> Result<NowAndBefore<'_>> {
        let body = self.bodies.get(cloth);
        let missing = Error::NoSuch { what: "cloth", index: cloth, count: self.bodies.len() };
        body.map(|b| (b.now(), b.before())).ok_or(missing)
    }
}
