//! Stitches: particles that are tied to points of other grids.

use std::sync::Arc;

use gimage_bundle::{MAX_STITCHES_AT_POINT, Place, Stitch};

use super::Cloth;
use crate::error::{Error, Result};

/// No stitch, or the end of a list.
pub(crate) const NO_STITCH: u32 = u32::MAX;

/// Numbers of a [`Entry`] per stitch: its four corners, then its own particle.
pub(crate) const ENDS: usize = 5;

/// One end of a stitch: the index of the stitch, and 0 to 3 for a corner of its quad or 4 for its particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub stitch: u32,
    pub end: u32,
}

/// A stitch between particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thread {
    /// The corners of the quad, as [`Place::corners`], then the particle.
    pub ends: [u32; ENDS],
    /// Columns of the grid of the quad.
    pub width: u32,
    /// Where the point is in the quad.
    pub inner: [f32; 2],
    /// Its length \[m\].
    pub distance: f32,
    /// How many stitches move each end, this one among them: 1 to [`MAX_STITCHES_AT_POINT`].
    pub counts: [u32; ENDS],
}

/// The stitches of a cloth, and which of them move each particle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sewing {
    /// As they were given, in the order of their particles.
    pub stitches: Vec<Stitch>,
    /// The same between particles.
    pub threads: Vec<Thread>,
    /// Offsets into `entries` per moved point, one more than there are points.
    pub starts: Vec<u32>,
    /// The ends at each point, in the order of the stitches.
    pub entries: Vec<Entry>,
    /// For every particle its moved point, or [`NO_STITCH`]. Duplicates of a seam point have one.
    pub moved: Vec<u32>,
}

impl Cloth {
    /// The stitches, in the order of their particles; none for cloth without any.
    pub fn stitches(&self) -> &[Stitch] {
        self.sewing.as_ref().map_or(&[], |sewing| &sewing.stitches)
    }

    /// Ties particles to points of grids ([`Stitch::piece`] is the index of a grid), in place of the stitches so far. Each keeps the distance
    /// of its particle from the point, and moves both by their masses; of [`crate::Solver::Xpbd`] only. Duplicates of a seam point move
    /// together, and tethers go on over stitches, so tethers of a bundle are dropped if stitches change. No stitches cost nothing; otherwise two passes per step, with 48 bytes per particle.
    ///
    /// Errors on a particle or a grid that does not exist, a second stitch of a particle, a point outside 0 to 1 or beside a hole,
    /// a distance that is negative or not finite, and more than [`MAX_STITCHES_AT_POINT`] stitches at one point.
    pub fn set_stitches(&mut self, mut stitches: Vec<Stitch>) -> Result<()> {
        stitches.sort_by_key(|s| s.particle);
        if let Some(pair) = stitches.windows(2).find(|pair| pair[0].particle == pair[1].particle) {
            return Err(self.no_stitch(&pair[0], "it has two stitches"));
        }
        let threads = stitches.iter().map(|s| self.thread(s)).collect::<Result<Vec<_>>>()?;
        if stitches != self.stitches() {
            self.stored_tethers = None;
        }
        self.sewing = if threads.is_empty() { None } else { Some(Arc::new(self.sew(stitches, threads)?)) };
        Ok(())
    }

    /// As [`Cloth::set_stitches`], without the stitches that are refused.
    pub(crate) fn set_stitches_that_fit(&mut self, stitches: Vec<Stitch>) {
        let points = self.points();
        let mut counts = vec![0; self.len()];
        let mut fits = |s: &Stitch| {
            let Ok(thread) = self.thread(s) else { return false };
            let at = thread.ends.map(|k| points[k as usize] as usize);
            let room = at.iter().all(|k| counts[*k] < MAX_STITCHES_AT_POINT);
            at.iter().filter(|_| room).for_each(|k| counts[*k] += 1);
            room
        };
        let kept = stitches.into_iter().filter(|s| fits(s)).collect();
        // Of stitches that fit only a second one of a particle is refused.
        if self.set_stitches(kept).is_err() {
            self.sewing = None;
        }
    }

    pub(crate) fn sewing(&self) -> Option<&Sewing> {
        self.sewing.as_deref()
    }

    fn no_stitch(&self, stitch: &Stitch, problem: &'static str) -> Error {
        Error::Particle { cloth: self.name().into(), index: stitch.particle as usize, problem }
    }

