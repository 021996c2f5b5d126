//! A cloth in motion under the XPBD solver: sheets, what holds them, and the passes that step them.

mod air;
mod anchors;
mod backstop;
mod bend;
mod coarse_level;
mod coarse_ties;
mod cut_levels;
mod cuts;
pub(crate) mod drift;
mod follow;
mod forget;
mod integrate_rows;
mod laplacian;
pub(crate) mod leaves;
mod limit;
pub(crate) mod meeting;
mod membrane;
mod moments;
pub(crate) mod partners;
pub(crate) mod polish;
mod pyramid;
mod refine;
mod seam_moments;
pub(crate) mod seam_steps;
mod separate;
mod sew;
mod share;
mod steps;
mod stitch;
pub(crate) mod stretch;
mod sweep;
mod tethers;
mod texels;
mod tile_pairs;
pub(crate) mod touch;
mod touching;
pub(crate) mod tree;

use std::sync::Arc;

use self::anchors::Places;
use self::backstop::Backstop;
use self::follow::Follow;
use self::limit::Limit;
use self::meeting::Meeting;
use self::membrane::Cells;
use self::moments::Plate;
use self::pyramid::Pyramid;
use self::seam_steps::Member;
use self::stitch::Stitches;
use self::stretch::Springs;
use self::tethers::Tethers;
use super::contact::clear::Clear;
use super::sheet::Sheet;
use super::surface::Worn;
use crate::cloth::{self, Cloth};
use crate::levels::ties::{Ties, ties};
use crate::levels::{levels, masses};
use crate::number::aligned::Aligned;
use crate::number::real::Real;
use crate::options::Options;
use crate::passes::{Pass, has_levels};

/// Sheets of a cloth, and where its particles lie in them.
pub struct Fabric<T: Real> {
    sheets: Vec<Sheet<T>>,
    springs: Vec<[Springs<T>; 4]>,
    pyramids: Vec<Pyramid<T>>,
    ties: Vec<Ties>,
    /// As [`masses`], where there are pyramids.
    masses: Arc<Vec<f64>>,
    /// One a sheet, of cloth of a material.
    cells: Arc<Vec<Cells<T>>>,
    /// One a sheet, of cloth that bends.
    plates: Vec<Plate<T>>,
    tethers: Arc<Vec<Tethers<T>>>,
    /// One a sheet, of cloth that has any.
    limits: Vec<Limit<T>>,
    /// One a sheet, of cloth that has any.
    backstops: Vec<Backstop<T>>,
    /// One a sheet, of cloth that follows joints.
    follows: Vec<Follow<T>>,
    /// Of cloth that has any.
    stitches: Option<Stitches<T>>,
    anchors: Arc<Vec<Member>>,
    places: Places<T>,
    /// Those of every ring.
    members: Arc<Vec<Member>>,
    starts: Arc<Vec<u32>>,
    firsts: Vec<usize>,
    /// Whether all texels of a sheet are particles.
    whole: Vec<bool>,
    /// One a sheet.
    clear: Vec<Clear<T>>,
    /// The surface of a body that the cloth is worn on.
    worn: Option<Worn<T>>,
    /// Of cloth that has contact with cloth.
    meeting: Option<Meeting<T>>,
    /// The passes of the next walk, kept for its memory; empty between steps.
    together: Vec<Pass>,
    /// Accelerations by air, by texels, and of each sheet as its positions lie.
    field: Vec<[T; 4]>,
    fields: Vec<Aligned<T>>,
    /// Velocities of the air at particles, of each sheet as its positions lie, and by texels where sheets have gaps.
    airs: Vec<Aligned<T>>,
    airs_of_texels: Vec<[T; 4]>,
}

