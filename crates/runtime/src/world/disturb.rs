//! Which cloths are disturbed by a collider that changes: those that it may touch.

use std::collections::VecDeque;

use super::World;
use crate::collider::Collider;
use crate::collider::path::{Corners, Path};
use crate::passes::Kinds;

/// Paths of colliders while boxes around cloths are on their way from the GPU.
#[derive(Default)]
pub struct PathLog {
    /// In order, each with its number and the groups of its collider.
    list: VecDeque<(u64, u32, Path)>,
    /// The number of the last path.
    count: u64,
    /// The number of the last path that was dropped, as the list was full.
    dropped: u64,
}

impl PathLog {
    /// The number of the last path.
    pub fn count(&self) -> u64 {
        self.count
    }

    fn add(&mut self, groups: u32, path: Path) {
        self.count += 1;
        self.list.push_back((self.count, groups, path));
        if self.list.len() > MAX_LOGGED {
            self.dropped = self.list.pop_front().map_or(0, |(number, ..)| number);
        }
    }

    /// Drops the paths up to a number.
    pub fn forget(&mut self, known: u64) {
        while self.list.front().is_some_and(|(number, ..)| *number <= known) {
            self.list.pop_front();
        }
    }
}

/// Cloths at rest, by index, in order.
pub(super) type Resting = Vec<usize>;

/// Largest number of paths in the log: a host that never calls `settle` does not fill the memory.
const MAX_LOGGED: usize = 4096;
/// Distance \[m\] at which a collider may touch cloth, beside the cloth's thickness: rounding, and how deep a cloth may lie.
const NEAR_M: f64 = 0.01;
/// Largest distance from a box collider to the corners of its coat, over the thickness of the coat.
const CORNER_COAT: f64 = 1.75;

impl World {
    /// Finds the cloths at rest, before colliders change: a look at each cloth.
    pub(super) fn find_resting(&mut self) -> Resting {
        let mut resting = std::mem::take(&mut self.resting);
        resting.clear();
        let runs = self.runs.iter().enumerate();
        resting.extend(runs.filter(|(_, run)| run.asleep || run.calm.seconds() > 0.0).map(|(cloth, _)| cloth));
        resting
    }

    /// Wakes the cloths at rest that a collider may touch on its path if they are asleep, and lets the others rest again before
    /// they fall asleep. Contact sweeps the collider over the `seconds` before its new pose too. One comparison of boxes per cloth at rest.
    pub(super) fn disturb(&mut self, from: &Collider, to: &Collider, seconds: f64, resting: &Resting) {
        let groups = from.collision_groups | to.collision_groups;
        let (mut path, mut awaited) = (None, false);
        for &cloth in resting {
            let run = &self.runs[cloth];
            // It may have been woken since.
            let rests = run.asleep || run.calm.seconds() > 0.0;
            if !rests || self.scene.cloths[cloth].met_groups() & groups == 0 {
                continue;
            }
            let path = path.get_or_insert_with(|| Path::new(from, to, seconds));
            match run.calm.rest_box {
                Some(rest) if !self.may_touch(cloth, path, rest) => {}
                None if !run.asleep => awaited = true,
                _ => self.wake(cloth),
            }
        }
        if let Some(path) = path.filter(|_| awaited) {
            self.paths.add(groups, path);
        }
    }

    /// Whether colliders can take the place of the present ones without a change of passes and of the cloths that they meet.
    pub fn is_like(&self, colliders: &[Collider]) -> bool {
        let before = &self.scene.colliders;
        before.len() == colliders.len() && before.iter().zip(colliders).all(|(a, b)| is_alike(a, b))
    }

