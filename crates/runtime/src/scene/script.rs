//! Scripts: the motion of colliders and pins, and cuts, over time.

use super::Scene;
use super::motion::{Motion, Pose};
use crate::error::Result;
use crate::stepper::Stepper;

/// Particles that are pinned together.
#[derive(Clone, Debug, PartialEq)]
pub struct PinnedSet {
    /// Index of the cloth.
    pub cloth: usize,
    /// The particles and where each is at the start \[m\].
    pub particles: Vec<(usize, [f32; 3])>,
    /// How they move together: turned about `pivot`, then moved by the position. `None` stays.
    pub motion: Option<Motion>,
    /// What they turn about \[m\].
    pub pivot: [f32; 3],
    /// When \[s\] they are let go.
    pub release: Option<f64>,
}

/// A cut along the triangle of an eye and two points that it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// When \[s\].
    pub time: f64,
    /// The triangle's corners \[m\].
    pub triangle: [[f32; 3]; 3],
}

/// Everything that happens. The order within a frame is the order of the fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// The motion of each collider of the scene; `None`, or a list that ends before, stays.
    pub colliders: Vec<Option<Motion>>,
    /// Pinned particles that move or are let go.
    pub pins: Vec<PinnedSet>,
    /// Cuts through all cloths.
    pub cuts: Vec<Cut>,
}

impl Script {
    /// Whether nothing ever happens.
    pub fn is_empty(&self) -> bool {
        self.colliders.iter().all(Option::is_none) && self.pins.is_empty() && self.cuts.is_empty()
    }

    /// Puts colliders where they are at time 0, at rest. To be called before a stepper takes the scene.
    pub fn start(&self, scene: &mut Scene) {
        for (collider, motion) in scene.colliders.iter_mut().zip(&self.colliders) {
            if let Some(motion) = motion {
                let Pose { position, rotation } = motion.at(0.0);
                (collider.center, collider.rotation) = (position, rotation);
            }
        }
    }

    /// Does what happens from `time` to `time + dt` \[s\]; to be called before the stepper's frame of `dt`. Colliders go
    /// to where they are at its end, with the velocity that takes them there. Nothing is uploaded, and no cloth is
    /// woken, where nothing changes.
    pub fn frame(&self, stepper: &mut Stepper, time: f64, dt: f64) -> Result<()> {
        let end = time + dt;
        let mut colliders = stepper.scene().colliders.clone();
        for (collider, motion) in colliders.iter_mut().zip(&self.colliders) {
            let Some(motion) = motion else { continue };
            let pose = motion.at(end);
            (collider.velocity, collider.spin) = motion.at(time).motion_to(&pose, dt);
            (collider.center, collider.rotation) = (pose.position, pose.rotation);
        }
        if colliders != stepper.scene().colliders {
            stepper.set_colliders(colliders)?;
        }
        for set in &self.pins {
            let released = set.release.filter(|r| *r < end);
            if released.is_some_and(|r| r < time) {
                continue;
            }
            let poses = set.motion.as_ref().map(|m| (m.at(time), m.at(end)));
            if let Some((_, pose)) = poses.filter(|(a, b)| a != b || time == 0.0) {
                for (particle, start) in &set.particles {
                    let from = [0, 1, 2].map(|c| start[c] - set.pivot[c]);
                    let to = pose.apply(from);
                    stepper.set_position(set.cloth, *particle, [0, 1, 2].map(|c| to[c] + set.pivot[c]))?;
                }
            }
            if released.is_some() {
                for (particle, _) in &set.particles {
                    stepper.set_pinned(set.cloth, *particle, false)?;
                }
            }
        }
        for cut in self.cuts.iter().filter(|c| (time..end).contains(&c.time)) {
            let [eye, a, b] = cut.triangle;
            stepper.cut(eye, a, b)?;
        }
        Ok(())
    }
}
