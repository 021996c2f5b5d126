//! Contact that no triangle crosses: after each step points are held back on their way so that no two features of the surface meet.
//!
//! A search expects each point to go on as in the last step, its drift. It finds all features (vertex and triangle, edge and edge) that can
//! meet while no point is farther from where its drift takes it than its reach, and gives the points of each pair half-spaces that keep them
//! apart ([`planes`]). A step ends where each point is in all of its half-spaces and within its reach. Few points that cannot be there, or that
//! half-spaces have held back for some steps, are renewed ([`renew`]). For many, a new search begins from where all points are, and the next steps
//! have a search each: it knows where the step takes each point, so that its reach is short and few features are near. Features that are not among
//! the pairs have at each time a distance of more than both reaches. In exact arithmetic and in f32 the result never crosses if the start does not:
//! a position counts only after it has been rounded.
//!
//! Points do not wait for one another, so their order does not matter. A. Chen et al., "Offset Geometric Contact", 2025, bound steps by
//! half the distance instead; half-spaces leave motion along the surface free (arXiv 2604.15513).

pub mod boxes;
mod cells;
mod closest;
mod compare;
mod cut;
mod drift;
mod flat;
mod pairs;
mod planes;
mod renew;
pub mod spread;
pub mod surface;
#[cfg(test)]
mod tests;
mod tiles;

use boxes::Boxes;
use compare::{Compared, compare};
use drift::Drift;
use flat::Ways;
use pairs::CellPair;
use planes::{Planes, Points};
use surface::Surface;

use crate::cpu::rows::Threads;
use crate::cpu::untangle::loose::Loose;
use crate::memory::Tally;
use crate::number::real::{V3, dot, scale, sub};

/// The least and the largest reach of a point, as shares of the distance of neighbours.
const MIN_REACH: f64 = 0.1;
const MAX_REACH: f64 = 0.2;
/// The fewest and the most steps that a search is made for, if points go on as they do: twice as many as the last search held.
const MIN_AHEAD: u32 = 2;
const MAX_AHEAD: u32 = 8;
/// The most of cloth so slow that it goes no farther than [`MAX_REACH`] in them.
const MAX_AHEAD_AT_REST: u32 = 64;
/// Least gap of features, as a share of the distance of neighbours.
const FLOOR_SHARE: f64 = 0.01;
/// Rounding of a position, over its largest coordinate: some units in the last place of f32.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Searches in a step, at most: points go [`MAX_REACH`] in each.
const MAX_SEARCHES: usize = 32;

/// The longest way in a search that holds for one step, and how far beyond the half of its way a point may be from the middle of it, as
/// shares of the distance of neighbours.
const MAX_WAY: f64 = 0.4;
const MORE_REACH: f64 = 0.02;
/// Steps that half-spaces hold at least, where no point has used up its reach: a point that they hold back waits for so long.
const HELD_STEPS: u32 = 3;
/// Where many points cannot go on as a search expects that is not older than this, the next steps search for themselves; how many.
const CROWDED_AGE: u32 = 3;
const MIN_CROWDED_STEPS: u32 = 8;
const MAX_CROWDED_STEPS: u32 = 64;

/// The outcome of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Pins that went where cloth cannot give way: crossings may follow.
    pub forced: usize,
    /// Points that are slower than they should be, as they would have had to pass more than [`MAX_SEARCHES`] times their reach.
    pub slowed: usize,
    /// Points that half-spaces held back.
    pub held: usize,
    /// Searches, and renewals of points that go on from where they are in the step.
    pub searches: usize,
}

/// The surface of all cloths whose contact is safe.
pub struct Truncation {
    pub surface: Surface,
    boxes: Boxes,
    planes: Planes,
    /// Where points are \[m\], and where the step takes them.
    pub last: Vec<V3<f64>>,
    pub want: Vec<V3<f64>>,
    /// Whether a point may be held back.
    pub free: Vec<bool>,
    /// The cloth of each point, and which points it may pass, as cloth crosses there; empty where none does.
    loose: Vec<(u32, Loose)>,
    /// The way \[m\] of each point in the last step, and in each step from the last search on as that expects it.
    pace: Vec<V3<f64>>,
    drift: Vec<V3<f64>>,
    /// Where points were as the step began.
    start: Vec<V3<f64>>,
    /// Where the cut of a step puts points, and whether a point cannot go on as it did.
    next: Vec<V3<f64>>,
    stuck: Vec<bool>,
    /// Points that have used up their reach in the step.
    short: Vec<u32>,
    /// Points that need a new reach, or other half-spaces, before the step can end.
    failing: Vec<u32>,
    /// The step in which a point was renewed last, from the last search on.
    since: Vec<u32>,
    /// The next steps that search for themselves, and how many will the next time.
    crowded: u32,
    crowded_steps: u32,
    /// Whether a point was renewed ([`renew`]) just now, and a cell has a corner at one.
    fresh: Vec<bool>,
    around: Vec<bool>,
    /// Where points were in the last search, and how far they may be from where their drift takes them. Where a point would have been then, if
    /// it is renewed.
    at: Vec<V3<f64>>,
    reach: Vec<f64>,
    /// For each texel whether the cells around it are even.
    even: Vec<bool>,
    /// Mean distance of neighbours \[m\].
    spacing: f64,
    floor: f64,
    due: bool,
    /// Steps from the last search on, and how many it holds at most.
    age: u32,
    ahead: u32,
    /// The ways of the points of some texels, for [`flat`].
    ways: Ways,
    /// For each cell how its points drift.
    drifts: Vec<Drift>,
}