    /// Puts other colliders in the place of the present ones, and disturbs cloths.
    pub fn take_colliders(&mut self, colliders: Vec<Collider>) {
        let before = std::mem::replace(&mut self.scene.colliders, colliders);
        let resting = self.find_resting();
        let (old, new) = (before.len(), self.scene.colliders.len());
        let seconds = self.control.options.step * f64::from(self.control.options.max_catch_up);
        // Colliders that come and go leave those before and behind them as they are.
        let same = |(a, b): &(&Collider, &Collider)| a == b;
        let front = before.iter().zip(&self.scene.colliders).take_while(same).count();
        let back =
            before[front..].iter().rev().zip(self.scene.colliders[front..].iter().rev()).take_while(same).count();
        for n in front..(old - back).max(new - back) {
            let a = before.get(n).filter(|_| n < old - back).copied();
            let b = self.scene.colliders.get(n).filter(|_| n < new - back).copied();
            match (a, b) {
                (Some(from), Some(to)) if std::mem::discriminant(&from.shape) == std::mem::discriminant(&to.shape) => {
                    if from != to {
                        self.disturb(&from, &to, seconds, &resting);
                    }
                }
                _ => a.into_iter().chain(b).for_each(|one| self.disturb(&one, &one, seconds, &resting)),
            }
        }
        self.resting = resting;
    }

    /// Whether a collider that changed after the path of number `known` may touch a cloth.
    pub(super) fn is_disturbed(&self, cloth: usize, known: u64, rest: (Corners, f64)) -> bool {
        let groups = self.scene.cloths[cloth].met_groups();
        let later = self.paths.list.iter().rev().take_while(|(number, ..)| *number > known);
        let mut met = later.filter(|(_, of, _)| of & groups != 0);
        known < self.paths.dropped || met.any(|(.., path)| self.may_touch(cloth, path, rest))
    }

    /// Whether a path may touch a cloth that rests in a box, up to the second number \[m\] outside it.
    fn may_touch(&self, cloth: usize, path: &Path, (rest, drift): (Corners, f64)) -> bool {
        let thickness = f64::from(self.scene.cloths[cloth].thickness.unwrap_or(self.control.options.thickness));
        path.reaches(rest, NEAR_M + CORNER_COAT * thickness + drift)
    }
}

