//! Cloths that come and go while others keep moving.

use std::sync::Arc;

use super::follow::Joints;
use super::images::Images;
use super::{ClothRun, World};
use crate::choose::{Hold, Settings};
use crate::cloth::Cloth;
use crate::collider::Collider;
use crate::cpu::body::Body;
use crate::error::{Error, Result};
use crate::handle::{ClothHandle, ClothRef, follow};
use crate::limits::{self, Warning};
use crate::number::real::Real;
use crate::passes::has_levels;
use crate::quality::Quality;
use crate::scene::Scene;

/// A cloth that has left, and its places on the device.
pub struct Left {
    /// Its index.
    pub index: usize,
    pub cloth: Cloth,
    /// Its arena and its place there, by index; the arena is gone if it is empty now.
    pub place: Option<(usize, usize)>,
    /// Whether the list of coats is another one now.
    pub recoated: bool,
}

/// Prepares a cloth for the solver. Images that are known are shared.
pub(super) fn prepare<'a>(
    cloth: &mut Cloth,
    options: &Settings,
    hold: Hold,
    (colliders, known): (&[Collider], impl Iterator<Item = &'a Arc<Images>>),
) -> Result<ClothRun> {
    let mut warnings = Vec::new();
    // It may come from a stepper that has cut it.
    cloth.close();
    cloth.untethered = false;
    let given = cloth.clone();
    let most = limits::prepare(cloth, options, hold.most, &mut warnings)?;
    let meets = cloth.body().is_some() || colliders.iter().any(|c| c.is_met(cloth.met_groups()));
    let left_out = meets && has_levels(cloth, options);
    warnings.extend(left_out.then(|| Warning::PyramidOnColliders { cloth: cloth.name().into() }));
    let mut run = ClothRun::new(Images::of(cloth, given, Hold { most, ..hold }, known));
    run.warnings = warnings;
    run.joints = Joints::of(cloth);
    Ok(run)
}

impl World {
    /// The index of the cloth that a call is about.
    pub fn find(&self, cloth: ClothRef) -> Result<usize> {
        let count = self.handles.len();
        match cloth {
            ClothRef::Index(index) if index < count => Ok(index),
            ClothRef::Index(index) => Err(Error::NoSuch { what: "cloth", index, count }),
            ClothRef::Handle(handle) => self.handles.binary_search(&handle).map_err(|_| Error::NoCloth(handle)),
        }
    }

    /// Takes in a cloth, behind all others, which it leaves as they are; whether the list of coats is another one now. Errors
    /// change nothing.
    pub fn join(&mut self, cloth: Cloth) -> Result<bool> {
        cloth.check()?;
        let before = self.control.clone();
        let (colliders, gravity) = (self.scene.colliders.clone(), self.scene.gravity);
        let mut alone = Scene { colliders, gravity, ..Scene::new("") };
        alone.cloths.push(cloth);
        let rounds_change = self.control.join(&alone);
        let hold = self.control.hold(self.runs.len());
        let known = self.runs.iter().filter_map(|run| run.images.as_ref()).chain(&self.spare_images);
        let run = match prepare(&mut alone.cloths[0], &self.control.options, hold, (&self.scene.colliders, known)) {
            Ok(run) => run,
            Err(error) => {
                self.control = before;
                return Err(error);
            }
        };
        let index = self.runs.len();
        self.scene.cloths.append(&mut alone.cloths);
        self.runs.push(run);
        self.find_place(index);
        self.handles.push(ClothHandle::fresh());
        self.host.join(index);
        self.watchdog.join(self.control.clock.time);
        self.raise();
        let recoated = self.recoat();
        if rounds_change {
            self.reschedule();
        } else {
            self.runs[index].schedule = self.schedule(index, &self.control.options);
            self.control.round = self.cost_of_round();
            self.fuse();
        }
        Ok(recoated)
    }

    /// Lets a cloth go; the indices of those behind it fall by one.
    pub fn leave(&mut self, index: usize) -> Left {
        self.wake_beside(index);
        self.safe.iter_mut().for_each(|safe| safe.leave(index));
        self.tangles.leave(index);
        let place = self.leave_place(index);
        self.arenas.iter_mut().flat_map(|list| &mut list.cloths).for_each(|cloth| _ = follow(cloth, index));
        let cloth = self.scene.cloths.remove(index);
        self.runs.remove(index);
        self.handles.remove(index);
        self.host.leave(index);
        self.watchdog.leave(index);
        let rounds_change = self.control.leave(index);
        let (asked, quality) = (self.control.options.given().substeps, self.control.options.quality);
        if let (Some(_), Some(asked), Quality::Fixed) = (self.host.raised.take(), asked, quality) {
            self.control.set_substeps(asked);
        }
        self.raise();
        let recoated = self.recoat();
        if rounds_change {
            self.reschedule();
        } else {
            self.control.round = self.cost_of_round();
        }
        Left { index, cloth, place, recoated }
    }

    /// Takes a cloth out of its arena, and the arena away if it is empty then. Returns the arena and the place of the cloth there.
    pub(super) fn leave_arena(&mut self, index: usize) -> Option<(usize, usize)> {
        let mut arenas = self.arenas.iter().enumerate();
        let place = arenas.find_map(|(arena, list)| Some((arena, list.cloths.iter().position(|c| *c == index)?)));
        if let Some((arena, member)) = place {
            self.arenas[arena].cloths.remove(member);
            self.arenas[arena].slots.remove(member);
        }
        self.arenas.retain(|list| !list.cloths.is_empty());
        place
    }

    /// A cloth at its start on the CPU.
    pub fn body<T: Real>(&self, index: usize) -> Body<T> {
        let (cloth, run) = (&self.scene.cloths[index], &self.runs[index]);
        let mut body = Body::new(cloth, &run.tethers, &self.control.options, self.control.clock.dt_old);
        if let Some(joints) = &run.joints {
            body.join(&joints.joined);
            body.lead(cloth, &joints.joined, joints.now(), T::of(0.0));
        }
        body
    }

    /// The same, with the images of the first of the other `bodies` that is an instance of the same cloth.
    pub fn body_beside<T: Real>(&self, index: usize, bodies: &[Body<T>]) -> Body<T> {
        let mut body = self.body(index);
        let mut others = bodies.iter().zip(&self.runs).enumerate().filter(|(other, _)| *other != index);
        let instance = |(_, (b, run)): &(usize, (&Body<T>, &ClothRun))| {
            b.count() == body.count() && !b.is_cut() && run.is_instance_of(&self.runs[index])
        };
        if let Some((_, (other, _))) = others.find(instance) {
            body.share(other);
        }
        body
    }
}