impl Truncation {
    /// That of a surface whose neighbours are `spacing` \[m\] apart, with all points at 0.
    pub fn new(surface: Surface, spacing: f64) -> Self {
        let count = surface.count();
        Truncation {
            boxes: Boxes::new(&surface),
            planes: Planes::default(),
            last: vec![[0.0; 3]; count],
            want: vec![[0.0; 3]; count],
            free: vec![true; count],
            loose: Vec::new(),
            pace: vec![[0.0; 3]; count],
            drift: Vec::new(),
            start: Vec::new(),
            next: Vec::new(),
            stuck: vec![false; count],
            short: Vec::new(),
            failing: Vec::new(),
            since: vec![1; count],
            crowded: 0,
            crowded_steps: MIN_CROWDED_STEPS,
            fresh: vec![false; count],
            around: vec![false; surface.corners.len()],
            at: Vec::new(),
            reach: Vec::new(),
            even: vec![false; surface.corners.len()],
            surface,
            spacing,
            floor: FLOOR_SHARE * spacing,
            due: true,
            age: MAX_AHEAD,
            ahead: MAX_AHEAD,
            ways: Ways::default(),
            drifts: Vec::new(),
        }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        let lists = [&self.last, &self.want, &self.start, &self.next, &self.at, &self.pace, &self.drift];
        lists.into_iter().for_each(|list| tally.state(list));
        tally.state(&self.reach);
        tally.state(&self.loose);
        self.ways.tally(tally);
        tally.state(&self.drifts);
        tally.state(&self.boxes.spreads);
        tally.state(&self.boxes.bounds);
        tally.state(&self.boxes.tiles);
        [&self.short, &self.failing, &self.since].into_iter().for_each(|list| tally.state(list));
        self.surface.tally(tally);
        self.planes.tally(tally);
    }

    /// The next step searches, and knows of no step before.
    pub fn forget(&mut self) {
        (self.due, self.age) = (true, MAX_AHEAD);
        (self.crowded, self.crowded_steps) = (0, MIN_CROWDED_STEPS);
        self.pace.fill([0.0; 3]);
    }

    /// From the next step on features whose points are all loose alike may pass one another. A search follows where this lets others pass, or keeps
    /// apart features that could pass before.
    pub fn loosen(&mut self, loose: Vec<(u32, Loose)>) {
        self.due |= self.loose != loose;
        self.loose = loose;
    }

    /// Takes all points from where they are to where they want to be, as far as they may go.
    pub fn step(&mut self, threads: &Threads) -> Outcome {
        let mut outcome = Outcome::default();
        self.start.clone_from(&self.last);
        self.advance(threads, &mut outcome);
        let each = self.pace.iter_mut().zip(&self.last).zip(&self.start);
        each.for_each(|((pace, now), was)| {
            *pace = sub(*now, *was);
        });
        outcome
    }

    fn advance(&mut self, threads: &Threads, outcome: &mut Outcome) {
        self.age += 1;
        self.stuck.fill(false);
        let mut fresh = self.due || self.age > self.ahead || self.crowded > 0 || self.pins_leave();
        if fresh {
            let goes_on = self.crowded == 0;
            self.crowded = self.crowded.saturating_sub(1);
            self.search(threads, outcome, goes_on);
        }
        loop {
            let cut = self.cut(!fresh);
            if !self.failing.is_empty() {
                if self.are_few(self.failing.len()) {
                    self.renew(true);
                    continue;
                }
                // From where the step began. Where a search holds for so few steps, each step has its own.
                if !fresh && self.age <= CROWDED_AGE {
                    self.crowded = self.crowded_steps;
                    self.crowded_steps = (2 * self.crowded_steps).min(MAX_CROWDED_STEPS);
                }
                self.search(threads, outcome, false);
                fresh = true;
                continue;
            }
            std::mem::swap(&mut self.last, &mut self.next);
            (outcome.forced, outcome.slowed) = (outcome.forced.max(cut.forced), cut.short);
            outcome.held = cut.held;
            // A search does not hold for a pin that has left its reach.
            self.due |= cut.forced > 0;
            if cut.short == 0 || outcome.searches >= MAX_SEARCHES {
                return;
            }
            // On from here, as far as points go with a reach around where they are.
            if self.are_few(self.short.len()) {
                outcome.searches += 1;
                self.renew(false);
            } else {
                self.search(threads, outcome, false);
            }
        }
    }

