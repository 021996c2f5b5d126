//! Compiling pipelines before a game needs them.

use super::Stepper;
use crate::cloth::Cloth;
use crate::error::Result;
use crate::gpu::{Ahead, Preparation};
use crate::options::Options;
use crate::scene::Scene;

impl Stepper {
    /// The pipelines that frames of a scene run on this stepper's device under some settings, and those of calls that are to come, as far as
    /// they are not compiled. The scene is what this stepper's may become, whose cloths are known by their names and where they began, or that of
    /// another stepper ([`Stepper::another`]). [`Stepper::new`] compiles what the frames of its own scene run; the rest is compiled by the first call
    /// or frame that needs it, some milliseconds each, unless it was prepared.
    ///
    /// `prepare(stepper.scene(), stepper.options(), Ahead::ALL)` is all that this scene can come to need but for other wind, colliders,
    /// settings or cloths: those are put into a copy of the scene or of the options. Compiles nothing itself:
    /// [`Preparation::run`] does, on any thread. None are left where the CPU steps. Costs as much as [`Stepper::on_cpu`] of that scene.
    /// Errors on a scene or settings that a stepper refuses.
    ///
    /// ```no_run
    /// # use gimage_runtime::{Ahead, Stepper, Wind, WindForce};
    /// # fn prepare(stepper: &Stepper) -> Result<(), gimage_runtime::Error> {
    /// let mut later = stepper.scene().clone();
    /// let force = WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.5 };
    /// later.wind = Some(Wind { velocity: [3.0, 0.0, 0.0], gust: 0.3, gust_size: 1.0, force });
    /// let preparation = stepper.prepare(&later, stepper.options(), &[Ahead::Cuts, Ahead::Picks])?;
    /// std::thread::spawn(|| preparation.run());
    /// # Ok(())
    /// # }
    /// ```
    pub fn prepare(&self, scene: &Scene, options: &Options, ahead: &[Ahead]) -> Result<Preparation> {
        let Some(gpu) = self.gpu.as_ref().filter(|_| self.cpu.is_none()) else { return Ok(Preparation::none()) };
        let later = self.world.ahead(scene, options, ahead.contains(&Ahead::Pins))?;
        let cut = self.world.scene.cloths.iter().any(Cloth::is_cut);
        Ok(gpu.prepare_for(later, ahead, cut))
    }
}
