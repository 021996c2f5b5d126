//! Chooses the number of substeps of a frame, from the remaining stretch and the cost of a step.
//!
//! One relaxation per substep leaves inextensible cloth stretched in proportion to the square of the substep (Macklin et al.,
//! "Small Steps in Physics Simulation", SCA 2019), so that `n sqrt(error / target)` substeps should meet a target that `n`
//! miss. Cloth answers late, and a shorter substep is a stiffer spring: the number changes by small steps, rises
//! soon, and falls only after a while in which fewer would have done.

mod cost;

use cost::Costs;

use crate::error::{Result, check};

/// How the number of substeps is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Quality {
    /// Always [`crate::Options::substeps`]. No cost.
    #[default]
    Fixed,
    /// As many substeps as take at most this time \[ms\] in [`crate::Options::step`], from the times that the host reports
    /// ([`crate::Stepper::took`]); unchanged until it does. Above 0. A frame is modelled as a fixed part plus a part per
    /// step, so that normals and other work once per frame do not count as steps. Results then depend on the host's clock.
    Budget(f64),
    /// The fewest substeps, at most 256, that keep the error at or below this value; 1e-4 to 1, 0.01 is 1 %. The error is the
    /// largest stretch of a spring to the right or down (length / rest length - 1, not below 0) at the end of a frame,
    /// over cloths that are awake. Where cloth has a compliance or a material, only a share of a stretch is error, that
    /// which one relaxation takes away (`w dt^2 / (w dt^2 + compliance)`, w being the sum of the inverse masses): more
    /// than is left of relaxation rather than less. For a material the compliance is that of square cells.
    /// Rounds of polish are those of [`crate::Choice`], and do not change. Costs a pass over the particles per frame. Deterministic on the CPU; on the GPU the number changes when
    /// measurements have come back ([`crate::Stepper::settle`]), so runs repeat if the host waits for each frame before
    /// it settles.
    Error(f64),
    /// As `Error`, but never more substeps than `Budget` allows: the budget wins.
    ErrorWithin {
        /// As in `Error`.
        stretch: f64,
        /// As in `Budget`.
        ms: f64,
    },
}

impl Quality {
    /// What keeps the largest stretch at or below `stretch` and frames within `ms`, where these are given.
    pub fn of(stretch: Option<f64>, ms: Option<f64>) -> Self {
        match (stretch, ms) {
            (None, None) => Quality::Fixed,
            (None, Some(ms)) => Quality::Budget(ms),
            (Some(stretch), None) => Quality::Error(stretch),
            (Some(stretch), Some(ms)) => Quality::ErrorWithin { stretch, ms },
        }
    }

    pub(crate) fn check(self) -> Result<()> {
        if let Some(ms) = self.budget() {
            check("the budget [ms]", ms, "above 0", |b| b > 0.0)?;
        }
        if let Some(stretch) = self.target() {
            check("the error (largest stretch)", stretch, "1e-4 to 1", |e| (1e-4..=1.0).contains(&e))?;
        }
        Ok(())
    }

    /// The largest stretch that is asked for, if any.
    pub fn target(self) -> Option<f64> {
        match self {
            Quality::Error(stretch) | Quality::ErrorWithin { stretch, .. } => Some(stretch),
            _ => None,
        }
    }

    /// The time that is allowed \[ms\], if any.
    pub fn budget(self) -> Option<f64> {
        match self {
            Quality::Budget(ms) | Quality::ErrorWithin { ms, .. } => Some(ms),
            _ => None,
        }
    }
}

/// Most substeps that are chosen.
const MOST: u32 = 256;
/// The number falls if fewer substeps are foretold to leave this share of the target, and rises to aim at it.
const AIM: f64 = 0.85;
/// From a change to a rise \[s\]: the cloth is on its way.
const SOON: f64 = 0.05;
/// For so long fewer substeps must have been enough \[s\]; up to the second, where they turned out to be too few.
const PATIENCE: [f64; 2] = [0.25, 4.0];
/// Chooses the number of substeps, frame by frame.
#[derive(Clone, Debug)]
pub struct Chooser {
    /// Largest stretch of the last frame that was measured.
    pub error: Option<f64>,
    /// What has been measured since the last choice.
    fresh: Option<f64>,
    /// The largest since the number was changed, or fewer were thought of.
    worst: Option<f64>,
    /// Stepped since then \[s\].
    waited: f64,
    /// Stepped since the last choice \[s\].
    seconds: f64,
    /// What frames took.
    costs: Costs,
    patience: f64,
    fell: bool,
}

