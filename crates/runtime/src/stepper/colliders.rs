//! Colliders that change: all of them, their poses, and which cloths meet them.

use super::Stepper;
use crate::collider::Collider;
use crate::error::{Error, Result};
use crate::handle::ClothRef;
use crate::scene::Pose;

impl Stepper {
    /// Replaces all colliders. Costs 80 bytes per collider in the upload of the next frame, for each combination of thickness, friction and
    /// groups of the cloths, and new bindings if their number changes. Wakes the cloths that a changed collider may touch
    /// where it was, where it is, or in between. Poses that [`Stepper::move_collider`] has set since the last frame do not count any
    /// more.
    pub fn set_colliders(&mut self, colliders: Vec<Collider>) -> Result<()> {
        colliders.iter().try_for_each(Collider::check)?;
        self.guarded(|stepper| {
            stepper.world.driven.forget();
            // Those that are alike are met by the same cloths.
            let alike = stepper.world.is_like(&colliders);
            let met = if alike { Vec::new() } else { stepper.met() };
            stepper.world.take_colliders(colliders);
            if !alike {
                stepper.world.watchdog.put();
                stepper.meet(&met);
                stepper.world.reschedule();
            }
            stepper.upload_colliders(alike);
            Ok(())
        })
    }

    /// Moves a collider to a pose, where it is at the end of the next frame. Its velocity \[m/s\] and spin \[rad/s\] are those
    /// that lead there from the pose at the end of the last frame that made a step, the shorter way round, over the host's
    /// time since then: `dt` of the next frame if every frame makes a step. A collider that is not moved before a frame rests in
    /// it. The last pose before a frame counts.
    ///
    /// Of a body that turns by more than half a turn per frame, give the pose in more frames. The same result, by bits, as
    /// [`Stepper::set_colliders`] with [`Collider::moved`]; cheaper, as nothing but the numbers changes. Costs an upload as
    /// [`Stepper::set_colliders`] in each frame in which any collider moves, or comes to rest. Wakes the cloths that it may touch
    /// on its way. Errors if the collider does not exist, and if [`Collider::check`] refuses the pose.
    ///
    /// ```
    /// use gimage_runtime::scene::Pose;
    /// use gimage_runtime::{Collider, Flat, Options, Scene, Shape, Stepper};
    ///
    /// let mut scene = Scene::new("a hand");
    /// scene.cloths.push(Flat::square("cape", 9).cloth()?);
    /// scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.1 }, [0.0; 3]));
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// stepper.move_collider(0, &Pose { position: [0.5, 0.0, 0.0], ..Pose::default() })?;
    /// stepper.advance(0.25)?;
    /// assert_eq!(stepper.scene().colliders[0].velocity, [2.0, 0.0, 0.0]);
    /// stepper.advance(0.25)?;
    /// assert_eq!(stepper.scene().colliders[0].velocity, [0.0; 3]);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn move_collider(&mut self, collider: usize, to: &Pose) -> Result<()> {
        let at = self.to_pose(collider, to)?;
        self.world.driven.go(collider, at, *to);
        Ok(())
    }

    /// Puts a collider at a pose without velocity, from the next frame on, as [`Stepper::move_collider`] does otherwise: cloth that
    /// is inside leaves it, and nothing is swept on the way. A [`Stepper::move_collider`] before the same frame starts from this
    /// pose; so does a host after [`Stepper::restore`].
    pub fn teleport_collider(&mut self, collider: usize, to: &Pose) -> Result<()> {
        self.to_pose(collider, to)?;
        self.world.driven.put(collider, *to);
        self.world.watchdog.put();
        Ok(())
    }

    /// Changes the groups of colliders that a cloth meets ([`crate::Cloth::collision_groups`]), from the next frame on. Costs
    /// as [`Stepper::set_colliders`]; wakes the cloth. Errors if there is no such cloth.
    pub fn set_collision_groups(&mut self, cloth: impl Into<ClothRef>, groups: u32) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        self.guarded(|stepper| {
            let met = stepper.met();
            stepper.world.scene.cloths[cloth].collision_groups = groups;
            stepper.world.watchdog.put();
            stepper.meet(&met);
            stepper.world.wake(cloth);
            stepper.world.reschedule();
            stepper.upload_colliders(false);
            Ok(())
        })
    }

    /// Tells the device what colliders are like now.
    pub(super) fn recoat(&mut self) {
        self.changed();
        self.upload_colliders(false);
    }

    fn upload_colliders(&mut self, alike: bool) {
        self.world.repose(true);
        if let Some(gpu) = &mut self.gpu {
            gpu.set_colliders(&self.world, alike);
        }
    }

    /// The pose of a collider, if it may have another one.
    pub(super) fn to_pose(&self, index: usize, pose: &Pose) -> Result<Pose> {
        let list = &self.world.scene.colliders;
        let collider = list.get(index).ok_or(Error::NoSuch { what: "collider", index, count: list.len() })?;
        collider.moved(pose, pose, 0.0).check()?;
        Ok(collider.pose())
    }

    /// Whether each cloth meets any collider.
    fn met(&self) -> Vec<bool> {
        (0..self.world.runs.len()).map(|cloth| self.world.meets(cloth)).collect()
    }

    /// Decides again what the host left open where a cloth that met no collider meets one now.
    fn meet(&mut self, before: &[bool]) {
        if self.met().iter().zip(before).any(|(now, before)| *now && !before) {
            self.world.decide();
        }
    }
}
