//! Effect of a script on a stepper, frame by frame.

use super::Stepper;
use crate::collider::Collider;
use crate::error::Result;
use crate::scene::Script;

impl Script {
    /// Colliders at the end of the frame from `time` to `time + dt` \[s\], with the velocity that takes them there.
    pub fn moved(&self, colliders: &[Collider], time: f64, dt: f64) -> Vec<Collider> {
        let mut colliders = colliders.to_vec();
        for (collider, motion) in colliders.iter_mut().zip(&self.colliders) {
            let Some(motion) = motion else { continue };
            *collider = collider.moved(&motion.at(time), &motion.at(time + dt), dt);
        }
        colliders
    }

    /// Does what happens from `time` to `time + dt` \[s\]; to be called before the stepper's frame of `dt`. Colliders go
    /// to where they are at its end, with the velocity that takes them there. Nothing is uploaded, and no cloth is
    /// woken, where nothing changes.
    pub fn frame(&self, stepper: &mut Stepper, time: f64, dt: f64) -> Result<()> {
        let end = time + dt;
        let colliders = self.moved(&stepper.scene().colliders, time, dt);
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
                let moved = |start: &[f32; 3]| {
                    let to = pose.apply([0, 1, 2].map(|c| start[c] - set.pivot[c]));
                    [0, 1, 2].map(|c| to[c] + set.pivot[c])
                };
                let at: Vec<_> = set.particles.iter().map(|(_, start)| moved(start)).collect();
                stepper.set_pins(set.cloth, &set.indices(), &at)?;
            }
            if released.is_some() {
                stepper.unpin(set.cloth, &set.indices())?;
            }
        }
        for cut in self.cuts.iter().filter(|c| (time..end).contains(&c.time)) {
            let [eye, a, b] = cut.triangle;
            stepper.cut(eye, a, b)?;
        }
        Ok(())
    }
}