    /// A stitch between particles, without counts.
    fn thread(&self, stitch: &Stitch) -> Result<Thread> {
        let there = |k: u32| self.particles().get(k as usize).is_some_and(|p| p.exists());
        if !there(stitch.particle) {
            return Err(self.no_stitch(stitch, "it has a stitch, but does not exist"));
        }
        let is_inside = stitch.at.iter().all(|x| (0.0..=1.0).contains(x));
        if !is_inside || !(0.0..f32::INFINITY).contains(&stitch.distance) {
            return Err(self.no_stitch(
                stitch,
                "its stitch has a point outside 0 to 1, or a length that is negative or not finite",
            ));
        }
        let Some(grid) = self.grids().get(stitch.piece as usize) else {
            return Err(self.no_stitch(stitch, "its stitch leads to a grid that does not exist"));
        };
        let place = Place::of(grid.width, grid.height, stitch.at);
        let corners = place.corners(grid.width).map(|k| grid.first + k);
        if !corners.iter().all(|k| there(*k)) {
            return Err(self.no_stitch(stitch, "its stitch leads to a quad that lacks a particle"));
        }
        let [a, b, c, d] = corners;
        let ends = [a, b, c, d, stitch.particle];
        Ok(Thread { ends, width: grid.width, inner: place.inner, distance: stitch.distance, counts: [1; ENDS] })
    }

    fn sew(&self, stitches: Vec<Stitch>, mut threads: Vec<Thread>) -> Result<Sewing> {
        let points = self.points();
        let mut at: Vec<(u32, Entry)> = Vec::new();
        for (stitch, thread) in threads.iter().enumerate() {
            let ends = thread.ends.iter().enumerate();
            at.extend(ends.map(|(end, k)| (points[*k as usize], Entry { stitch: stitch as u32, end: end as u32 })));
        }
        at.sort_by_key(|(point, entry)| (*point, entry.stitch, entry.end));
        let (mut starts, mut number) = (vec![0], vec![NO_STITCH; self.len()]);
        for group in at.chunk_by(|a, b| a.0 == b.0) {
            let count = group.len() as u32;
            for (_, entry) in group {
                threads[entry.stitch as usize].counts[entry.end as usize] = count;
            }
            if count > MAX_STITCHES_AT_POINT {
                let stitch = &stitches[group[0].1.stitch as usize];
                return Err(self.no_stitch(stitch, "its stitch leads to a point with too many stitches"));
            }
            number[group[0].0 as usize] = starts.len() as u32 - 1;
            starts.push(starts[starts.len() - 1] + count);
        }
        let moved = points.iter().map(|point| number[*point as usize]).collect();
        Ok(Sewing { stitches, threads, starts, entries: at.into_iter().map(|(_, entry)| entry).collect(), moved })
    }
}

impl Sewing {
    /// As shaders read it: three rows per particle. Its stitch as the first corner and the columns of the quad, the first of the ends
    /// that move the particle, and counts of six bits; the point in the quad, the length, and for each end the next one at its point.
    /// An end is eight times the particle of its stitch, plus its number.
    pub fn rows(&self) -> Vec<[u32; 4]> {
        let mut rows = vec![[NO_STITCH; 4]; 3 * self.moved.len()];
        let code = |entry: &Entry| 8 * self.threads[entry.stitch as usize].ends[4] + entry.end;
        for (k, point) in self.moved.iter().enumerate().filter(|(_, point)| **point != NO_STITCH) {
            rows[3 * k][2] = code(&self.entries[self.starts[*point as usize] as usize]);
        }
        for thread in &self.threads {
            let k = 3 * thread.ends[4] as usize;
            let counts = thread.counts.iter().enumerate().fold(0, |all, (end, count)| all | count << (6 * end));
            (rows[k][0], rows[k][1], rows[k][3]) = (thread.ends[0], thread.width, counts);
            let [s, t] = thread.inner.map(f32::to_bits);
            rows[k + 1] = [s, t, thread.distance.to_bits(), NO_STITCH];
        }
        for entries in self.starts.windows(2).map(|r| &self.entries[r[0] as usize..r[1] as usize]) {
            for pair in entries.windows(2) {
                let k = 3 * self.threads[pair[0].stitch as usize].ends[4] as usize;
                let next = if pair[0].end == 4 { &mut rows[k + 1][3] } else { &mut rows[k + 2][pair[0].end as usize] };
                *next = code(&pair[1]);
            }
        }
        rows
    }
}
