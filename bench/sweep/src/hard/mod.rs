//! Meshes that are hard to map, by family, number and seed.

mod block;
mod broken;
mod flat;
mod round;
pub mod skirt;

use crate::random::Random;
use crate::shape::Shape;

/// Makes a mesh from random numbers and a hardness 0..=1.
type Make = fn(&mut Random, f64) -> Shape;

/// Every family by name.
pub const FAMILIES: [(&str, Make); 54] = [
    ("balloons", round::balloons),
    ("bipyramid", round::bipyramid),
    ("book", broken::book),
    ("bowties", broken::bowties),
    ("caps", broken::caps),
    ("coast", flat::coast),
    ("coincident", broken::coincident),
    ("comb", flat::comb),
    ("copies", broken::copies),
    ("cover", round::cover),
    ("crossing", broken::crossing),
    ("crumple", round::crumple),
    ("cubes", block::cubes),
    ("fan", round::fan),
    ("far", round::far),
    ("flipped", flat::flipped),
    ("graded", flat::graded),
    ("hair", broken::hair),
    ("handles", block::handles),
    ("hedgehog", round::hedgehog),
    ("junctions", broken::junctions),
    ("klein", round::klein),
    ("knot", broken::knot),
    ("koch", flat::koch),
    ("lace", flat::lace),
    ("maze", flat::maze),
    ("menger", block::menger),
    ("moebius", round::moebius),
    ("necks", flat::necks),
    ("needles", flat::needles),
    ("net", flat::net),
    ("percolation", flat::percolation),
    ("pinhole", round::pinhole),
    ("pleats", round::pleats),
    ("ribbon", flat::ribbon),
    ("ring", flat::ring),
    ("ruffle", round::ruffle),
    ("scale", round::scale),
    ("shaken", round::shaken),
    ("shell", round::shell),
    ("slits", flat::slits),
    ("slivers", flat::slivers),
    ("soup", broken::soup),
    ("spike", round::spike),
    ("spiral", flat::spiral),
    ("squeezed", round::squeezed),
    ("strainer", round::strainer),
    ("strip", broken::strip),
    ("tiles", broken::tiles),
    ("tree", block::tree),
    ("tube", round::tube),
    ("walk", block::walk),
    ("windings", broken::windings),
    ("zero", zero),
];

/// A value from `low` at 0 to `high` at 1, evenly spread in its logarithm.
fn between(t: f64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(t)
}

/// The same, rounded.
fn count(t: f64, low: f64, high: f64) -> usize {
    between(t, low, high).round() as usize
}

/// A sheet among whose triangles are some without area, and repeated corners.
fn zero(r: &mut Random, t: f64) -> Shape {
    let n = 6 + r.below(20);
    let mut s = Shape::sheet(n, n, |u, v| [u, v, 0.1 * (6.0 * u).cos()]);
    for k in 0..s.triangles.len() {
        if r.chance(t) {
            let [a, b, _] = s.triangles[k];
            s.triangles.push([a, b, b]);
        }
        if r.chance(0.3 * t) {
            // One position for two vertices takes the area of the triangles between them.
            let [a, b, _] = s.triangles[k];
            s.positions[a as usize] = s.positions[b as usize];
        }
    }
    s
}

/// The name of mesh `k`: its family and its number in it.
pub fn name(k: usize) -> String {
    format!("{}-{:02}", FAMILIES[k % FAMILIES.len()].0, k / FAMILIES.len())
}

/// Mesh `k` of `total`, with the name of its family. Families take turns; within one, meshes grow harder.
pub fn mesh(seed: u64, k: usize, total: usize) -> (String, Shape) {
    let n = FAMILIES.len();
    let ((_, make), variant) = (FAMILIES[k % n], k / n);
    let variants = total.saturating_sub(k % n).div_ceil(n).max(1);
    let hardness = if variants > 1 { variant as f64 / (variants - 1) as f64 } else { 1.0 };
    let mut random = Random::new(seed, k as u64);
    (name(k), make(&mut random, hardness))
}

#[cfg(test)]
mod tests;
