//! Chooses the numbers of substeps and of rounds of polish, frame by frame.
//!
//! [`Law`] foretells the error of other numbers, and [`Reach`] finds the cheapest mix. Cloth answers late, and a shorter
//! substep is a stiffer spring: the numbers change by small steps, rise soon, and fall or are traded for one another only
//! after a while in which less would have done. A change that turns out to be wrong is undone.

use super::cost::Costs;
use super::law::Law;
use super::reach::{Aim, MAX_SUBSTEPS, MIN_GAIN, Reach, quarter};
use super::{Levers, Mix, NUMBERS, Numbers, Quality};

/// The numbers fall if fewer are foretold to leave this share of the target, and rises aim at it.
const AIM: f64 = 0.85;
/// Time from a change to a rise \[s\], in which the cloth follows the change. An error above this multiple of the target does not wait: a hit goes on.
const SOON: f64 = 0.05;
const URGENT: f64 = 4.0;
/// For so long less must have been enough \[s\]; up to the second, where it turned out to be too little.
const PATIENCE: [f64; 2] = [0.25, 4.0];
/// A change after which the error is too large within this time \[s\] is undone.
const UNDO_S: f64 = 0.5;
/// Time before a mix that turned out to be too little is tried again \[s\], the first time and at most.
const RETRY: [f64; 2] = [0.5, 8.0];
/// Standard deviations by which the exponent of the rounds is taken for worse than it is known to be, and for better in a
/// trial; and the time without a change before the first trial and the last ones \[s\].
const HOPE: [f64; 2] = [-1.0, 1.0];
const TRIAL_WAITS: [f64; 2] = [1.0, 64.0];
/// Chooses, from what was measured.
#[derive(Clone, Debug)]
pub struct Chooser {
    /// Largest stretch of the last frame that was measured.
    pub error: Option<f64>,
    /// The largest stretch measured since the last choice.
    fresh: Option<f64>,
    /// The largest since the numbers were changed, or smaller ones were thought of.
    worst: Option<f64>,
    /// Stepped since then, and since the change \[s\].
    waited: f64,
    held: f64,
    /// Stepped since the last choice \[s\].
    seconds: f64,
    law: Law,
    /// Times of frames.
    costs: Costs,
    /// Cost of a substep of the last mix.
    of_substep: f64,
    patience: f64,
    /// The last mix that turned out to be too little, and for how long it is not tried again \[s\].
    failed: Option<(Mix, f64)>,
    /// How long that is next time \[s\].
    retry: f64,
    /// Time without a change before a trial \[s\], and the least cost before one.
    trial: f64,
    tried: f64,
    fell: bool,
    /// The mix before, where the last change was not a rise.
    back: Option<Mix>,
    /// Whether the next trial is one of more rounds.
    more: bool,
}

impl Default for Chooser {
    fn default() -> Self {
        let (error, fresh, worst) = (None, None, None);
        let (waited, held, seconds) = (0.0, 0.0, 0.0);
        let (law, costs, of_substep) = (Law::default(), Costs::default(), 1.0);
        let (patience, failed, retry, trial, fell) = (PATIENCE[0], None, RETRY[0], TRIAL_WAITS[0], false);
        Chooser {
            error,
            fresh,
            worst,
            waited,
            held,
            seconds,
            law,
            costs,
            of_substep,
            patience,
            failed,
            retry,
            trial,
            tried: f64::INFINITY,
            fell,
            back: None,
            more: true,
        }
    }
}

impl Chooser {
    /// Its numbers beside the times of frames, which are the machine's.
    pub fn numbers(&self) -> [f64; NUMBERS] {
        let mut list = Vec::with_capacity(NUMBERS);
        self.clone().each(&mut Numbers::To(&mut list));
        debug_assert_eq!(list.len(), NUMBERS);
        list.resize(NUMBERS, f64::NAN);
        std::array::from_fn(|n| list[n])
    }

