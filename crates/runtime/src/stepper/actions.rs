//! User actions: cuts and transforms.

use super::Stepper;
use crate::cloth::Cloth;
use crate::error::{Result, check};
use crate::handle::ClothRef;
use crate::scene::Pose;
use crate::world::Action;

impl Stepper {
    /// Cuts every cloth by the triangle from the eye to the two ends of a stroke \[m\]; it takes effect at the start of
    /// the next frame. Triangles of cloth that the triangle meets, or comes nearer to than 1e-6 of the distances in
    /// play, are taken away ([`Stepper::holes`]), and their springs get the rest length 0: responsiveness 0 at both
    /// ends. Duplicates of a seam point lie at one place, so both sides of a seam are cut. Cloth cut right through falls
    /// apart; parts that still have a particle in common hang together by it. A spring that is not an edge of a triangle is
    /// not cut.
    ///
    /// Tethers ([`crate::Options::tethers`]) stay as they are where the shortest way to the pin is whole, up to the cone of
    /// 45 degrees behind the end of a cut; there, and behind the cut, they get the shortest way that is left to a pin of
    /// the same group of neighbouring pins, up to 1 % long by the rule of [`gimage_bundle::tethers`], and up to 8 % where
    /// the ways to neighbouring pins lie side by side. A particle with no remaining path to a pin loses its tether. Only the pins of the
    /// start count: a released pin holds nothing, and a new pin holds by springs alone.
    ///
    /// On the GPU it takes two dispatches per cloth, and a third where lengths are limited on coarser grids
    /// ([`crate::Options::pyramid`]), without a read-back, and seven for tethers, or up to 133 on a software adapter, which ends
    /// loops early. Tethers follow ways of up to twice as many particles as the longer side has (four times for several grids); longer
    /// ways end. Both backends look at what is behind the cut alone. A cut counts for every cloth, also one that it misses. The first cut gives every cloth a list of holes and, where rest lengths
    /// were constants, an image of them: 20 bytes per texel; and 16 bytes a tether (12 on the CPU), 4 more a texel, with seams 8;
    /// 11 more with coarser grids. Wakes every cloth. Errors on a number that is not finite.
    pub fn cut(&mut self, eye: [f32; 3], a: [f32; 3], b: [f32; 3]) -> Result<()> {
        for x in [eye, a, b].as_flattened() {
            check("a corner of a cut [m]", f64::from(*x), "finite", |_| true)?;
        }
        self.guarded(|stepper| {
            stepper.open();
            Ok(())
        })?;
        self.changed();
        self.world.host.actions.push(Action::Cut { corners: [eye, a, b], spared: Vec::new() });
        Ok(())
    }

    /// Makes room for cuts.
    fn open(&mut self) {
        self.world.scene.cloths.iter_mut().for_each(Cloth::open);
        if let Some((bodies, _)) = &mut self.cpu {
            let cloths = self.world.scene.cloths.iter().zip(&self.world.runs);
            bodies.iter_mut().zip(cloths).for_each(|(body, (cloth, run))| body.open(cloth, &run.tethers));
        }
        if let Some(gpu) = &mut self.gpu {
            gpu.open(&self.world);
            (0..self.world.runs.len()).for_each(|cloth| gpu.forget_indices(cloth));
        }
    }

    /// Moves particles of a cloth, and their seam duplicates, by a matrix of four columns (of which the last is the
    /// translation \[m\], as in WGSL), at the start of the next frame. Previous positions move alike, so velocities
    /// turn with them and pinned particles stay at rest. Four bytes of upload a particle and one dispatch. Wakes the
    /// cloth. Errors if the cloth has no particle of an index, on a number that is not finite, and on a last row that is not
    /// 0, 0, 0, 1.
    pub fn transform(&mut self, cloth: impl Into<ClothRef>, particles: &[usize], matrix: [[f32; 4]; 4]) -> Result<()> {
        for (column, last) in matrix.iter().zip([0.0, 0.0, 0.0, 1.0]) {
            column.iter().try_for_each(|x| check("an element of a matrix", f64::from(*x), "finite", |_| true))?;
            check("the last row of a matrix", column[3].into(), "0, 0, 0, 1", |x| x == last)?;
        }
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        let index = |k: &usize| u32::try_from(*k).unwrap_or(u32::MAX);
        let chosen = of.with_duplicates(&particles.iter().map(index).collect::<Vec<_>>())?;
        let chosen: Vec<u32> = chosen.into_iter().map(|[k, _]| k).collect();
        if !chosen.is_empty() {
            self.world.wake(cloth);
            self.world.wake_beside(cloth);
            self.world.host.actions.push(Action::Transform { cloth, chosen, matrix });
        }
        Ok(())
    }

    /// Moves a whole cloth by a rigid transform, a turn about the origin and then a shift, at the start of the next frame, without
    /// stirring it: previous positions move alike, so that velocities turn with the cloth, springs keep their lengths to
    /// rounding, and what was at rest stays so. Pins move too, the targets of [`Cloth::limits`], and the
    /// joints that the cloth follows, until [`Stepper::set_joints`] moves them on. Colliders do not: move them with
    /// [`Stepper::teleport_collider`]; a surface that follows no joints ([`Cloth::set_body`]) stays too. Positions are f32, so velocities far from the
    /// origin are coarse: 1e-3 m/s at 30 m in steps of 2 ms.
    ///
    /// Four bytes of upload per particle and one dispatch. Wakes the cloth. Errors if there is no such cloth, on numbers that
    /// are not finite, and on a rotation of no length; any other is made a unit quaternion.
    ///
    /// ```
    /// use gimage_runtime::scene::{Pose, about};
    /// use gimage_runtime::{Flat, Options, Scene, Stepper};
    ///
    /// let mut scene = Scene::new("portal");
    /// scene.cloths.push(Flat::square("cape", 9).cloth()?);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// stepper.advance(0.1)?;
    /// stepper.teleport(0, &Pose { position: [10.0, 0.0, 3.0], rotation: about([0.0, 1.0, 0.0], 1.57) })?;
    /// stepper.advance(0.1)?;
    /// assert!(stepper.positions(0).unwrap_or_default()[0][0] > 9.0);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn teleport(&mut self, cloth: impl Into<ClothRef>, by: &Pose) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        let by = by.checked()?;
        let chosen: Vec<u32> = (0..of.len() as u32).filter(|k| of.particles()[*k as usize].exists()).collect();
        let limited = (of.limits.is_some() || of.backstops.is_some()) && !of.follows_joints();
        self.forget_bounds(cloth);
        self.world.wake(cloth);
        self.world.wake_beside(cloth);
        let run = &mut self.world.runs[cloth];
        run.home = by.after(&run.home);
        self.world.host.actions.push(Action::Transform { cloth, chosen, matrix: by.columns() });
        self.world.teleport_joints(cloth, &by.columns());
        if limited {
            let aim = self.world.aim(cloth);
            self.world.host.actions.push(aim);
        }
        Ok(())
    }
}