    /// Finds what points may meet from where they are: if each goes on as in the last step, or else in this step alone.
    fn search(&mut self, threads: &Threads, outcome: &mut Outcome, goes_on: bool) {
        outcome.searches += 1;
        if goes_on {
            let most = self.slow_steps().clamp(MAX_AHEAD, MAX_AHEAD_AT_REST);
            if self.age > CROWDED_AGE {
                self.crowded_steps = MIN_CROWDED_STEPS;
            }
            self.ahead = (2 * self.age).saturating_sub(2).clamp(MIN_AHEAD, most);
        } else {
            self.ahead = 1;
        }
        (self.due, self.age) = (false, 1);
        self.since.fill(1);
        self.at.clone_from(&self.last);
        let far = self.at.iter().flatten().filter(|x| x.is_finite()).fold(0.0f64, |far, x| far.max(x.abs()));
        self.floor = (FLOOR_SHARE * self.spacing).max(8.0 * ROUNDING * far);
        self.find_reach(goes_on);
        self.bound();
        self.planes.clear();
        let Truncation {
            surface, boxes, planes, want, free, loose, drift, drifts, at, reach, even, floor, ahead, ..
        } = self;
        let points =
            Points { at, want, free, loose, drift, reach, fresh: None, floor: *floor, ahead: f64::from(*ahead) };
        let compared = |pair: &CellPair| {
            let [a, b] = pair.cells.map(|cell| &drifts[cell]);
            let near = points.floor + a.near(b, points.ahead);
            if flat::is_apart(surface, even, pair) {
                return None;
            }
            a.way(b, 0.0, near).map(|axis| Compared { cells: pair.cells, near, axis })
        };
        if threads.count() == 1 {
            let mut each =
                |pair: CellPair| compared(&pair).iter().for_each(|pair| compare(surface, planes, &points, pair));
            boxes.pairs(&mut each);
        } else {
            let mut pairs = Vec::new();
            boxes.pairs(|pair| pairs.extend(compared(&pair)));
            compare::share(threads, &pairs, planes, |planes, pair| compare(surface, planes, &points, pair));
        }
        self.planes.arrange(self.at.len());
    }

    /// Steps in which no point goes farther than the largest reach, if all go on as they do.
    fn slow_steps(&self) -> u32 {
        let fastest = self.pace.iter().map(|pace| dot(*pace, *pace)).fold(0.0, f64::max).sqrt();
        (MAX_REACH * self.spacing / fastest.max(f64::MIN_POSITIVE)).min(f64::from(MAX_AHEAD_AT_REST)) as u32
    }

    /// How far points may go until the next search.
    fn find_reach(&mut self, goes_on: bool) {
        self.drift.clear();
        self.reach.clear();
        let [least, most] = [MIN_REACH, MAX_REACH].map(|share| share * self.spacing);
        let ahead = f64::from(self.ahead);
        for k in 0..self.at.len() {
            let way = sub(self.want[k], self.at[k]);
            let way = if way.iter().all(|x| x.is_finite()) { way } else { [0.0; 3] };
            let pace = self.pace[k];
            let (drift, reach) = if goes_on {
                let drift = if pace.iter().all(|x| x.is_finite()) { pace } else { [0.0; 3] };
                let off = sub(way, drift);
                let step = dot(off, off).sqrt();
                let reach = (ahead * step).clamp(least, most);
                (drift, if self.free[k] { reach } else { reach.max(1.01 * step) })
            } else {
                // A ball around the middle of the way has both ends of it, so that points may also stay.
                let (far, most) = (dot(way, way).sqrt(), MAX_WAY * self.spacing);
                let half = if self.free[k] && far > most { 0.5 * most / far } else { 0.5 };
                (scale(way, half), 1.000001 * half * far + MORE_REACH * self.spacing)
            };
            self.drift.push(drift);
            self.reach.push(reach);
        }
    }
}
