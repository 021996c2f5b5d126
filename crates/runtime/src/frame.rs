//! The frame of a cloth as executors read it.

use crate::passes::{Pass, SEARCH_STEPS, Schedule};
use crate::step::Step;

/// Steps of one cloth, and the passes that end them.
pub struct Frame<'a> {
    /// Its passes.
    pub schedule: &'a Schedule,
    /// Steps.
    pub steps: u32,
    /// Relaxations per step.
    pub rounds: u32,
    /// Steps from one with the forces of air to the next, at least 1.
    pub hold: u32,
    /// Steps from one with the passes on coarser grids to the next; 0 means never.
    pub pyramid: u32,
    /// The numbers of the first step and of the others; [`Frame::step`] adds where colliders are.
    pub numbers: [Step<f64>; 2],
    /// Length of a step \[s\] where colliders that contact is swept with, or the joints of a cloth, move; else 0.
    pub swept: f64,
}

impl<'a> Frame<'a> {
    /// The search for contact with cloth that step `n` begins with.
    pub fn near(&self, n: u32) -> &'a [Pass] {
        if n.is_multiple_of(SEARCH_STEPS) { &self.schedule.near } else { &[] }
    }

    /// The velocities of the air that step `n` begins with, after [`Frame::near`].
    pub fn gusts(&self, n: u32) -> &'a [Pass] {
        if n == 0 { &self.schedule.gusts } else { &[] }
    }

    /// The forces of air that step `n` begins with, after [`Frame::gusts`].
    pub fn air(&self, n: u32) -> &'a [Pass] {
        if n.is_multiple_of(self.hold) { &self.schedule.air } else { &[] }
    }

    /// The passes on coarser grids that step `n` has.
    pub fn coarse(&self, n: u32) -> &'a [Pass] {
        if self.pyramid > 0 && n.is_multiple_of(self.pyramid) { &self.schedule.coarse } else { &[] }
    }

    /// The numbers of step `n`, with moving colliders where they are at the end of step `pose`.
    pub fn step(&self, n: u32, pose: u32) -> Step<f64> {
        let left = f64::from(self.steps.saturating_sub(1 + pose)) * self.swept;
        Step { left, ..self.numbers[usize::from(n > 0)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colliders_are_where_a_step_ends_also_in_a_frame_without_steps() {
        let air = vec![Pass::Wind { gusts: true, holes: false }];
        let schedule = Schedule { gusts: vec![Pass::Gust], air, coarse: vec![Pass::Seams], ..Schedule::default() };
        let first = Step { dt: 2.0, ..Step::default() };
        let frame = |steps| Frame {
            schedule: &schedule,
            steps,
            rounds: 1,
            hold: 3,
            pyramid: 2,
            numbers: [first, Step::default()],
            swept: 0.5,
        };
        let four = frame(4);
        assert_eq!([0, 1, 2, 3].map(|n| four.step(n, n).left), [1.5, 1.0, 0.5, 0.0]);
        assert_eq!([0, 1, 2, 3].map(|n| four.step(n, n).dt), [2.0, 0.0, 0.0, 0.0]);
        assert_eq!([0, 1, 2, 3].map(|n| four.coarse(n).len()), [1, 0, 1, 0]);
        assert_eq!([0, 1, 2, 3].map(|n| four.air(n).len()), [1, 0, 0, 1]);
        assert_eq!([0, 1, 2, 3].map(|n| four.gusts(n).len()), [1, 0, 0, 0]);
        // An action alone has no step, and its last passes ask all the same.
        assert_eq!(frame(0).step(0, 0).left, 0.0);
    }
}
