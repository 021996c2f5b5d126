//! Keeps a chosen number of substeps up with what happens in a scene.

use super::speed::for_colliders;
use super::{FREE_SUBSTEPS, Settings, Wish, fall, hung, in_step, length};
use crate::options::Solver;
use crate::scene::Scene;

/// Seconds for which substeps stay high when what was fast is slow again.
const HOLD_S: f64 = 1.0;
/// Seconds for which cloth is stirred by a pin that moves.
const STIR_S: f64 = 0.1;

/// How many numbers a snapshot has of a [`Follow`].
pub const FOLLOW_NUMBERS: usize = 3;

/// Keeps a chosen number of substeps up with the speed of colliders, wind and pins, frame by frame.
#[derive(Clone, Debug)]
pub struct Follow {
    /// Substeps of cloth and colliders at rest; none where the host gave a number.
    lasting: Option<u32>,
    /// Substeps of hanging cloth that is stirred; 0 if there is none.
    stirred: u32,
    step: f64,
    /// For how long \[s\] the number stays; hanging cloth is stirred as long as that is more than [`HOLD_S`].
    hold: f64,
    /// Whether contact is swept.
    swept: bool,
}

impl Follow {
    pub fn new(settings: &Settings, scene: &Scene) -> Self {
        let given = settings.given();
        let open = given.substeps.is_none() && given.solver == Solver::Xpbd;
        let wishes = Wish::of(given, scene);
        let lasting =
            open.then(|| wishes.iter().map(|w| w.substeps).max().unwrap_or(in_step(FREE_SUBSTEPS, given.step)));
        let stirred = wishes.iter().map(|w| w.stirred).max().unwrap_or(0);
        let strength = length(scene.gravity.map(f64::from)).max(f64::MIN_POSITIVE);
        let falls = scene.cloths.iter().map(|c| fall(c, scene) / strength).fold(0.0, f64::max);
        let hung = scene.cloths.iter().filter(|_| stirred > 0);
        let swings = hung.map(|c| hung::swing_time(c, scene.gravity)).fold(0.0, f64::max);
        let hold = HOLD_S + falls.max(swings);
        Follow { lasting, stirred, step: given.step, hold, swept: given.solver == Solver::Xpbd }
    }

    /// Takes in that a cloth comes that asks for `wish`; more than that is held as long as `other` holds it.
    pub fn join(&mut self, wish: Wish, other: Option<&Follow>) {
        self.lasting = self.lasting.map(|now| now.max(wish.substeps));
        self.stirred = self.stirred.max(wish.stirred);
        self.hold = other.map_or(self.hold, |o| self.hold.max(o.hold));
    }

    /// Takes in that the cloth left that asked for `gone`; the others ask for at most `rest`.
    pub fn leave(&mut self, gone: Wish, rest: Wish) {
        self.lasting = self.lasting.map(|now| if now == gone.substeps { now.min(rest.substeps) } else { now });
        self.stirred = rest.stirred;
    }

    /// Takes in that pins of hanging cloth move.
    pub fn stir(&mut self) {
        if self.stirred > 0 {
            self.hold = self.hold.max(HOLD_S + STIR_S);
        }
    }

    /// The substeps of cloth and colliders at rest, NaN if the host gave a number, for how long \[s\] more than those stay, and those of cloth
    /// that is stirred.
    pub fn numbers(&self) -> [f64; FOLLOW_NUMBERS] {
        [self.lasting.map_or(f64::NAN, f64::from), self.hold, f64::from(self.stirred)]
    }

    /// Takes them over from another one; a number that the host gave stays.
    pub fn resume(&mut self, [lasting, hold, stirred]: [f64; FOLLOW_NUMBERS]) {
        if lasting >= 1.0 {
            self.lasting = self.lasting.map(|_| lasting as u32);
        }
        (self.hold, self.stirred) = (hold.max(0.0), stirred as u32);
    }

    /// To be called when steps have been made.
    pub fn stepped(&mut self, seconds: f64) {
        self.hold = (self.hold - seconds).max(0.0);
    }

    /// Substeps in which no collider moves far.
    pub fn fewest(&self, scene: &Scene) -> u32 {
        if self.swept { in_step(for_colliders(scene), self.step) } else { 1 }
    }

    /// The number of substeps from here on, `now` being that of the last frame: up at once, down by an eighth per frame.
    pub fn next(&mut self, now: u32, scene: &Scene) -> u32 {
        let Some(lasting) = self.lasting else { return now };
        let is_stirred = self.hold > HOLD_S || hung::is_windy(scene);
        let stirred = if is_stirred { self.stirred } else { 0 };
        let want = in_step(for_colliders(scene), self.step).max(lasting).max(stirred);
        if want >= now {
            self.hold = if want > lasting { self.hold.max(HOLD_S) } else { self.hold };
            return want;
        }
        if self.hold > 0.0 { now } else { (now - now.div_ceil(8)).max(want) }
    }
}