    /// Takes them over from another one; begins again with numbers that no chooser has.
    pub fn resume(&mut self, numbers: &[f64]) {
        self.each(&mut Numbers::From(numbers.iter()));
        let times = [self.waited, self.held, self.seconds, self.retry, self.trial, self.of_substep];
        let sound = times.iter().all(|x| x.is_finite() && *x >= 0.0) && self.tried > 0.0;
        if !sound || !(PATIENCE[0]..=PATIENCE[1]).contains(&self.patience) || !self.law.is_sound() {
            *self = Chooser { costs: std::mem::take(&mut self.costs), ..Chooser::default() };
        }
    }

    /// All its numbers, in one order.
    fn each(&mut self, numbers: &mut Numbers) {
        [&mut self.error, &mut self.fresh, &mut self.worst].into_iter().for_each(|x| numbers.known(x));
        let times = [&mut self.waited, &mut self.held, &mut self.seconds, &mut self.retry, &mut self.trial];
        times.into_iter().for_each(|x| numbers.number(x));
        [&mut self.of_substep, &mut self.patience, &mut self.tried].into_iter().for_each(|x| numbers.number(x));
        [&mut self.fell, &mut self.more].into_iter().for_each(|on| numbers.flag(on));
        let to = |(mix, left): &(Mix, f64)| [mix.numbers()[0], mix.numbers()[1], *left];
        numbers.option(&mut self.failed, to, |[n, r, left]| (Mix::of([n, r]), left));
        numbers.option(&mut self.back, |mix| mix.numbers(), Mix::of);
        self.law.each(numbers);
    }

    /// To be called when steps have been made.
    pub fn stepped(&mut self, seconds: f64) {
        self.seconds += seconds;
    }

    /// Takes in the error of a cloth.
    pub fn measured(&mut self, stretch: f64) {
        self.fresh = Some(self.fresh.map_or(stretch, |s| s.max(stretch)));
    }

    /// Takes in what `steps` steps took.
    pub fn took(&mut self, steps: u32, ms: f64) {
        self.costs.add(f64::from(steps) * self.of_substep, ms);
    }

    /// The mix from here on, `now` being that of the last frame.
    pub fn next(&mut self, quality: Quality, now: Mix, levers: &Levers) -> Mix {
        self.of_substep = levers.of_substep(now.rounds);
        if quality == Quality::Fixed || self.seconds == 0.0 {
            return now;
        }
        self.take_in(now);
        let n = now.substeps;
        let trial = self.of_substep * f64::from(n + (n / 8).max(1));
        let room = quality.budget().and_then(|ms| self.costs.room(trial, ms));
        let steps = |rounds| room.map(|r| ((r / levers.of_substep(rounds)).floor().max(1.0) as u32).min(MAX_SUBSTEPS));
        let (want, rise) = match quality.target() {
            Some(target) => self.for_error(target, now, levers, room),
            None => {
                let substeps = steps(now.rounds).map_or(n, |room| self.for_budget(room, n));
                (Mix { substeps, ..now }, substeps > n)
            }
        };
        // Colliders that are fast have to be met, also by cloth that is not stretched.
        let fewest = if quality.target().is_some() { levers.fewest.min(n + quarter(n)) } else { 1 };
        // A fall by more than a quarter at once would stir cloth at rest.
        let most = steps(want.rounds).unwrap_or(MAX_SUBSTEPS).max(n - n.div_ceil(4));
        let mut next = Mix { substeps: want.substeps.max(fewest).min(most).clamp(1, MAX_SUBSTEPS), ..want };
        let over = room.is_some_and(|room| levers.cost(next) > room);
        if over && next.substeps == 1 && levers.round.is_some() {
            next.rounds -= next.rounds.div_ceil(4);
        }
        // More steps for fast colliders are not a trade that could be undone.
        let more = next.substeps > now.substeps && next.rounds >= now.rounds;
        self.note(rise || more, now, next);
        self.of_substep = levers.of_substep(next.rounds);
        next
    }

