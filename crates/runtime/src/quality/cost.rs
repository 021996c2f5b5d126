//! What a frame costs: a fixed part and a part per step, from the times of frames of different numbers of steps.

use std::collections::VecDeque;

/// Most times kept per number of steps, and fewest times of which the median counts.
const TIMES: [usize; 2] = [15, 5];
/// Most numbers of steps remembered.
const MAX_COUNTS: usize = 6;
/// Times that were not renewed for so long \[s\] do not count: the machine may be another by now.
const OLD_S: f64 = 20.0;
/// Smallest share of a frame that its steps take, as times are noisy.
const MIN_SHARE: f64 = 0.05;
/// Share of a budget below which a larger number of steps is tried when nothing is known of others.
const SPARE: f64 = 0.8;

/// Times of frames of one number of steps.
#[derive(Clone, Debug)]
struct Times {
    steps: u32,
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
    /// Takes in a frame. Frames without a step and times not above 0 do not count.
    pub fn add(&mut self, steps: u32, ms: f64) {
        if steps == 0 || !ms.is_finite() || ms <= 0.0 {
            return;
        }
        let known = self.of.iter().position(|t| t.steps == steps).map(|at| self.of.remove(at));
        let mut times = known.unwrap_or_else(|| Times { steps, ms: VecDeque::new(), age: 0.0 });
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

    /// The largest number of steps that `ms` have room for, `n` being the present one; none before times are known.
    pub fn room(&self, n: u32, ms: f64) -> Option<u32> {
        let known = |fewest| -> Vec<(f64, f64)> {
            self.of.iter().filter_map(|t| Some((f64::from(t.steps), t.median(fewest)?))).collect()
        };
        // Where the number rises fast, none has many times: few are better than a rise without a bound.
        let known = Some(known(TIMES[1])).filter(|k| !k.is_empty()).unwrap_or_else(|| known(1));
        let (steps, took) = *known.last()?;
        let far = known.iter().copied().max_by(|a, b| (a.0 - steps).abs().total_cmp(&(b.0 - steps).abs()))?;
        if far.0 == steps {
            // All that is known: the steps take everything. A spare budget is worth a trial.
            let room = (steps * ms / took).floor() as u32;
            let trial = if took <= SPARE * ms { n + (n / 8).max(1) } else { 0 };
            return Some(room.max(trial));
        }
        let per_step = ((took - far.1) / (steps - far.0)).clamp(MIN_SHARE * took / steps, took / steps);
        Some((steps + (ms - took) / per_step).max(1.0).floor() as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(frames: &[(u32, f64)]) -> Costs {
        let mut costs = Costs::default();
        frames.iter().for_each(|&(steps, ms)| (0..TIMES[1]).for_each(|_| costs.add(steps, ms)));
        costs
    }

    #[test]
    fn a_fixed_part_is_no_cost_of_steps() {
        // 3 ms + 0.25 ms per step.
        let known = costs(&[(1, 3.25), (4, 4.0)]);
        assert_eq!(known.room(4, 6.0), Some(12));
        assert_eq!(known.room(4, 3.5), Some(2));
    }

    #[test]
    fn one_step_with_budget_to_spare_is_not_the_end() {
        assert_eq!(costs(&[(1, 4.0)]).room(1, 6.0), Some(2));
        // At 90 % of the budget nothing is tried.
        assert_eq!(costs(&[(1, 5.4)]).room(1, 6.0), Some(1));
        assert_eq!(Costs::default().room(8, 6.0), None);
    }

    #[test]
    fn old_and_absurd_times_do_not_count() {
        let mut known = costs(&[(8, 1.0), (16, 9.0)]);
        // More than steps alone would take: a machine under load.
        assert_eq!(known.room(16, 4.5), Some(8));
        known.age(OLD_S + 1.0);
        assert_eq!(known.room(16, 4.5), None);
        known.add(8, f64::NAN);
        known.add(0, 1.0);
        assert_eq!(known.of.len(), 0);
    }
}
