//! Frames of reference that cloths are simulated in.

use super::Stepper;
use crate::error::{Error, Result};
use crate::handle::ClothRef;
use crate::moving_frame::{FrameMotion, Inertia, MovingFrame};
use crate::options::Solver;

impl Stepper {
    /// Simulates a cloth in a frame of reference, which goes to `to` at the end of the next frame that makes a step. For characters: the
    /// frame is that of the hips, say, and of what it does the cloth feels the shares of [`crate::Cloth::inertia`]; 1e5 m from the origin of the
    /// world a cloth behaves as it does near it.
    ///
    /// From the first call on, which puts the frame there at rest, all coordinates of the cloth are those of the frame: its positions,
    /// pins, joints ([`Stepper::set_joints`]: their matrices end in the frame), and the colliders that it meets
    /// (a floor has to be moved against the frame). Gravity and wind stay those of the world, and turn into the frame. To draw, use the
    /// frame as the model matrix ([`MovingFrame::to_world`]). Frames that are not moved rest, as joints do.
    ///
    /// Free particles without forces go straight on in the world to rounding, however the frame moves, at shares of 1. A turn counts the shorter way round.
    /// Damping acts on velocities in the frame; the air is as fast everywhere as at the origin of the frame. Cloths that touch one
    /// another ([`crate::Cloth::contact`]) need equal frames. States ([`Stepper::save`]) do not have the frame: see [`Stepper::moving_frame`].
    ///
    /// One dispatch and 112 bytes of upload in frames in which it accelerates or turns, none else. On the CPU 5 ns per particle.
    /// Wakes the cloth then. Errors, without any change, if there is no such cloth, on numbers that are not finite, on a rotation of
    /// no length, and for [`Solver::Classic`].
    ///
    /// ```
    /// use gimage_runtime::{Flat, MovingFrame, Options, Scene, Stepper};
    ///
    /// let mut cape = Flat::square("cape", 9).cloth()?;
    /// cape.pin(&[0, 8])?;
    /// cape.inertia.linear = 0.3;
    /// let mut scene = Scene::new("a run, far out");
    /// scene.cloths.push(cape);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// for frame in 0..60 {
    ///     let position = [1e5 + 0.1 * f64::from(frame), 0.0, 0.0];
    ///     stepper.set_moving_frame(0, &MovingFrame { position, ..MovingFrame::default() })?;
    ///     stepper.advance(1.0 / 60.0)?;
    /// }
    /// // It has fallen behind the run by its inertia.
    /// assert!(stepper.positions(0).unwrap_or_default()[40][0] < 0.5);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn set_moving_frame(&mut self, cloth: impl Into<ClothRef>, to: &MovingFrame) -> Result<()> {
        let (cloth, to) = (self.carried(cloth.into())?, to.checked()?);
        self.world.move_frame(cloth, to);
        Ok(())
    }

    /// Puts the frame of a cloth elsewhere from the start of the next frame on: the cloth notices nothing. It keeps its coordinates and its
    /// velocities in the frame, and the frame keeps its velocity, turned with it. Costs and errors as [`Stepper::set_moving_frame`].
    pub fn teleport_moving_frame(&mut self, cloth: impl Into<ClothRef>, to: &MovingFrame) -> Result<()> {
        let (cloth, to) = (self.carried(cloth.into())?, to.checked()?);
        let motion = self.world.runs[cloth].moving.map_or(FrameMotion::still(to), |moving| moving.motion.put(to));
        self.world.put_frame(cloth, motion);
        Ok(())
    }

    /// The frame of reference of a cloth and its last motion, for [`Stepper::put_moving_frame`]; none before the first call of
    /// [`Stepper::set_moving_frame`]. Errors if there is no such cloth.
    pub fn moving_frame(&self, cloth: impl Into<ClothRef>) -> Result<Option<FrameMotion>> {
        let cloth = self.world.find(cloth.into())?;
        Ok(self.world.runs[cloth].moving.map(|moving| moving.motion))
    }

    /// Puts the frame of a cloth where it was, with the motion that it had, after [`Stepper::restore`]. Errors as [`Stepper::set_moving_frame`].
    pub fn put_moving_frame(&mut self, cloth: impl Into<ClothRef>, motion: &FrameMotion) -> Result<()> {
        let (cloth, motion) = (self.carried(cloth.into())?, motion.checked()?);
        self.world.put_frame(cloth, motion);
        Ok(())
    }

    /// Sets the shares of its frame's motion that act on a cloth, from the next frame on. Errors for an unknown cloth, and for a share
    /// outside 0 to 1.
    pub fn set_inertia(&mut self, cloth: impl Into<ClothRef>, inertia: Inertia) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        inertia.check()?;
        self.world.scene.cloths[cloth].inertia = inertia;
        Ok(())
    }

    /// The index of a cloth that may have a frame of reference.
    fn carried(&self, cloth: ClothRef) -> Result<usize> {
        let index = self.world.find(cloth)?;
        if self.world.control.options.solver == Solver::Classic {
            let cloth = self.world.scene.cloths[index].name().into();
            return Err(Error::Unfollowed { cloth, problem: "the solver `classic` has no moving frames; use `xpbd`" });
        }
        Ok(index)
    }
}