impl<T: Real> Fabric<T> {
    /// Room for a cloth; [`Fabric::load`] fills it.
    pub fn new(cloth: &Cloth, held: &cloth::Tethers, options: &Options) -> Self {
        let sheets: Vec<Sheet<T>> = cloth.grids().iter().map(Sheet::new).collect();
        let firsts = cloth.grids().iter().map(|g| g.first as usize).collect();
        let (starts, members) = cloth.ring_lists();
        let springs = sheets.iter().enumerate().map(|(g, sheet)| stretch::springs(cloth, g, sheet)).collect();
        let grids = if has_levels(cloth, options) { 0..sheets.len() } else { 0..0 };
        let masses = if grids.is_empty() { Vec::new() } else { masses(cloth) };
        let pyramids: Vec<Pyramid<T>> =
            grids.map(|g| Pyramid::new(&levels(cloth, g, &masses), sheets[g].width)).collect();
        let (cells, plates) = (membrane::cells(cloth, &sheets), moments::plates(cloth, &sheets));
        let mut fabric = Fabric {
            springs,
            ties: if pyramids.is_empty() { Vec::new() } else { ties(cloth) },
            pyramids,
            masses: Arc::new(masses),
            cells: Arc::new(cells),
            plates,
            limits: limit::limits(cloth, &sheets),
            backstops: backstop::backstops(cloth, &sheets),
            follows: Vec::new(),
            worn: None,
            meeting: Meeting::of(cloth, &sheets, options.thickness),
            stitches: None,
            sheets,
            whole: cloth.grids().iter().map(|g| cloth.particles()[g.range()].iter().all(|p| p.exists())).collect(),
            tethers: Default::default(),
            anchors: Default::default(),
            places: Places::default(),
            members: Default::default(),
            starts,
            firsts,
            clear: cloth.grids().iter().map(|_| Clear::default()).collect(),
            together: Vec::new(),
            field: Vec::new(),
            fields: Vec::new(),
            airs: Vec::new(),
            airs_of_texels: Vec::new(),
        };
        fabric.worn = Worn::of(cloth, &fabric.sheets, options.thickness, |k| {
            let (sheet, at) = fabric.place(k);
            (sheet as usize, single(at as usize, fabric.sheets[sheet as usize].half), at as usize)
        });
        let members = members.iter().map(|k| fabric.member(*k)).collect();
        let stitches = stitch::stitches(cloth, |k| fabric.member(k));
        (fabric.members, fabric.stitches) = (Arc::new(members), stitches);
        let of = |t: usize| held.anchors.get(t).filter(|a| a.exists());
        fabric.hold(held.per_particle, |t| of(t).map(|a| (a.particle, T::of(f64::from(a.distance)))));
        fabric
    }

    fn place(&self, k: usize) -> (u32, u32) {
        let g = self.firsts.partition_point(|f| *f <= k) - 1;
        (g as u32, self.sheets[g].triple(k - self.firsts[g]) as u32)
    }

    /// Where a particle lies in the sheets.
    pub fn member(&self, k: u32) -> Member {
        let (sheet, at) = self.place(k as usize);
        Member { sheet, at, single: single(at as usize, self.sheets[sheet as usize].half) as u32 }
    }

    /// Takes over the tethers, `slots` per particle: the pin and the distance \[m\] of each, by particle and slot.
    pub fn hold(&mut self, slots: usize, held: impl Fn(usize) -> Option<(u32, T)>) {
        let count: usize = self.sheets.iter().map(|s| s.width * s.height).sum();
        let mut order: Vec<u32> = (0..count * slots).filter_map(|t| Some(held(t)?.0)).collect();
        order.sort_unstable();
        order.dedup();
        self.anchors = Arc::new(order.iter().map(|k| self.member(*k)).collect());
        self.places = Places::default();
        let mut tethers = Vec::with_capacity(self.sheets.len());
        for (g, sheet) in self.sheets.iter().enumerate() {
            let each = (0..slots).map(|slot| {
                tethers::Slot::new(sheet, |k| {
                    let (anchor, most) = held((self.firsts[g] + k) * slots + slot)?;
                    Some((order.binary_search(&anchor).ok()? as u32, most))
                })
            });
            tethers.push(Tethers { slots: each.collect() });
        }
        self.tethers = Arc::new(tethers);
    }

    /// As [`Springs::bound`], of all springs.
    pub fn bound_diagonals(&mut self, bound: T) {
        self.springs.iter_mut().flatten().for_each(|s| s.bound = bound);
    }
}

/// From a place of x in `now` to the place in `w`.
fn single(triple: usize, half: usize) -> usize {
    triple / (6 * half) * 2 * half + triple % (6 * half)
}
