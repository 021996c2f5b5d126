//! Pieces that nothing holds are tied from farther away than others: in motion they would fall off.

use super::choose::{self, groups};
use super::is_held;
use super::thread::Seamstress;

/// Factor from one distance to the next.
const WIDER: f64 = 1.5;
/// A border is sewn as far as this many times the least distance that ties it: there, it is held in a few places only.
const ALONG: f64 = 2.5;
/// Largest distance, in shares of the diagonal of the garment: 15 mm on one of 1.5 m.
const WIDEST: f64 = 0.01;

/// Ties panels that nothing holds to those that are held, if any is pinned, at the least distance above `most` \[m\] that does, and then along their
/// borders. Returns them, and the distances \[m\] up to which they are sewn.
pub(super) fn tie(sewing: &mut Seamstress<'_>, most: f64, diagonal: f64) -> Vec<(usize, f64)> {
    let panels = sewing.panels;
    let (mut tied, mut distance, widest) = (Vec::new(), most, WIDEST * diagonal);
    while panels.iter().any(|p| p.pinned) && distance < widest {
        distance = (WIDER * distance).min(widest);
        loop {
            let held = is_held(panels, &groups(panels.len(), &sewing.sewn));
            let between = |a: usize, b: usize| held[a] != held[b];
            choose::borders(sewing, distance, diagonal, between);
            for own in (0..panels.len()).filter(|own| !held[*own]) {
                if !is_held(panels, &groups(panels.len(), &sewing.sewn))[own] {
                    choose::all_over(sewing, own, distance, between);
                }
            }
            let now = is_held(panels, &groups(panels.len(), &sewing.sewn));
            let came: Vec<usize> = (0..panels.len()).filter(|k| now[*k] && !held[*k]).collect();
            // Others that hang on it may be tied now.
            if came.is_empty() {
                break;
            }
            let along = (ALONG * distance).min(widest);
            choose::borders(sewing, along, diagonal, |a, b| between(a, b) && now[a] && now[b]);
            tied.extend(came.into_iter().map(|k| (k, along)));
        }
    }
    tied
}
