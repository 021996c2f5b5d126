//! Twin of shaders/polish.wgsl: a round of polish, springs that move farther than their lengths ask.

use super::stretch::{self, Springs};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::number::real::Real;

/// How many times as far as their lengths ask springs move their ends in a round of polish.
///
/// Successive over-relaxation (D. Young, "Iterative Methods for Solving Partial Difference Equations of Elliptic Type",
/// Transactions of the AMS 1954), as far as an error spreads along the cloth in one round. On a T-shirt on moving arms 12
/// substeps with 8 rounds hold what 24 with 12 do without. From 1.9 on cloth trembles. The last round does not go too far:
/// its errors would be seen.
pub const OVER: f64 = 1.7;

/// Relaxes the springs of a colour, direction and parity, without compliance.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, springs: &mut Springs<T>, colour: (u32, u32)) {
    stretch::far(threads, sheet, springs, colour);
}
