//! Which rectangle, and where on its border the boundary starts: searched on a coarse stand-in of the disk.

mod proxy;
mod search;
mod strip;
#[cfg(test)]
mod tests;

use crate::stage::cut::OpenSurface;
use crate::stage::parameterize::distortion;

pub(crate) use proxy::{Proxy, StandIn};
pub(crate) use search::Found;
pub use search::SearchOptions;

/// How large the image of a piece may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Exactly this many texels (width, height).
    Fixed(u32, u32),
    /// At most about this many texels, of any shape.
    Budget(u32),
}

/// A rectangle in cells (one less than texels) and the start of the boundary on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Cells across.
    pub w: u32,
    /// Cells down.
    pub h: u32,
    /// Steps from (0, 0) to the start of the boundary loop; whole unless the boundary has no node.
    pub shift: f64,
    /// Steps of each group of the border.
    pub count: Vec<u32>,
    /// Distortion of the stand-in: mean of ln(symmetric Dirichlet density / 4), 0 for an isometry.
    pub score: f64,
}

/// The least distorted layout of several ways to cut a surface, and the index of its cut. `None` if the border of none
/// fits the image.
pub fn choose(cuts: &[OpenSurface], size: Size, search: SearchOptions) -> Option<(usize, Layout)> {
    let mut best: Option<(Found, usize)> = None;
    for (k, open) in cuts.iter().enumerate() {
        let than = best.as_ref().map(|b| b.0.early);
        let found = Proxy::over(open, search).search_map(size, than);
        if let Some(found) = found.filter(|f| best.as_ref().is_none_or(|b| f.layout.score < b.0.layout.score)) {
            best = Some((found, k));
        }
    }
    best.map(|(found, k)| (k, found.layout))
}

/// Cells of an image of a size and aspect, or the smallest that holds `least` border steps. `None` if that is not the
/// fixed size, or more than an image can have.
pub(crate) fn cells(size: Size, aspect: f64, least: u32) -> Option<(u32, u32)> {
    match size {
        Size::Fixed(w, h) => (w >= 3 && h >= 3 && 2 * (w + h - 2) >= least).then(|| (w - 1, h - 1)),
        Size::Budget(texels) => {
            let t = f64::from(texels.max(9));
            let mut w = ((t * aspect).sqrt().floor() as u32).max(3);
            let mut h = (texels / w).max(3);
            while 2 * (w - 1 + h - 1) < least {
                if f64::from(w) <= aspect * f64::from(h) { w += 1 } else { h += 1 }
            }
            if u64::from(w) * u64::from(h) > t as u64 {
                let (long, short) = slender(texels, least).unwrap_or((w.max(h), w.min(h)));
                (w, h) = if w < h { (short, long) } else { (long, short) };
            }
            let most = u64::from(texels.saturating_mul(BEYOND).max(ALWAYS));
            (fits(w, h) && u64::from(w) * u64::from(h) <= most).then_some((w - 1, h - 1))
        }
    }
}

/// Largest image that a border may ask for, in budgets, and in texels: the fit of that of a net of 2,025 holes took 10 GB.
const BEYOND: u32 = 16;
const ALWAYS: u32 = 1 << 21;

/// Least texels across an image that is made longer to hold its border.
const LEAST_ACROSS: u32 = 8;

/// The least lopsided image (longer and shorter side in texels) that holds `least` border steps and has no more than
/// `texels`; `None` if it would be narrower than [`LEAST_ACROSS`]. A border is longer around a longer image of one area.
fn slender(texels: u32, least: u32) -> Option<(u32, u32)> {
    let both = f64::from(least.div_ceil(2)) + 2.0;
    let short = (0.5 * (both - (both * both - 4.0 * f64::from(texels)).max(0.0).sqrt())).floor() as u32;
    (short >= LEAST_ACROSS).then(|| (both as u32 - short, short))
}

/// Cells of an image whose border has exactly this many steps, of about an aspect. `None` if the steps are odd, too few or
/// too many.
fn exact_cells(aspect: f64, steps: u32) -> Option<(u32, u32)> {
    let half = (steps.is_multiple_of(2) && steps >= 8).then_some(steps / 2)?;
    let w = ((f64::from(half) * aspect / (1.0 + aspect)).round() as u32).clamp(2, half - 2);
    fits(w + 1, half - w + 1).then_some((w, half - w))
}

/// Whether an image of this many texels across and down can be stored.
fn fits(width: u32, height: u32) -> bool {
    width.max(height) <= gimage_bundle::MAX_SIDE
        && u64::from(width) * u64::from(height) <= u64::from(gimage_bundle::MAX_PARTICLES)
}

/// The smallest image (width, height in texels), square or nearly, that holds `least` border steps.
pub(crate) fn smallest(least: u32) -> (u32, u32) {
    let half = least.div_ceil(2).max(4);
    let w = half.div_ceil(2);
    (w + 1, (half - w).max(2) + 1)
}

/// Vertices where a map of the stand-in stretches most, at most `many`, the worst first, each at least `apart` from
/// the others and all `allowed`.
pub(crate) fn most_stretched(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    uv: &[[f64; 2]],
    many: usize,
    apart: f64,
    allowed: impl Fn(u32) -> bool,
) -> Vec<u32> {
    let mut order: Vec<(f64, usize)> = triangles
        .iter()
        .enumerate()
        .map(|(k, &t)| (distortion::triangle_stretch(positions, t, uv), k))
        .filter(|x| x.0.is_finite())
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut out: Vec<u32> = Vec::new();
    for (_, k) in order {
        if out.len() == many {
            break;
        }
        let far = |v: u32| {
            let p = positions[v as usize];
            out.iter().all(|&o| crate::base::vec3::distance(p, positions[o as usize]) > apart)
        };
        if let Some(v) = triangles[k].into_iter().find(|&v| allowed(v) && far(v)) {
            out.push(v);
        }
    }
    out
}
