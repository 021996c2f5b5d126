//! How the error answers to substeps and to rounds of polish: as `1 / (substeps^a (rounds + 1)^b)`.
//!
//! In theory `a` is 2 (Macklin et al., "Small Steps in Physics Simulation", SCA 2019). Measured, it is 2 for sheets that hang by
//! springs, and 1 to 1.5 for sheets on tethers and garments on colliders; `b` is 0.9 to 1.7, and nearly 0 for garments from 8
//! rounds on. A Kalman filter learns both exponents from
//! the changes of the numbers that are made anyway: each one is a measurement of the change of the logarithm of the error.
//! The uncertainty of a measurement is that with which the error changes between changes of the numbers, so that nothing is
//! learned from cloth in wild motion and much from cloth at rest.

use super::Mix;
use super::saved::Numbers;

/// Exponents before anything was measured, and their standard deviations.
const PRIOR: [f64; 2] = [1.5, 1.0];
const PRIOR_DEVIATION: f64 = 0.4;
/// Range of each exponent.
const RANGE: [[f64; 2]; 2] = [[0.3, 4.0], [0.0, 4.0]];
/// Largest standard deviation of an exponent.
const MAX_DEVIATION: f64 = 1.0;
/// Standard deviation of the change of each exponent when the number that it belongs to changes by a factor of e.
const WANDER: [f64; 2] = [0.2, 0.6];
/// The error is averaged over this time \[s\].
const MEAN_S: f64 = 0.1;
/// Time \[s\] in which most of the answer to a change arrives.
const ANSWER_S: f64 = 0.15;
/// Standard deviation of ln(error): at any time, and what the missing part of the answer adds right after a change.
const NOISE: [f64; 2] = [0.03, 0.3];
/// Standard deviation of ln(error) across a rise.
const RISE: f64 = 1.0;
/// Share of the newest measurement in the drift.
const NEWEST: f64 = 0.2;
/// Drift \[1/s\] before anything was measured, the largest one that is counted, and that of cloth that is calm.
const DRIFT: [f64; 3] = [0.1, 10.0, 0.02];
/// Smallest error that is told from none.
const MIN_ERROR: f64 = 1e-6;

/// The mean of ln(error) with one mix.
#[derive(Clone, Copy, Debug)]
struct Level {
    mix: Mix,
    mean: f64,
    /// When, and for how long it had lasted \[s\].
    at: f64,
    since: f64,
}

impl Level {
    /// Variance of the mean.
    fn noise(&self) -> f64 {
        NOISE[0].powi(2) + (NOISE[1] * (-self.since / ANSWER_S).exp()).powi(2)
    }
}

/// Estimates of the exponents.
#[derive(Clone, Debug)]
pub struct Law {
    /// Of the substeps, and of the rounds plus 1.
    exponents: [f64; 2],
    covariance: [[f64; 2]; 2],
    /// Mean change of ln(error) with the same mix, and mean square of what it differs from that \[1/s\].
    trend: f64,
    drift: f64,
    /// With the mix before the last change, until something was learned from the change.
    before: Option<Level>,
    /// Whether rises are among the changes since.
    rose: bool,
    /// With the current mix.
    now: Option<Level>,
    /// Mean and time from which the drift is measured next.
    mark: Option<(f64, f64)>,
    /// Measured so far \[s\].
    time: f64,
}

impl Default for Law {
    fn default() -> Self {
        let variance = PRIOR_DEVIATION * PRIOR_DEVIATION;
        let covariance = [[variance, 0.0], [0.0, variance]];
        let (before, now, mark) = (None, None, None);
        Law { exponents: PRIOR, covariance, trend: 0.0, drift: DRIFT[0], before, rose: false, now, mark, time: 0.0 }
    }
}

/// Logarithms of the numbers that the error is a power of.
fn logarithms(mix: Mix) -> [f64; 2] {
    [f64::from(mix.substeps).ln(), f64::from(mix.rounds + 1).ln()]
}

impl Law {
    /// The exponent of the substeps.
    pub fn of_substeps(&self) -> f64 {
        self.exponents[0]
    }

    /// The exponent of the rounds plus 1, `deviations` standard deviations above the most probable one.
    pub fn of_rounds(&self, deviations: f64) -> f64 {
        let exponent = self.exponents[1] + deviations * self.covariance[1][1].sqrt();
        exponent.clamp(RANGE[1][0], RANGE[1][1])
    }

    /// Whether the error hardly changes unless the mix does.
    pub fn is_calm(&self) -> bool {
        self.drift <= DRIFT[2]
    }

