//! The state of all cloths, and of what steps them.

use super::ClothState;
use crate::choose::FOLLOW_NUMBERS;
use crate::quality::NUMBERS;

/// The states of all cloths of a stepper, its clock, and the numbers by which it chooses substeps. Restored, the stepper
/// continues with the same bits if the host gives it the same colliders, wind and settings as before.
///
/// ```
/// use gimage_runtime::{Flat, Options, Scene, Snapshot, Stepper};
///
/// let mut scene = Scene::new("falling");
/// scene.cloths.push(Flat::square("square", 9).cloth()?);
/// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
/// stepper.advance(0.25)?;
/// let saved: Vec<u8> = stepper.snapshot()?.to_bytes();
/// stepper.advance(0.25)?;
/// stepper.restore(&Snapshot::from_bytes(&saved)?)?;
/// # Ok::<(), gimage_runtime::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    pub(crate) control: ControlState,
    pub(crate) cloths: Vec<ClothState>,
}

impl Snapshot {
    /// The states of the cloths, in the order of the scene.
    pub fn cloths(&self) -> &[ClothState] {
        &self.cloths
    }

    /// Time of the last step \[s\] since the start.
    pub fn time(&self) -> f64 {
        self.control.clock[0]
    }
}

/// The numbers of clock and choice. NaN stands for a number that is not known.
#[derive(Clone, Copy, Debug)]
pub struct ControlState {
    /// Time, length of the last step, time left over \[s\].
    pub clock: [f64; 3],
    /// As `Chooser::numbers`.
    pub chooser: [f64; NUMBERS],
    /// As `Follow::numbers`.
    pub follow: [f64; FOLLOW_NUMBERS],
    /// When cloths are next examined \[s\].
    pub due: f64,
    pub substeps: u32,
    pub polish: u32,
}

impl Default for ControlState {
    fn default() -> Self {
        let (clock, chooser, follow) = ([0.0; 3], [0.0; NUMBERS], [0.0; FOLLOW_NUMBERS]);
        ControlState { clock, chooser, follow, due: 0.0, substeps: 0, polish: 0 }
    }
}

impl PartialEq for ControlState {
    fn eq(&self, other: &Self) -> bool {
        // NaN is equal to NaN here.
        let bits = |s: &Self| s.numbers().map(f64::to_bits);
        bits(self) == bits(other) && (self.substeps, self.polish) == (other.substeps, other.polish)
    }
}

/// How many numbers of a control state are not whole.
pub const CONTROL_NUMBERS: usize = 3 + NUMBERS + FOLLOW_NUMBERS + 1;

impl ControlState {
    /// All numbers that are not whole, in one list.
    pub fn numbers(&self) -> [f64; CONTROL_NUMBERS] {
        let all = [&self.clock[..], &self.chooser, &self.follow, &[self.due]].concat();
        std::array::from_fn(|n| all[n])
    }

    /// The same from that list.
    pub fn from_numbers(all: [f64; CONTROL_NUMBERS], substeps: u32, polish: u32) -> Self {
        let [a, b, c, ..] = all;
        let [.., due] = all;
        let chooser = std::array::from_fn(|n| all[3 + n]);
        let follow = std::array::from_fn(|n| all[3 + NUMBERS + n]);
        ControlState { clock: [a, b, c], chooser, follow, due, substeps, polish }
    }
}
