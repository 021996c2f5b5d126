//! Frames of reference that cloths are simulated in: where they are, and where they go in the next frame.

use super::stir::is_stirring;
use super::{Action, World};
use crate::moving_frame::{FrameMotion, MovingFrame};
use crate::number::real::cast;

/// The frame of reference of a cloth.
#[derive(Clone, Copy, Debug)]
pub struct Moving {
    /// Where it is, and how it moved in the last frame that made a step.
    pub motion: FrameMotion,
    /// Where the host has it after the next one, if it has moved it.
    next: Option<MovingFrame>,
    /// Where the host had it after the last one, and how much earlier \[s\] that ended: steps do not end where frames of the host do.
    host: MovingFrame,
    behind: f64,
}

impl World {
    /// Moves the frame of a cloth in the next frame that makes a step. The first call puts it there.
    pub fn move_frame(&mut self, cloth: usize, to: MovingFrame) {
        match &mut self.runs[cloth].moving {
            Some(moving) => moving.next = Some(to),
            None => self.put_frame(cloth, FrameMotion::still(to)),
        }
    }

    /// Puts the frame of a cloth somewhere from the start of the next frame on, with a motion that is taken for its last one.
    pub fn put_frame(&mut self, cloth: usize, motion: FrameMotion) {
        self.runs[cloth].moving = Some(Moving { motion, next: None, host: motion.frame, behind: 0.0 });
        self.wake(cloth);
    }

    /// Begins a frame that makes a step, `waited` \[s\] of the host's time after the last one: frames of reference that the host has not moved rest. They
    /// go as far as they are when the last step ends, so that one of constant velocity has it in every frame, whatever the number of steps, and where time is dropped.
    pub fn move_frames(&mut self, waited: f64) {
        let (rest, dt) = (self.control.clock.rest(), self.control.clock.dt_old);
        for cloth in 0..self.runs.len() {
            let inertia = self.scene.cloths[cloth].inertia;
            let Some(moving) = &mut self.runs[cloth].moving else { continue };
            let (to, before) = (moving.next.take().unwrap_or(moving.host), moving.motion);
            let seconds = waited + std::mem::replace(&mut moving.behind, rest) - rest;
            moving.host = to;
            if seconds <= 0.0 {
                continue;
            }
            let to = if rest > 0.0 { before.frame.towards(&to, seconds / (seconds + rest)) } else { to };
            if let Some(impulse) = moving.motion.go(to, seconds, &inertia) {
                if is_stirring(&before, &moving.motion, &inertia, seconds) {
                    self.control.follow.stir();
                }
                self.host.actions.push(Action::Inertia { cloth, numbers: impulse.numbers(dt) });
                self.wake(cloth);
            }
        }
    }

    /// Gravity \[m/s^2\] and wind \[m/s\] in the frame of a cloth.
    pub fn local(&self, cloth: usize) -> [[f64; 3]; 2] {
        let wind = self.scene.wind.as_ref().map_or([0.0; 3], |wind| cast(wind.velocity));
        let gravity = cast(self.scene.gravity);
        match &self.runs[cloth].moving {
            Some(moving) => moving.motion.local(gravity, wind, &self.scene.cloths[cloth].inertia),
            None => [gravity, wind],
        }
    }
}
