//! Cost of a frame: a fixed part and a part per unit of work, from the times of frames of different work. The unit is a
//! step without polish.

use std::collections::VecDeque;

/// Most times kept per amount of work, and fewest times of which the median counts.
const TIMES: [usize; 2] = [15, 5];
/// Most amounts of work remembered.
const MAX_COUNTS: usize = 6;
/// Times that were not renewed for so long \[s\] do not count: the machine may be another by now.
const OLD_S: f64 = 20.0;
/// Smallest share of a frame that its work takes, as times are noisy.
const MIN_SHARE: f64 = 0.05;
/// Share of a budget below which more work is tried when nothing is known of others.
const SPARE: f64 = 0.8;

/// Times of frames of one amount of work.
#[derive(Clone, Debug)]
struct Times {
    work: f64,
    ms: VecDeque<f64>,
    age: f64,
}

impl Times {
    /// The median, if there are `fewest` times.
    fn median(&self, fewest: usize) -> Option<f64> {
        let mut ms: Vec<f64> = self.ms.iter().copied().collect();
        ms.sort_by(f64::total_cmp);
        (ms.len() >= fewest).then(|| ms[ms.len() / 2])
    }
}

/// The times of late frames.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// The latest last.
    of: Vec<Times>,
}

impl Costs {
    /// Takes in a frame. Frames without work and times not above 0 do not count.
    pub fn add(&mut self, work: f64, ms: f64) {
        if work <= 0.0 || !ms.is_finite() || ms <= 0.0 {
            return;
        }
        // Times from before other work do not count: a busy moment of the machine may have been the reason for the change.
        let again = self.of.last().is_some_and(|t| t.work == work);
        let known = self.of.iter().position(|t| t.work == work).map(|at| self.of.remove(at));
        let mut times = known.filter(|_| again).unwrap_or_else(|| Times { work, ms: VecDeque::new(), age: 0.0 });
        times.age = 0.0;
        times.ms.push_back(ms);
        times.ms.drain(..times.ms.len().saturating_sub(TIMES[0]));
        self.of.push(times);
        self.of.drain(..self.of.len().saturating_sub(MAX_COUNTS));
    }

    /// To be called when `seconds` were stepped.
    pub fn age(&mut self, seconds: f64) {
        self.of.iter_mut().for_each(|t| t.age += seconds);
        self.of.retain(|t| t.age <= OLD_S);
    }

    /// The most work that `ms` have room for; none before times are known. `trial` is the work to be tried with budget to spare.
    pub fn room(&self, trial: f64, ms: f64) -> Option<f64> {
        let known =
            |fewest| -> Vec<(f64, f64)> { self.of.iter().filter_map(|t| Some((t.work, t.median(fewest)?))).collect() };
        // Where the work rises fast, no amount has many times: few are better than a rise without a bound.
        let known = Some(known(TIMES[1])).filter(|k| !k.is_empty()).unwrap_or_else(|| known(1));
        let (work, took) = *known.last()?;
        let far = known.iter().copied().max_by(|a, b| (a.0 - work).abs().total_cmp(&(b.0 - work).abs()))?;
        if far.0 == work {
            // All that is known: the work takes everything. A spare budget is worth a trial.
            let trial = if took <= SPARE * ms { trial } else { 0.0 };
            return Some((work * ms / took).max(trial));
        }
        let (rise, all) = ((took - far.1) / (work - far.0), took / work);
        // Less work that took as long is a busy moment, which says nothing of the fixed part: then the work takes everything.
        let per_work = if rise < MIN_SHARE * all { all } else { rise.min(all) };
        Some((work + (ms - took) / per_work).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(frames: &[(u32, f64)]) -> Costs {
        let mut costs = Costs::default();
        frames.iter().for_each(|&(steps, ms)| (0..TIMES[1]).for_each(|_| costs.add(f64::from(steps), ms)));
        costs
    }

    /// Whole steps that there is room for, the next larger number being worth a trial.
    fn room(costs: &Costs, n: u32, ms: f64) -> Option<u32> {
        costs.room(f64::from(n + 1), ms).map(|work| work.floor() as u32)
    }

    #[test]
    fn a_fixed_part_is_no_cost_of_steps() {
        // 3 ms + 0.25 ms per step.
        let known = costs(&[(1, 3.25), (4, 4.0)]);
        assert_eq!(room(&known, 4, 6.0), Some(12));
        assert_eq!(room(&known, 4, 3.5), Some(2));
    }

    #[test]
    fn one_step_with_budget_to_spare_is_not_the_end() {
        assert_eq!(room(&costs(&[(1, 4.0)]), 1, 6.0), Some(2));
        // At 90 % of the budget nothing is tried.
        assert_eq!(room(&costs(&[(1, 5.4)]), 1, 6.0), Some(1));
        assert_eq!(room(&Costs::default(), 8, 6.0), None);
    }

    #[test]
    fn what_was_slow_is_measured_anew_when_it_is_tried_again() {
        // A busy moment at 8 steps, which led to 6.
        let mut known = costs(&[(8, 9.0), (6, 3.0)]);
        known.add(8.0, 4.0);
        assert!(room(&known, 8, 6.0).is_some_and(|n| n >= 8));
        (1..TIMES[1]).for_each(|_| known.add(8.0, 4.0));
        assert!(room(&known, 8, 6.0).is_some_and(|n| n > 8));
    }

    #[test]
    fn a_busy_moment_does_not_make_steps_free() {
        // 3 steps took longer than 4 did: of steps without cost a little too much would leave none.
        assert_eq!(room(&costs(&[(4, 5.7), (3, 6.2)]), 3, 6.0), Some(2));
        assert_eq!(room(&costs(&[(4, 6.2), (3, 6.2)]), 3, 6.0), Some(2));
        assert_eq!(room(&costs(&[(3, 6.2), (4, 5.7)]), 4, 6.0), Some(4));
    }

    #[test]
    fn old_and_absurd_times_do_not_count() {
        let mut known = costs(&[(8, 1.0), (16, 9.0)]);
        // More than steps alone would take: a machine under load.
        assert_eq!(room(&known, 16, 4.5), Some(8));
        known.age(OLD_S + 1.0);
        assert_eq!(room(&known, 16, 4.5), None);
        known.add(8.0, f64::NAN);
        known.add(0.0, 1.0);
        assert_eq!(known.of.len(), 0);
    }
}
