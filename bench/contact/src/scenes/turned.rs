//! Scenes whose ends are turned: pins that move around an axis.

use gimage_runtime::{Flat, Scene};

use super::action::{Action, Turn};
use super::tube::{Tube, tube};
use super::{Failure, calm};

/// Pins both ends of the only cloth, which turn against each other for some time \[s\].
fn turns(
    scene: &mut Scene,
    [first, last]: [Vec<u32>; 2],
    axis: usize,
    (rate, until_s): (f64, f64),
) -> Result<Vec<Action>, Failure> {
    let mut turns = Vec::new();
    for (pins, rate) in [(first, rate), (last, -rate)] {
        let cloth = &mut scene.cloths[0];
        pins.iter().try_for_each(|k| cloth.set_pinned(*k as usize, true))?;
        let start = pins.iter().map(|k| cloth.positions()[*k as usize]).collect();
        turns.push(Action::Turn(Turn { pins, start, axis, rate, until_s }));
    }
    Ok(turns)
}

/// A square whose left and right ends turn at pi/3 rad/s for 10 s, without gravity (a scene of newton, which has 50 x 50 cells).
pub fn twist(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    let flat = Flat { origin: [-0.5, 0.0, -0.5], ..Flat::square("sheet", n) };
    scene.cloths.push(calm(flat.cloth()?));
    (scene.gravity, scene.frames) = ([0.0; 3], 600);
    let ends = [0, n - 1].map(|column| (0..n).map(|row| row * n + column).collect());
    turns(scene, ends, 0, (std::f64::consts::FRAC_PI_3, 10.0))
}

/// A tube with `n` particles around whose ends turn by 360 degrees per second (a scene of ppf-contact-solver, which has 360 around and 204,000
/// vertices).
pub fn wrung(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    let rows = n;
    let cloth = tube(&Tube { name: "tube", around: n, rows, radii: [0.15, 0.15], length: 0.8 })?;
    scene.cloths.push(calm(cloth));
    (scene.gravity, scene.frames) = ([0.0; 3], 430);
    let ends = [0, rows - 1].map(|row| (row * n..(row + 1) * n).collect());
    turns(scene, ends, 1, (std::f64::consts::TAU, 1e9))
}