    /// Takes in the last frame.
    fn take_in(&mut self, now: Mix) {
        let seconds = std::mem::take(&mut self.seconds);
        self.costs.age(seconds);
        self.waited += seconds;
        self.held += seconds;
        self.failed = self.failed.map(|(mix, left)| (mix, left - seconds)).filter(|(_, left)| *left > 0.0);
        if let Some(error) = self.fresh.take() {
            self.error = Some(error);
            self.worst = Some(self.worst.map_or(error, |w| w.max(error)));
            self.law.measured(now, error, seconds);
        }
    }

    /// Notes a change, which may be a rise.
    fn note(&mut self, rise: bool, now: Mix, next: Mix) {
        if next == now {
            return;
        }
        // A rise after a fall: the fall was a mistake. A fall after a fall: the one before was none.
        match (rise, self.fell) {
            (true, true) => {
                self.patience = (2.0 * self.patience).min(PATIENCE[1]);
                self.failed = Some((now, self.retry));
                self.retry = (2.0 * self.retry).min(RETRY[1]);
            }
            (false, true) => {
                self.patience = PATIENCE[0];
                let as_little = |(mix, _): (Mix, f64)| now.substeps <= mix.substeps && now.rounds <= mix.rounds;
                if self.failed.is_some_and(as_little) {
                    (self.failed, self.retry) = (None, RETRY[0]);
                }
            }
            _ => {}
        }
        (self.fell, self.held, self.back) = (!rise, 0.0, Some(now).filter(|_| !rise));
        self.start_anew();
    }

    fn start_anew(&mut self) {
        (self.worst, self.waited) = (None, 0.0);
    }

    /// The mix that is wanted, and whether because the error is too large.
    fn for_error(&mut self, target: f64, now: Mix, levers: &Levers, room: Option<f64>) -> (Mix, bool) {
        // Where no mix meets the target, the cost ends where it does with substeps alone.
        let start = Mix { substeps: MAX_SUBSTEPS, rounds: levers.start };
        let most = room.unwrap_or(f64::INFINITY).min(levers.cost(start));
        let trial = self.held >= self.trial && self.law.is_calm();
        let (stuck, more) = (self.held >= TRIAL_WAITS[0], self.more);
        let aim = |error: f64, rise: bool| {
            // Where the target has not been met for long, all else has been done.
            let hopes = if rise { stuck } else { trial };
            let way = Some(more).filter(|_| trial && !rise);
            Aim { excess: error / (AIM * target), most, rise, hope: HOPE[usize::from(hopes)], trial: way }
        };
        let aim = match (self.error, self.worst) {
            (Some(error), Some(_)) if error > target && (self.waited >= SOON || error > URGENT * target) => {
                aim(error, true)
            }
            (_, Some(worst)) if self.waited >= self.patience => {
                self.start_anew();
                // An error that meets the target is good enough.
                aim(worst.min(AIM * target), false)
            }
            _ => return (now, false),
        };
        if !aim.rise || self.fell {
            self.law.learn();
        }
        let back = self.back.filter(|back| aim.rise && self.held <= UNDO_S && levers.cost(*back) <= most);
        if let Some(back) = back {
            return (back, true);
        }
        let failed = self.failed.map(|(mix, _)| mix);
        let best = Reach { law: &self.law, levers, now, aim: &aim, failed }.best();
        if aim.rise && best != now {
            self.law.rises();
        }
        // More and fewer rounds are tried in turn.
        self.more ^= aim.trial.is_some();
        if aim.trial.is_some() && best.rounds != now.rounds {
            // On with trials soon where the last one paid.
            let (cost, [first, last]) = (levers.cost(now), TRIAL_WAITS);
            let paid = cost < (1.0 - MIN_GAIN) * self.tried;
            self.trial = if paid { first } else { (2.0 * self.trial).min(last) };
            self.tried = self.tried.min(cost);
        }
        (best, aim.rise)
    }

    /// Not up and down with every frame.
    fn for_budget(&self, room: u32, n: u32) -> u32 {
        let more = (n / 8).max(1);
        // One slow frame, as the first often is, says little: falls are gradual.
        if room >= n + more && self.waited >= self.patience { n + more } else { n.min(room).max(n - n.div_ceil(4)) }
    }
}

#[cfg(test)]
#[path = "../quality_tests.rs"]
mod tests;
