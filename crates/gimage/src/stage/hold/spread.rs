//! From the points where a garment rests to its pins and limits.

use super::rest::Rest;
use super::sheet::Sheet;

/// Which points are pinned: those that are held, and what is within the band around them.
pub(super) fn pinned(sheet: &Sheet, rest: &Rest) -> Vec<bool> {
    sheet.distances(rest.points.iter().copied(), rest.band).iter().map(|d| d.is_finite()).collect()
}

/// Share of the area of a garment.
pub(super) fn share(sheet: &Sheet, chosen: &[bool]) -> f64 {
    let total: f64 = sheet.areas.iter().sum();
    let part: f64 = sheet.areas.iter().zip(chosen).filter(|x| *x.1).map(|x| x.0).sum();
    // The sum of nothing is -0.
    if total > 0.0 { part / total + 0.0 } else { 0.0 }
}

/// The limit \[m\] of each point, 0 for pinned ones, at least `least` \[m\] for others and infinite beyond `reach` \[m\] from them.
///
/// At the distance g from the pins it is the larger one of `least` and 2 g (g / reach)^2, which is 2 g where limits end. Cloth that does not stretch is
/// never farther than 2 g from its place on the skin, so that nothing jumps where limits begin and end. Solids in place of a body are some way off its surface: a smaller limit would draw cloth
/// into them while contact pushes it out.
pub(super) fn limits(sheet: &Sheet, pinned: &[bool], least: f64, reach: f64) -> Vec<f64> {
    let from = (0..pinned.len() as u32).filter(|&p| pinned[p as usize]);
    let far = sheet.distances(from, reach);
    let limit = |g: f64| if g < reach { least.max(2.0 * g * (g / reach).powi(2)) } else { f64::INFINITY };
    far.into_iter().zip(pinned).map(|(g, pinned)| if *pinned { 0.0 } else { limit(g) }).collect()
}
