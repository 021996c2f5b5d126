//! The best of the mixes that one change reaches: the cheapest one that is foretold to meet the target, or a step towards it.

use super::law::Law;
use super::{Levers, Mix};

/// Most substeps and most rounds that are chosen.
pub const MAX_SUBSTEPS: u32 = 256;
pub const MAX_ROUNDS: u32 = 32;
/// Share of the cost that another number of rounds has to save.
pub const MIN_GAIN: f64 = 0.03;
/// Number of substeps below which a fraction of one counts as a whole one.
const FEW: f64 = 8.0;
/// Fewest substeps that are given up for rounds.
const MIN_TRADED: u32 = 4;

/// Goal of a change.
pub struct Aim {
    /// The error over the error that is aimed at.
    pub excess: f64,
    /// Largest cost.
    pub most: f64,
    /// Whether the error has to fall; if not, the cost has to.
    pub rise: bool,
    /// Standard deviations by which other numbers of rounds are thought better than they are known to be.
    pub hope: f64,
    /// Whether a trial is one of more rounds, where it is one.
    pub trial: Option<bool>,
}

/// Where a change starts, and what is known.
pub struct Reach<'a> {
    pub law: &'a Law,
    pub levers: &'a Levers,
    pub now: Mix,
    pub aim: &'a Aim,
    /// A mix that has just turned out to be too little.
    pub failed: Option<Mix>,
}

impl Reach<'_> {
    /// The mix that one change reaches on the way to the best number of rounds.
    pub fn best(&self) -> Mix {
        let Reach { levers, now, aim, .. } = *self;
        let r = now.rounds;
        let stays = self.with_rounds(r).unwrap_or(now);
        if levers.round.is_none() {
            return stays;
        }
        // Farther away the law holds no more. A rise after rounds were given up does not give up more.
        let fewest = if aim.rise && aim.hope < 0.0 { r } else { r / 2 };
        let most = (2 * r + 2).min(MAX_ROUNDS.max(r));
        let near = match aim.trial {
            Some(true) => r..=most,
            Some(false) => fewest..=r,
            None => fewest..=most,
        };
        let cost = |rounds| {
            let need = self.need(rounds).0;
            let need = if need < FEW { need.ceil() } else { need };
            let least = if rounds > r { now.substeps.min(MIN_TRADED) } else { 1 };
            levers.of_substep(rounds) * need.max(f64::from(levers.fewest.max(least)))
        };
        let Some(best) = near.min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else { return stays };
        if cost(best) > (1.0 - MIN_GAIN) * cost(r) {
            return stays;
        }
        let step = best.clamp(r - ((r + 1) / 8).max(1).min(r), r + ((r + 1) / 4).max(1));
        let one = best.clamp(r - r.min(1), r + 1);
        [step, one].into_iter().find_map(|rounds| self.with_rounds(rounds)).unwrap_or(stays)
    }

    /// How many substeps a number of rounds needs, and by what that number divides the error.
    fn need(&self, rounds: u32) -> (f64, f64) {
        let Reach { now, aim, .. } = *self;
        let hope = if rounds > now.rounds { aim.hope } else { -aim.hope };
        let by_rounds = (f64::from(rounds + 1) / f64::from(now.rounds + 1)).powf(self.law.of_rounds(hope));
        let factor = (aim.excess / by_rounds).powf(1.0 / self.law.of_substeps());
        (f64::from(now.substeps) * factor, by_rounds)
    }

    /// The mix with a number of rounds that one change reaches; none where it does not do.
    fn with_rounds(&self, rounds: u32) -> Option<Mix> {
        let Reach { levers, now, aim, .. } = *self;
        let (n, same) = (now.substeps, rounds == now.rounds);
        let (need, by_rounds) = self.need(rounds);
        let fits = (aim.most / levers.of_substep(rounds)).floor().min(f64::from(MAX_SUBSTEPS)) as u32;
        let most = match (same, aim.rise) {
            (true, false) => n,
            (false, false) => n + quarter(n),
            (_, true) => (n + quarter(n)).min(fits),
        };
        // At the largest cost, rounds take the place of more substeps at once: the cloth does not rest.
        let least = n - match (same, aim.rise) {
            (true, true) => 0,
            (false, true) => n.div_ceil(4),
            (_, false) => n.div_ceil(8),
        };
        let least = if rounds > now.rounds { least.max(n.min(MIN_TRADED)) } else { least };
        if most < least.max(1) {
            return None;
        }
        let least = if aim.rise { n.min(most) } else { least };
        // Not again what has just been too little.
        let known = self.failed.filter(|mix| !aim.rise && rounds <= mix.rounds).map_or(0, |mix| mix.substeps);
        let least = least.max((known + 1).min(n));
        if most < least {
            return None;
        }
        let substeps = (need.ceil().min(f64::from(most)) as u32).max(least).max(1);
        let left = aim.excess / by_rounds * (f64::from(n) / f64::from(substeps)).powf(self.law.of_substeps());
        // Neither a rise that makes the error larger, nor a trade that misses the target.
        let good = same || if aim.rise { left < aim.excess } else { left <= 1.0 };
        good.then_some(Mix { substeps, rounds })
    }
}

/// By how much a number of substeps rises at most.
pub fn quarter(n: u32) -> u32 {
    (n / 4).max(1)
}
