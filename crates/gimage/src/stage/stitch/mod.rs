//! Stitches: pieces that touch or overlap without sharing vertices are tied to each other.
//!
//! A garment of several components falls apart in motion. As a seamstress would, borders are tied: of two pieces that lie on each
//! other, the border of the smaller one is sewn to the surface of the larger one, where it lies on it for some length. Pieces
//! without a border there, such as a belt that is a closed shell, get a sparse set of stitches all over.

mod choose;
mod loose;
mod panel;
mod partly;
mod reach;
mod report;
mod thread;

use std::fmt;
use std::str::FromStr;

use gimage_bundle::{Bundle, Image, MapKind, NO_STITCH};

use crate::error::{Error, Result};
use crate::options::{Range, stage_options};
use crate::record::Finding;
use crate::stage::assemble::{Family, Piece};
use choose::groups;
use panel::{Panel, panels};
use thread::{Seamstress, Sewn, Texels};

/// How far apart points of two pieces may be that are stitched together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stitching {
    /// Estimated from the distances between borders and other pieces.
    Auto,
    /// No stitches.
    None,
    /// At most this distance \[m\].
    Within(f64),
}

impl fmt::Display for Stitching {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stitching::Auto => f.write_str("auto"),
            Stitching::None => f.write_str("none"),
            Stitching::Within(distance) => write!(f, "{distance}"),
        }
    }
}

impl FromStr for Stitching {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let distance = || text.parse().ok().filter(|d: &f64| *d > 0.0 && d.is_finite());
        match text {
            "auto" => Ok(Stitching::Auto),
            "none" => Ok(Stitching::None),
            _ => distance().map(Stitching::Within).ok_or_else(|| Error::Option {
                option: "stitch".into(),
                problem: format!("`{text}` is neither auto, none nor a distance above 0"),
                hint: "give metres, for example 0.004".into(),
            }),
        }
    }
}

stage_options! {
    /// Options of [`stitch`].
    #[derive(Copy)]
    pub struct StitchOptions of "stitch" {
        /// Tie pieces that touch or overlap without sharing vertices, where they are at most this distance apart; auto estimates
        /// the distance, none leaves every piece to itself.
        pub stitch: Stitching = Stitching::Auto => "stitch" ["m"] Range::Above(0.0);
    }
}

