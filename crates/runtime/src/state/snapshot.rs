//! The state of all cloths, and of what steps them.

use super::ClothState;

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
#[derive(Clone, Copy, Debug, Default)]
pub struct ControlState {
    /// Time, length of the last step, time left over \[s\].
    pub clock: [f64; 3],
    /// As `Chooser::numbers`.
    pub chooser: [f64; 7],
    /// As `Follow::numbers`.
    pub follow: [f64; 2],
    /// When cloths are next examined \[s\].
    pub due: f64,
    pub substeps: u32,
    pub polish: u32,
}

impl PartialEq for ControlState {
    fn eq(&self, other: &Self) -> bool {
        // NaN is equal to NaN here.
        let bits = |s: &Self| s.numbers().map(f64::to_bits);
        bits(self) == bits(other) && (self.substeps, self.polish) == (other.substeps, other.polish)
    }
}

impl ControlState {
    /// All numbers that are not whole, in one list.
    pub fn numbers(&self) -> [f64; 13] {
        let ([a, b, c], [d, e, f, g, h, i, j], [k, l]) = (self.clock, self.chooser, self.follow);
        [a, b, c, d, e, f, g, h, i, j, k, l, self.due]
    }

    /// The same from that list.
    pub fn from_numbers([a, b, c, d, e, f, g, h, i, j, k, l, due]: [f64; 13], substeps: u32, polish: u32) -> Self {
        ControlState { clock: [a, b, c], chooser: [d, e, f, g, h, i, j], follow: [k, l], due, substeps, polish }
    }
}