/// Whether one collider can take another's place without a change of passes.
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
    use crate::world::sleep::Sought;

    const REST: Corners = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.1]];

    fn ball(y: f32) -> Vec<Collider> {
        vec![Collider::new(Shape::Sphere { radius: 0.1 }, [0.5, y, 0.0])]
    }

    fn world() -> World {
        let mut scene = builtin("s1", 9).unwrap();
        scene.colliders = ball(5.0);
        let options = Options { sleep: Some(Sleep { speed: 0.01, after: 0.5 }), ..Options::default() };
        World::new(scene, options).unwrap()
    }

    /// A box that is asked for, as the GPU does.
    fn ask(world: &mut World) -> Sought {
        assert_eq!(world.without_rest_box(), [0]);
        let sought = world.seek(0);
        assert_eq!(world.without_rest_box(), [0; 0]);
        sought
    }

    #[test]
    fn a_collider_that_moves_before_the_box_arrives_counts() {
        for (y, late) in [(-0.5, true), (3.0, true), (-0.5, false), (3.0, false)] {
            let mut world = world();
            world.note(0, true, 0.3, || None);
            let sought = late.then(|| ask(&mut world));
            assert!(world.is_like(&ball(y)));
            world.take_colliders(ball(y));
            let sought = sought.unwrap_or_else(|| ask(&mut world));
            world.forget_paths();
            assert_eq!(world.paths.list.len(), 1);
            world.found(0, &sought, Some(REST));
            world.forget_paths();
            assert_eq!(world.paths.list.len(), 0);
            world.note(0, true, 0.3, || None);
            assert_eq!(world.runs[0].asleep, y > 0.0, "{y} {late}");
        }
    }

    #[test]
    fn a_support_that_leaves_starts_the_rest_anew() {
        let mut world = world();
        world.take_colliders(ball(-0.5));
        let rest = || Some(REST);
        world.note(0, true, 0.4, rest);
        world.take_colliders(ball(-9.0));
        // Calm for long enough, but not since its support has left.
        world.note(0, true, 0.2, rest);
        assert!(!world.runs[0].asleep);
        world.note(0, true, 0.4, rest);
        assert!(world.runs[0].asleep);
    }

    #[test]
    fn cloth_without_a_known_box_stays_awake_and_one_that_was_put_to_sleep_wakes() {
        let mut world = world();
        world.note(0, true, 1.0, || None);
        assert!(!world.runs[0].asleep);
        let old = ask(&mut world);
        // It moves, and comes to rest again: the box of before is another one.
        world.note(0, false, 0.1, || None);
        world.note(0, true, 1.0, || None);
        world.found(0, &old, Some(REST));
        world.note(0, true, 0.1, || None);
        assert!(!world.runs[0].asleep);
        // No particle was found: it is asked again.
        let sought = ask(&mut world);
        world.found(0, &sought, None);
        let sought = ask(&mut world);
        world.found(0, &sought, Some(REST));
        world.note(0, true, 0.1, || None);
        assert!(world.runs[0].asleep);
        // The box was measured before: it is measured again.
        let sought = ask(&mut world);
        world.take_colliders(ball(4.0));
        world.found(0, &sought, Some(REST));
        assert!(world.runs[0].asleep && world.runs[0].calm.rest_box == Some((REST, 0.0)));
        world.runs[0].calm.rest_box = None;
        world.take_colliders(ball(4.5));
        assert!(!world.runs[0].asleep);
    }

    #[test]
    fn thickness_and_speed_of_colliders_count() {
        for (thickness, velocity, asleep) in [(0.0, 0.0, true), (0.3, 0.0, false), (0.0, -30.0, false)] {
            let mut world = world();
            world.take_colliders(ball(0.4));
            world.scene.cloths[0].thickness = Some(thickness);
            world.note(0, true, 1.0, || Some(REST));
            assert!(world.runs[0].asleep);
            let moving = Collider { velocity: [0.0, velocity, 0.0], ..ball(0.45)[0] };
            world.take_colliders(vec![moving]);
            assert_eq!(world.runs[0].asleep, asleep, "{thickness} {velocity}");
        }
    }

    #[test]
    fn measurements_from_before_it_fell_asleep_count() {
        let mut world = world();
        world.note(0, true, 1.0, || Some(REST));
        assert!(world.runs[0].asleep);
        world.note(0, true, 0.1, || None);
        assert!(world.runs[0].asleep && world.runs[0].calm.rest_box == Some((REST, 0.0)));
        world.note(0, false, 0.1, || None);
        assert!(!world.runs[0].asleep);
    }

    #[test]
    fn colliders_that_come_and_go_leave_the_others_of_the_list_as_they_are() {
        let floor = Collider::new(Shape::HalfSpace, [0.0, -1.0, 0.0]);
        let among = |list: Vec<Collider>| {
            let mut world = world();
            world.take_colliders([ball(5.0), vec![floor]].concat());
            world.note(0, true, 1.0, || Some(REST));
            assert!(world.runs[0].asleep);
            world.take_colliders(list);
            world.runs[0].asleep
        };
        assert!(among(vec![floor]));
        assert!(among([ball(5.0), ball(6.0), vec![floor]].concat()));
        assert!(!among([ball(5.0), ball(-0.5), vec![floor]].concat()));
        assert!(!among(ball(5.0)));
        assert!(!among(vec![]));
    }

    #[test]
    fn other_conditions_of_sleep_start_the_rest_again() {
        let mut world = world();
        world.note(0, true, 0.4, || Some(REST));
        let sleep = Some(Sleep { speed: 0.02, after: 0.5 });
        world.set_options(Options { sleep, ..world.control.options.given().clone() });
        assert_eq!((world.runs[0].calm.seconds(), world.runs[0].calm.rest_box), (0.0, None));
    }

    #[test]
    fn the_log_is_bounded_and_what_it_dropped_counts_as_close() {
        let mut world = world();
        world.note(0, true, 1.0, || None);
        let sought = ask(&mut world);
        for n in 0..MAX_LOGGED + 10 {
            world.take_colliders(ball(5.0 + 0.001 * (n + 1) as f32));
        }
        assert_eq!(world.paths.list.len(), MAX_LOGGED);
        world.found(0, &sought, Some(REST));
        assert_eq!(world.runs[0].calm.seconds(), 0.0);
    }
}