/// Adds stitches between the pieces of a bundle that has their positions and pins, and recomputes its tethers, which lead over them. Returns what is worth reporting about them.
/// Costs about 10 us per border point and piece nearby.
pub fn stitch(
    bundle: &mut Bundle,
    pieces: &[Piece<'_>],
    families: &[Family<'_>],
    options: &StitchOptions,
) -> Result<Vec<Finding>> {
    if pieces.len() < 2 {
        return Ok(Vec::new());
    }
    let panels = panels(pieces, families, bundle);
    let diagonal = reach::diagonal(&panels);
    let (most, estimated) = match options.stitch {
        Stitching::None => return Ok(findings(&panels, &[], (0.0, false))),
        Stitching::Within(distance) => (distance, false),
        Stitching::Auto => (reach::estimate(&border_distances(&panels), diagonal), true),
    };
    let all = AllTexels::new(bundle)?;
    let sizes = bundle.manifest.pieces.iter().map(|p| [p.width, p.height]).collect();
    let mut sewing = Seamstress::new(&panels, sizes, all.texels());
    choose::borders(&mut sewing, most, diagonal, |_, _| true);
    for own in 0..panels.len() {
        // A panel that no border ties to one that is held, such as a closed belt.
        if !is_held(&panels, &groups(panels.len(), &sewing.sewn))[own] {
            choose::all_over(&mut sewing, own, most, |_, _| true);
        }
    }
    let (mut farther, mut askew) = (Vec::new(), Vec::new());
    if estimated && panels.iter().any(|p| p.pinned) {
        farther = loose::tie(&mut sewing, most, diagonal);
        let is_tied = |partly: &partly::Partly| farther.iter().any(|(k, _)| *k == partly.panel);
        let partly = partly::partly(&panels, most, diagonal).into_iter().filter(|p| !is_tied(p)).collect::<Vec<_>>();
        let (few, some): (Vec<_>, Vec<_>) = partly.into_iter().partition(partly::Partly::is_few);
        for partly::Partly { panel, far, .. } in few {
            choose::borders(&mut sewing, far, diagonal, |a, b| a == panel || b == panel);
            farther.push((panel, far));
        }
        askew = some;
    }
    let sewn = sewing.sewn;
    write(bundle, &sewn)?;
    if !sewn.is_empty() && panels.iter().any(|p| p.pinned) {
        bundle.write_tethers()?;
    }
    let mut findings = findings(&panels, &sewn, (most, estimated));
    findings.extend(report::farther(&farther.iter().map(|(k, far)| (&panels[*k], *far)).collect::<Vec<_>>()));
    findings.extend(report::partly(&askew.into_iter().map(|p| (&panels[p.panel], p)).collect::<Vec<_>>()));
    Ok(findings)
}

/// Distances of border points to the nearest other panel \[m\], as far as an estimate asks for them.
fn border_distances(panels: &[Panel]) -> Vec<f64> {
    let most = reach::farthest(panels);
    let of = |(own, panel): (usize, &Panel)| {
        let near = panel.loops.iter().flat_map(move |points| reach::nearest(panels, own, points, most));
        near.flatten().map(|near| near.distance).collect::<Vec<_>>()
    };
    panels.iter().enumerate().flat_map(of).collect()
}

/// For each panel whether it hangs together with a pinned one, or, if no panel is pinned, with the largest.
fn is_held(panels: &[Panel], groups: &[u32]) -> Vec<bool> {
    let largest = (0..panels.len()).max_by(|a, b| panels[*a].area.total_cmp(&panels[*b].area).then(b.cmp(a)));
    let any = panels.iter().any(|p| p.pinned);
    let holds = |k: usize| if any { panels[k].pinned } else { Some(k) == largest };
    groups.iter().map(|group| (0..panels.len()).any(|k| groups[k] == *group && holds(k))).collect()
}

/// The texels of a bundle as [`Seamstress`] reads them.
struct AllTexels {
    positions: Vec<[f64; 3]>,
    pinned: Vec<bool>,
    points: Vec<u32>,
}

impl AllTexels {
    fn new(bundle: &Bundle) -> Result<Self> {
        let particles = bundle.particles()?;
        let at = |k: u32| bundle.position(k).unwrap_or_default().map(f64::from);
        let mut points: Vec<u32> = (0..particles.len() as u32).collect();
        for ring in bundle.rings()?.iter() {
            ring.iter().for_each(|k| points[*k as usize] = ring[0]);
        }
        Ok(AllTexels {
            positions: (0..particles.len() as u32).map(at).collect(),
            pinned: particles.iter().map(|p| p.is_pinned()).collect(),
            points,
        })
    }

    fn texels(&self) -> Texels<'_> {
        Texels { positions: &self.positions, pinned: &self.pinned, points: &self.points }
    }
}

/// Writes stitches as maps; a piece without a stitch gets none.
fn write(bundle: &mut Bundle, sewn: &[Sewn]) -> Result<()> {
    for k in 0..bundle.manifest.pieces.len() {
        let piece = &bundle.manifest.pieces[k];
        let (first, width, height) = (piece.first_particle, piece.width, piece.height);
        let mut data = NO_STITCH.repeat((width * height) as usize);
        let mut any = false;
        for Sewn { stitch, .. } in sewn {
            if let Some(at) = stitch.particle.checked_sub(first).filter(|at| *at < width * height) {
                let value = [stitch.piece as f32, stitch.at[0], stitch.at[1], stitch.distance];
                data[4 * at as usize..][..4].copy_from_slice(&value);
                any = true;
            }
        }
        if any {
            bundle.insert(k, MapKind::Stitch, Image { width, height, channels: 4, data })?;
        }
    }
    Ok(())
}

/// The findings of what was sewn up to a distance \[m\], and what is loose.
fn findings(panels: &[Panel], sewn: &[Sewn], (most, estimated): (f64, bool)) -> Vec<Finding> {
    let joined = |k: usize| sewn.iter().any(|s| s.from == k || s.to == k);
    let tied: Vec<&Panel> = (0..panels.len()).filter(|k| joined(*k)).map(|k| &panels[k]).collect();
    let mut out = Vec::new();
    if !sewn.is_empty() {
        out.push(report::sewn(sewn.len(), &tied, most, estimated));
    }
    if panels.iter().any(|p| p.pinned) {
        let held = is_held(panels, &groups(panels.len(), sewn));
        let loose = (0..panels.len()).filter(|k| !held[*k]).map(|k| (&panels[k], gap(panels, k)));
        out.extend(report::loose(&loose.collect::<Vec<_>>()));
    }
    out
}

/// Distance \[m\] of a panel to the nearest other one: of its borders, or of all its points where it has none.
fn gap(panels: &[Panel], own: usize) -> Option<f64> {
    let panel = &panels[own];
    let points = if panel.loops.is_empty() { panel.points.clone() } else { panel.loops.concat() };
    let others = || panels.iter().enumerate().filter(|(k, _)| *k != own).map(|(_, p)| p);
    let far = points.iter().flat_map(|point| others().filter_map(|p| p.distance(point.at)));
    far.min_by(f64::total_cmp)
}
