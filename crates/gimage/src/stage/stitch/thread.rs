//! Stitches as they are made: at most one per point, none where the other panel is sewn to this one already, and few enough at
//! every corner that each is strong.

use std::collections::BTreeMap;

use gimage_bundle::{Place, Stitch};

use super::choose::stitch;
use super::panel::{Panel, Point, Texel};
use crate::base::vec3::distance;

/// Stitches that share a particle, at most: each moves it by its share only.
const MOST_AT_A_POINT: u32 = 12;

/// A stitch between two panels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sewn {
    /// The panel of its particle.
    pub from: usize,
    /// The panel that it is tied to.
    pub to: usize,
    /// The stitch.
    pub stitch: Stitch,
}

/// Sews, one seam after the other.
pub(super) struct Seamstress<'a> {
    /// The panels.
    pub panels: &'a [Panel],
    /// Width and height of each piece.
    pub sizes: Vec<[u32; 2]>,
    /// Index of the first particle of each piece.
    pub firsts: Vec<u32>,
    /// Positions as the bundle stores them \[m\], of all texels.
    pub positions: &'a [[f64; 3]],
    /// Whether a texel is pinned.
    pub pinned: &'a [bool],
    /// For each texel the first of its duplicates.
    pub points: &'a [u32],
    /// The stitches so far.
    pub sewn: Vec<Sewn>,
    /// Stitches at each point.
    counts: BTreeMap<u32, u32>,
    /// Where panels are sewn to each other: of the panel of the particle and of the other, the positions \[m\].
    seams: BTreeMap<(usize, usize), Vec<[f64; 3]>>,
}

impl<'a> Seamstress<'a> {
    /// Without a stitch so far. Arguments are the fields.
    pub fn new(panels: &'a [Panel], sizes: Vec<[u32; 2]>, texels: Texels<'a>) -> Self {
        let firsts = sizes.iter().scan(0, |end, [w, h]| Some(std::mem::replace(end, *end + w * h))).collect();
        let Texels { positions, pinned, points } = texels;
        let (counts, seams) = Default::default();
        Seamstress { panels, sizes, firsts, positions, pinned, points, sewn: Vec::new(), counts, seams }
    }

    fn index(&self, texel: Texel) -> u32 {
        self.firsts[texel.piece] + texel.texel
    }

    /// Sews points of a panel, each to the panel beside it.
    pub fn seam(&mut self, from: usize, points: impl Iterator<Item = (Point, usize)>) {
        for (point, to) in points {
            let apart = 1.5 * (self.panels[from].spacing + self.panels[to].spacing);
            let beside = self.seams.get(&(to, from)).into_iter().flatten();
            if to == from || beside.into_iter().any(|p| distance(*p, point.at) < apart) {
                continue;
            }
            let particle = self.index(point.texel);
            let place = |piece: usize, k: u32| self.positions[(self.firsts[piece] + k) as usize];
            let found = stitch(&point, &self.panels[to], particle, &self.sizes, place);
            if let Some(stitch) = found.filter(|s| self.is_useful(s)) {
                for k in self.touched(&stitch) {
                    *self.counts.entry(k).or_default() += 1;
                }
                self.sewn.push(Sewn { from, to, stitch });
                self.seams.entry((from, to)).or_default().push(point.at);
            }
        }
    }

    /// The points that a stitch moves.
    fn touched(&self, stitch: &Stitch) -> Vec<u32> {
        let [width, height] = self.sizes[stitch.piece as usize];
        let quad = Place::of(width, height, stitch.at);
        let corners = quad.corners(width).into_iter().zip(quad.shares());
        let target = corners.filter(|(_, share)| *share > 0.0).map(|(k, _)| self.firsts[stitch.piece as usize] + k);
        target.chain([stitch.particle]).map(|k| self.points[k as usize]).collect()
    }

    /// Whether a stitch moves a particle that is not pinned, and each of its points has room for another stitch.
    fn is_useful(&self, stitch: &Stitch) -> bool {
        let touched = self.touched(stitch);
        let full = |k: &u32| self.counts.get(k).is_some_and(|n| *n >= MOST_AT_A_POINT);
        touched.iter().any(|k| !self.pinned[*k as usize]) && !touched.iter().any(full)
    }
}

/// All texels of a bundle.
#[derive(Clone, Copy)]
pub(super) struct Texels<'a> {
    /// [`Seamstress::positions`].
    pub positions: &'a [[f64; 3]],
    /// [`Seamstress::pinned`].
    pub pinned: &'a [bool],
    /// [`Seamstress::points`].
    pub points: &'a [u32],
}
