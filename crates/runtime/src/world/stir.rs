//! Which cloths a change of colliders wakes: those that it may touch.

use std::collections::VecDeque;

use super::World;
use crate::collider::Collider;
use crate::collider::way::{Corners, arm, passes};
use crate::passes::Kinds;

/// A collider that has changed.
#[derive(Clone, Copy, Debug)]
struct Change {
    from: Collider,
    to: Collider,
    /// What it may be ahead of its pose by its velocity and spin \[m\].
    ahead: f64,
}

/// Changes of colliders that measurements of rest may not know of.
#[derive(Default)]
pub struct Stirs {
    /// In order, each with its number.
    list: VecDeque<(u64, Change)>,
    /// How many there were.
    pub count: u64,
}

/// Distance \[m\] at which a collider may touch cloth, beside the thickness of the cloth: rounding, and what a cloth may sink
/// when its support is taken away.
const NEAR_M: f64 = 0.01;
/// The corners of boxes are coated thicker than their faces.
const CORNERS: f64 = 1.75;

impl World {
    /// Wakes the cloths that a collider may touch on its way, and keeps in mind for the others that it moved. A cloth that is
    /// awake needs no word: if it is touched, it moves.
    pub fn stir(&mut self, from: &Collider, to: &Collider, seconds: f64) {
        let size = |v: [f32; 3]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        let ahead = seconds * (size(to.velocity) + size(to.spin) * arm(to));
        let change = Change { from: *from, to: *to, ahead };
        let touches = |cloth: &usize| {
            let run = &self.runs[*cloth];
            run.asleep && run.calm.rest.is_none_or(|rest| self.may_touch(*cloth, &change, rest))
        };
        let woken: Vec<_> = (0..self.runs.len()).filter(|c| self.meets(*c, &change)).filter(touches).collect();
        woken.into_iter().for_each(|cloth| self.wake(cloth));
        if self.calm_below().is_some() {
            self.stirs.count += 1;
            self.stirs.list.push_back((self.stirs.count, change));
        }
    }

    /// Puts other colliders in the place of the present ones, and wakes the cloths that they may touch; whether passes and their
    /// order stay as they are.
    pub fn take_colliders(&mut self, colliders: Vec<Collider>) -> bool {
        let before = std::mem::replace(&mut self.scene.colliders, colliders.clone());
        let alike = before.len() == colliders.len() && before.iter().zip(&colliders).all(|(a, b)| is_alike(a, b));
        let seconds = self.control.options.step;
        for n in 0..before.len().max(colliders.len()) {
            if let (Some(from), Some(to)) = (before.get(n).or(colliders.get(n)), colliders.get(n).or(before.get(n)))
                && (from != to || n >= before.len().min(colliders.len()))
            {
                self.stir(from, to, seconds);
            }
        }
        alike
    }

    /// Whether a collider that changed after the first `known` changes may touch a cloth that rests in a box.
    pub fn is_stirred(&self, cloth: usize, known: u64, rest: Corners) -> bool {
        let later = self.stirs.list.iter().rev().take_while(|(number, _)| *number > known);
        later.map(|(_, change)| change).any(|change| self.meets(cloth, change) && self.may_touch(cloth, change, rest))
    }

    /// Drops the first `known` changes, which all measurements to come know of.
    pub fn forget_stirs(&mut self, known: u64) {
        while self.stirs.list.front().is_some_and(|(number, _)| *number <= known) {
            self.stirs.list.pop_front();
        }
    }

    /// Whether a cloth meets a collider before or after a change.
    fn meets(&self, cloth: usize, change: &Change) -> bool {
        let groups = self.scene.cloths[cloth].collision_groups;
        change.from.is_met(groups) || change.to.is_met(groups)
    }

    /// Whether a collider may touch a cloth that rests in a box.
    fn may_touch(&self, cloth: usize, change: &Change, rest: Corners) -> bool {
        let options = &self.control.options;
        let thickness = f64::from(self.scene.cloths[cloth].thickness.unwrap_or(options.thickness));
        // A box may be measured early in the time of rest.
        let drift = options.sleep.map_or(0.0, |sleep| sleep.speed * sleep.after);
        passes(&change.from, &change.to, rest, NEAR_M + CORNERS * thickness + drift + change.ahead)
    }
}

/// Whether one collider can take another's place without a change of passes: they depend on these alone.
fn is_alike(a: &Collider, b: &Collider) -> bool {
    let kind = |c: &Collider| (Kinds::of([c]), c.collision_groups);
    kind(a) == kind(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collider::Shape;
    use crate::options::{Options, Sleep};
    use crate::scene::builtin;

    fn world() -> World {
        let mut scene = builtin("s1", 9).unwrap();
        scene.colliders = vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, 5.0, 0.0])];
        let options = Options { sleep: Some(Sleep { speed: 0.01, after: 0.5 }), ..Options::default() };
        World::new(scene, options).unwrap()
    }

    const REST: Corners = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.1]];

    fn ball(y: f32) -> Vec<Collider> {
        vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.5, y, 0.0])]
    }

    #[test]
    fn a_measurement_that_does_not_know_of_a_collider_puts_nothing_to_sleep() {
        // The ball arrives after the measurement that is taken in.
        for (y, known, asleep) in [(-0.5, 0, false), (-0.5, 1, true), (3.0, 0, true)] {
            let mut world = world();
            assert!(world.take_colliders(ball(y)));
            world.note(0, true, (1.0, known), || Some(REST));
            assert_eq!(world.runs[0].asleep, asleep, "{y} {known}");
            // Once it is known to all measurements it is forgotten.
            world.forget_stirs(1);
            world.note(0, true, (1.0, 0), || Some(REST));
            assert!(world.runs[0].asleep);
        }
    }

    #[test]
    fn cloth_without_a_known_box_stays_awake_and_one_that_was_put_to_sleep_wakes() {
        let mut world = world();
        world.note(0, true, (1.0, 0), || None);
        assert!(!world.runs[0].asleep);
        assert_eq!(world.without_rest(), [0]);
        world.runs[0].calm.asked = true;
        let mark = world.runs[0].calm.mark();
        assert_eq!(world.without_rest(), [0; 0]);
        // It moves, and comes to rest again: the box of before is another one.
        world.note(0, false, (0.1, 0), || None);
        world.note(0, true, (1.0, 0), || None);
        world.rest(0, mark, REST);
        world.note(0, true, (0.1, 0), || None);
        assert!(!world.runs[0].asleep);
        world.rest(0, world.runs[0].calm.mark(), REST);
        world.note(0, true, (0.1, 0), || None);
        assert!(world.runs[0].asleep);
        world.take_colliders(ball(4.0));
        assert!(world.runs[0].asleep);
        world.runs[0].calm.rest = None;
        world.take_colliders(ball(4.5));
        assert!(!world.runs[0].asleep);
    }

    #[test]
    fn thickness_and_speed_of_colliders_count() {
        for (thickness, velocity, asleep) in [(0.0, 0.0, true), (0.3, 0.0, false), (0.0, 30.0, false)] {
            let mut world = world();
            world.scene.cloths[0].thickness = Some(thickness);
            world.note(0, true, (1.0, 0), || Some(REST));
            let moving = Collider { velocity: [0.0, velocity, 0.0], ..ball(0.4)[0] };
            world.take_colliders(vec![moving]);
            assert_eq!(world.runs[0].asleep, asleep && world.runs[0].calm.rest.is_some(), "{thickness} {velocity}");
        }
    }
}
