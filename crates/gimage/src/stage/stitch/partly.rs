//! Borders that are sewn along a part of the length that is near other panels: a panel that hangs on such a border hangs askew.

use super::panel::{Panel, share};
use super::reach::{RANGE, nearest};

/// Smallest share of the area of the garment of a panel that is looked at: pockets and flaps are sewn along a part on purpose.
const LARGE: f64 = 0.1;
/// Largest share of the length near other panels that counts as a part.
const PART: f64 = 0.6;
/// Share below which it is sewn along the rest too: a skirt on a twelfth of its waist hangs from its side.
const FEW: f64 = 0.25;

/// A panel of which a border is sewn along a part.
pub(super) struct Partly {
    pub panel: usize,
    /// Length that is within the distance of a seam, and within `far`, of other panels \[m\].
    pub lengths: [f64; 2],
    /// The largest distance that an estimate may have \[m\].
    pub far: f64,
}

impl Partly {
    /// Whether so little is sewn that the rest is sewn too.
    pub fn is_few(&self) -> bool {
        self.lengths[0] < FEW * self.lengths[1]
    }
}

/// Large panels without pins of which borders are within `most` \[m\] of others along a part of the length that is within the largest distance of an
/// estimate.
pub(super) fn partly(panels: &[Panel], most: f64, diagonal: f64) -> Vec<Partly> {
    let far = RANGE[1] * diagonal;
    let all: f64 = panels.iter().map(|p| p.area).sum();
    let within = |own: usize, distance: f64| -> f64 {
        let of = |points: &Vec<_>| {
            let near = nearest(panels, own, points, distance);
            (0..points.len()).filter(|k| near[*k].is_some()).map(|k| share(points, k)).sum::<f64>()
        };
        panels[own].loops.iter().map(of).sum()
    };
    let large = (0..panels.len()).filter(|k| !panels[*k].pinned && panels[*k].area >= LARGE * all && most < far);
    large
        .filter_map(|panel| {
            let lengths = [most, far].map(|distance| within(panel, distance));
            (lengths[0] > 0.0 && lengths[0] < PART * lengths[1]).then_some(Partly { panel, lengths, far })
        })
        .collect()
}