    /// Takes in the error of a frame of `seconds`.
    pub fn measured(&mut self, mix: Mix, error: f64, seconds: f64) {
        self.time += seconds;
        let error = error.max(MIN_ERROR).ln();
        match &mut self.now {
            Some(level) if level.mix == mix => {
                level.since += seconds;
                level.mean += (error - level.mean) * (seconds / MEAN_S).min(1.0);
                level.at = self.time;
            }
            _ => {
                if self.now.is_some_and(|now| now.since >= MEAN_S) {
                    self.learn();
                }
                // Of a mix that did not last nothing is known.
                self.before = self.before.or(self.now);
                (self.now, self.mark) = (Some(Level { mix, mean: error, at: self.time, since: 0.0 }), None);
            }
        }
        self.measure_drift();
    }

    fn measure_drift(&mut self) {
        let Some(level) = self.now.filter(|now| now.since >= MEAN_S) else { return };
        let Some((mean, at)) = self.mark else {
            self.mark = Some((level.mean, level.at));
            return;
        };
        if level.at - at >= MEAN_S {
            let (change, seconds) = (level.mean - mean, level.at - at);
            let drift = ((change - self.trend * seconds).powi(2) / seconds).min(DRIFT[1]);
            self.drift += NEWEST * (drift - self.drift);
            self.trend += NEWEST * (change / seconds - self.trend);
            self.mark = Some((level.mean, level.at));
        }
    }

    /// To be called before a change that comes because the error is too large: it may be about to grow.
    pub fn rises(&mut self) {
        self.rose = true;
    }

    /// Learns from the last change, once.
    pub fn learn(&mut self) {
        let (Some(before), Some(now)) = (self.before, self.now.filter(|now| now.since > 0.0)) else { return };
        self.before = None;
        let rise = if std::mem::take(&mut self.rose) { RISE.powi(2) } else { 0.0 };
        let (a, b) = (logarithms(before.mix), logarithms(now.mix));
        // How far the logarithm of the error falls for each exponent.
        let by = [b[0] - a[0], b[1] - a[1]];
        if by == [0.0; 2] {
            return;
        }
        let noise = rise + before.noise() + now.noise() + self.drift * (now.at - before.at);
        for (d, row) in self.covariance.iter_mut().enumerate() {
            row[d] = (row[d] + (WANDER[d] * by[d]).powi(2)).min(MAX_DEVIATION * MAX_DEVIATION);
        }
        let times = self.covariance.map(|row| row[0] * by[0] + row[1] * by[1]);
        let variance = times[0] * by[0] + times[1] * by[1] + noise;
        let expected = self.exponents[0] * by[0] + self.exponents[1] * by[1];
        let found = before.mean - now.mean + self.trend * (now.at - before.at);
        // A surprise beyond three standard deviations is something else that happened.
        let surprise = (found - expected).clamp(-3.0 * variance.sqrt(), 3.0 * variance.sqrt());
        for d in 0..2 {
            let [least, most] = RANGE[d];
            self.exponents[d] = (self.exponents[d] + times[d] * surprise / variance).clamp(least, most);
            (0..2).for_each(|e| self.covariance[d][e] -= times[d] * times[e] / variance);
        }
    }

    /// All its numbers, in one order.
    pub fn each(&mut self, numbers: &mut Numbers) {
        self.exponents.iter_mut().chain(self.covariance.as_flattened_mut()).for_each(|x| numbers.number(x));
        [&mut self.trend, &mut self.drift, &mut self.time].into_iter().for_each(|x| numbers.number(x));
        numbers.flag(&mut self.rose);
        for level in [&mut self.before, &mut self.now] {
            let to = |l: &Level| [l.mix.numbers()[0], l.mix.numbers()[1], l.mean, l.at, l.since];
            let from = |[n, r, mean, at, since]: [f64; 5]| Level { mix: Mix::of([n, r]), mean, at, since };
            numbers.option(level, to, from);
        }
        numbers.option(&mut self.mark, |m| [m.0, m.1], |[mean, at]| (mean, at));
    }

    /// Whether its numbers are within their ranges.
    pub fn is_sound(&self) -> bool {
        let within = self.exponents.iter().zip(RANGE).all(|(x, [least, most])| (least..=most).contains(x));
        let [[a, b], [c, d]] = self.covariance;
        within && a >= 0.0 && d >= 0.0 && [a, b, c, d, self.trend, self.drift, self.time].iter().all(|x| x.is_finite())
    }
}
