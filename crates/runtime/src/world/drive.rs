//! Colliders that the host moves by poses: their velocities, from the pose before and the time in between.

use super::World;
use crate::collider::Collider;
use crate::scene::Pose;

/// Where the host moves colliders, and since when they were where they are.
#[derive(Default)]
pub struct Drive {
    /// By index, one each, in the order of the calls.
    moves: Vec<Move>,
    /// The host's time \[s\] since the last frame that made a step.
    waited: f64,
    /// By how much time \[s\] colliders that move were taken back in the last frame ([`World::solids`]).
    pub lag: f64,
}

/// The way of one collider from the last frame that made a step to the next one.
struct Move {
    collider: usize,
    from: Pose,
    to: Pose,
    /// [`Drive::waited`] when it was at `from`.
    since: f64,
}

impl Drive {
    /// Moves a collider, at `at` until now, to a pose.
    pub fn go(&mut self, collider: usize, at: Pose, to: Pose) {
        match self.moves.iter_mut().find(|m| m.collider == collider) {
            Some(known) => known.to = to,
            None => self.moves.push(Move { collider, from: at, to, since: 0.0 }),
        }
    }

    /// Puts a collider at a pose, as if it had rested there.
    pub fn put(&mut self, collider: usize, at: Pose) {
        self.moves.retain(|m| m.collider != collider);
        self.moves.push(Move { collider, from: at, to: at, since: self.waited });
    }

    /// Drops all, where colliders are replaced.
    pub fn forget(&mut self) {
        *self = Drive::default();
    }

    /// To be called at the beginning of each frame that makes a step: colliders that have arrived rest from here on. Returns the host's time \[s\] since the last such frame.
    pub fn stepped(&mut self) -> f64 {
        let waited = std::mem::take(&mut self.waited);
        // One more frame, in which the velocity ends.
        self.moves.retain(|m| m.from != m.to);
        self.moves.iter_mut().for_each(|m| (m.from, m.since) = (m.to, 0.0));
        waited
    }
}

impl World {
    /// Moves colliders at the start of a frame of `dt` \[s\] of the host's time, and wakes the cloths that they may touch. Whether
    /// any has changed. Passes and their order are those of before: they depend on shapes and groups alone.
    pub fn drive(&mut self, dt: f64) -> bool {
        let driven = &mut self.driven;
        driven.waited += if dt.is_finite() { dt.max(0.0) } else { 0.0 };
        if driven.moves.is_empty() {
            return false;
        }
        let resting = self.find_resting();
        let mut changed = false;
        for n in 0..self.driven.moves.len() {
            let (m, waited) = (&self.driven.moves[n], self.driven.waited);
            let from = m.from;
            let Some(collider) = self.scene.colliders.get_mut(m.collider) else { continue };
            let now = collider.moved(&m.from, &m.to, waited - m.since);
            let before = std::mem::replace(collider, now);
            changed |= now != before;
            let start = Collider { center: from.position, rotation: from.rotation, ..before };
            let moves = [now.velocity, now.spin] != [[0.0; 3]; 2];
            if now != before && (moves || now.pose() != before.pose()) {
                if from != before.pose() {
                    self.disturb(&before, &start, 0.0, &resting);
                }
                // Its velocity is that of this way; a frame may last a step longer than the host's time.
                let step = self.control.clock.dt;
                self.disturb(&start, &now, step, &resting);
            }
        }
        self.resting = resting;
        changed
    }
}
