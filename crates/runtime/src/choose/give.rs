//! How far cloth with a compliance stretches under its own weight, and what this asks for.

use crate::cloth::{Cloth, Compliance};

/// Extension from which stretch by compliance is seen, and tethers and rounds of polish must not hide it.
const VISIBLE: f64 = 0.002;
/// Relaxations per frame in which scene s1k of 32 x 32 particles, whose springs give by [`SEEN_GIVE`] at the pins, has its
/// largest stretch to within 4 %.
const RELAXATIONS: f64 = 128.0;
const SEEN_GIVE: f64 = 0.03;
/// Most substeps of such cloth; further relaxations are rounds of polish.
const MAX_SUBSTEPS: f64 = 64.0;

/// Extension of the springs at the pins, as a share of their length, if each pin holds its share of the weight by one spring. It
/// is above the largest extension of cloth that hangs still. 0 of cloth without compliance, and of cloth that no pin holds.
pub fn at_pins(cloth: &Cloth, gravity: [f32; 3]) -> f64 {
    let soft = match &cloth.compliance {
        Compliance::None => 0.0,
        Compliance::Constant(soft) => f64::from(*soft),
        Compliance::Image(soft) => mean(soft.iter().flatten().map(|s| f64::from(*s))),
    };
    let pins = super::pins(cloth);
    if cloth.membrane().is_some() || soft <= 0.0 || pins == 0 {
        return 0.0;
    }
    let weight =
        (0..cloth.len()).map(|k| f64::from(cloth.mass(k))).sum::<f64>() * super::length(gravity.map(f64::from));
    let grids = cloth.grids().iter().enumerate();
    let texels = grids.flat_map(|(g, grid)| (0..grid.range().len()).flat_map(move |k| [(g, k, 0), (g, k, 1)]));
    let spring = mean(texels.map(|(g, k, direction)| f64::from(cloth.spring(g, k, direction))));
    if spring > 0.0 { weight / pins as f64 * soft / spring } else { 0.0 }
}

/// The substeps and rounds of polish in which cloth of `side` particles per side, with this extension at its pins, stretches by its
/// compliance and not by the solver's error; none where its stretch is not seen.
///
/// The error of a substep's springs grows as the cube of the side and falls with the square of the number of relaxations.
pub fn relaxed(side: f64, give: f64) -> Option<(u32, u32)> {
    let all = RELAXATIONS * (side / 32.0).powf(1.5) * (SEEN_GIVE / give).sqrt();
    let all = all.clamp(super::FREE_SUBSTEPS.into(), RELAXATIONS);
    (give >= VISIBLE).then(|| (all.min(MAX_SUBSTEPS).ceil() as u32, (all / MAX_SUBSTEPS).ceil() as u32 - 1))
}

/// The mean of what is above 0; 0 if nothing is.
fn mean(all: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = all.filter(|x| *x > 0.0).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    sum / f64::max(count, 1.0)
}
