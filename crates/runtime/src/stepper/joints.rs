//! Joints that cloths follow.

use super::Stepper;
use crate::cloth::Rows;
use crate::error::{Error, Result};
use crate::handle::ClothRef;
use crate::options::Solver;

impl Stepper {
    /// Moves the joints of a cloth that follows them ([`crate::Cloth::follow_joints`]) to where they are at the end of the next frame that
    /// makes a step, one matrix per joint, column-major: the transform of the joint to world space times its inverse bind matrix
    /// ([`crate::Skin::matrices`]). Pinned particles, and the skin that [`crate::Cloth::limits`] are distances from, go there in a straight
    /// line over the substeps of the frame. The last matrices before a frame count; joints that are not moved rest. Matrices that are equal
    /// to the last ones cost nothing.
    ///
    /// Linear blend skinning. On the GPU an upload of 96 bytes per joint and one dispatch per frame; on the CPU 30 ns per pinned particle,
    /// and per particle if the cloth has limits. A frame of more than 128 substeps moves in 128 parts at most. Wakes the cloth. Errors if
    /// there is no such cloth or it does not follow joints, on another number of matrices, on a number that is not finite, and for
    /// [`Solver::Classic`]; then nothing has changed.
    ///
    /// ```
    /// use gimage_runtime::{Flat, Influence, Options, Scene, Select, SkinJoint, Stepper};
    ///
    /// let mut cape = Flat::square("cape", 9).cloth()?;
    /// let still = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    /// let spine = SkinJoint { name: "spine".into(), parent: None, inverse_bind: still };
    /// cape.set_skin(vec![spine], &[Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; 81])?;
    /// let top = cape.select(&Select::Texels { piece: None, from: [0, 0], to: [8, 0] })?;
    /// cape.pin(&top)?;
    /// cape.follow_joints(&[still])?;
    /// let mut scene = Scene::new("a walk");
    /// scene.cloths.push(cape);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// for frame in 1..=30 {
    ///     let mut spine = still;
    ///     spine[14] = 0.02 * frame as f32;
    ///     stepper.set_joints(0, &[spine])?;
    ///     stepper.advance(1.0 / 60.0)?;
    /// }
    /// assert!((stepper.positions(0).unwrap_or_default()[0][2] - 0.6).abs() < 1e-6);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn set_joints(&mut self, cloth: impl Into<ClothRef>, matrices: &[[f32; 16]]) -> Result<()> {
        let (cloth, rows) = self.joints(cloth.into(), matrices)?;
        self.world.move_joints(cloth, rows);
        Ok(())
    }

    /// Puts the joints of a cloth somewhere from the start of the next frame on, as if they had been there: as [`Stepper::set_joints`]
    /// otherwise. Pinned particles are there at once; all others stay where they are. For a new animation in another place, with
    /// [`Stepper::teleport`], and after [`Stepper::restore`]: joints are the host's, and no state has them.
    pub fn teleport_joints(&mut self, cloth: impl Into<ClothRef>, matrices: &[[f32; 16]]) -> Result<()> {
        let (cloth, rows) = self.joints(cloth.into(), matrices)?;
        self.world.put_joints(cloth, rows);
        Ok(())
    }

    /// The index of a cloth that follows joints, and their matrices as rows.
    fn joints(&self, cloth: ClothRef, matrices: &[[f32; 16]]) -> Result<(usize, std::sync::Arc<[Rows]>)> {
        let index = self.world.find(cloth)?;
        let of = &self.world.scene.cloths[index];
        let refuse = |problem| Err(Error::Unfollowed { cloth: of.name().into(), problem });
        if self.world.control.options.solver == Solver::Classic {
            return refuse("the solver `classic` has no pass for it; use `xpbd`");
        }
        match of.skin().filter(|_| of.follows_joints()) {
            Some(skin) => Ok((index, skin.rows(matrices)?)),
            None => refuse("call Cloth::follow_joints before the stepper takes it"),
        }
    }

    /// Refuses to put pinned particles elsewhere than joints do.
    pub(super) fn refuse_joined(&self, cloth: usize, particles: impl IntoIterator<Item = u32>) -> Result<()> {
        let Some(joints) = &self.world.runs[cloth].joints else { return Ok(()) };
        let of = &self.world.scene.cloths[cloth];
        let held = |k: &u32| of.particles()[*k as usize].is_pinned() && joints.joined.binary_search(k).is_ok();
        match particles.into_iter().find(held) {
            Some(particle) => Err(Error::Follows { cloth: of.name().into(), particle }),
            None => Ok(()),
        }
    }
}