impl Default for Chooser {
    fn default() -> Self {
        let (error, fresh, worst) = (None, None, None);
        let costs = Costs::default();
        Chooser { error, fresh, worst, waited: 0.0, seconds: 0.0, costs, patience: PATIENCE[0], fell: false }
    }
}

impl Chooser {
    /// What it goes by beside the times of frames, which are the machine's; NaN for what is not known.
    pub fn numbers(&self) -> [f64; 7] {
        let known = |x: Option<f64>| x.unwrap_or(f64::NAN);
        let fell = f64::from(u8::from(self.fell));
        let [error, fresh, worst] = [self.error, self.fresh, self.worst].map(known);
        [error, fresh, worst, self.waited, self.seconds, self.patience, fell]
    }

    /// Takes them over from another one.
    pub fn resume(&mut self, [error, fresh, worst, waited, seconds, patience, fell]: [f64; 7]) {
        let known = |x: f64| Some(x).filter(|x| x.is_finite());
        (self.error, self.fresh, self.worst) = (known(error), known(fresh), known(worst));
        (self.waited, self.seconds) = (waited.max(0.0), seconds.max(0.0));
        (self.patience, self.fell) = (patience.max(PATIENCE[0]), fell > 0.0);
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
        self.costs.add(steps, ms);
    }

    /// The number of substeps from here on, `n` being that of the last frame.
    pub fn next(&mut self, quality: Quality, n: u32) -> u32 {
        if quality == Quality::Fixed || self.seconds == 0.0 {
            return n;
        }
        self.costs.age(self.seconds);
        self.waited += std::mem::take(&mut self.seconds);
        if let Some(error) = self.fresh.take() {
            self.error = Some(error);
            self.worst = Some(self.worst.map_or(error, |w| w.max(error)));
        }
        let room = quality.budget().and_then(|ms| self.costs.room(n, ms)).map(|room| room.min(MOST));
        let want = match (quality.target(), room) {
            (Some(target), _) => self.for_error(target, n),
            (None, Some(room)) => self.for_budget(room, n),
            (None, None) => n,
        };
        // A fall by more than a quarter at once would stir cloth at rest.
        let next = want.min(room.unwrap_or(MOST).max(n - n.div_ceil(4))).clamp(1, MOST);
        if next != n {
            // A rise after a fall: the fall was a mistake. A fall after a fall: the one before was none.
            self.patience = match (next > n, self.fell) {
                (true, true) => (2.0 * self.patience).min(PATIENCE[1]),
                (false, true) => PATIENCE[0],
                _ => self.patience,
            };
            self.fell = next < n;
            self.start_anew();
        }
        next
    }

    fn start_anew(&mut self) {
        (self.worst, self.waited) = (None, 0.0);
    }

    fn for_error(&mut self, target: f64, n: u32) -> u32 {
        let enough = |error: f64| (f64::from(n) * (error / (AIM * target)).sqrt()).ceil().min(f64::from(MOST)) as u32;
        match (self.error, self.worst) {
            (Some(error), Some(_)) if error > target && self.waited >= SOON => enough(error).min(n + (n / 4).max(1)),
            (_, Some(worst)) if self.waited >= self.patience => {
                self.start_anew();
                enough(worst).clamp(n - n.div_ceil(8), n)
            }
            _ => n,
        }
    }

    /// Not up and down with every frame.
    fn for_budget(&self, room: u32, n: u32) -> u32 {
        let more = (n / 8).max(1);
        if room >= n + more && self.waited >= self.patience { n + more } else { n.min(room) }
    }
}

#[cfg(test)]
#[path = "quality_tests.rs"]
mod tests;
