//! Contact that no triangle crosses: after each step points are held back on their way so that no two features of the surface meet.
//!
//! A search expects each point to go on as in the last step, its drift. It finds all features (vertex and triangle, edge and edge) that can
//! meet while no point is farther from where its drift takes it than its reach, and gives the points of each pair half-spaces that keep them
//! apart ([`planes`]). A step ends where each point is in all of its half-spaces and within its reach; a point that cannot be there makes a
//! new search, from where all points are. Features that are not among the pairs have at each time a distance of more than both reaches. In
//! exact arithmetic and in f32 the result never crosses if the start does not: a position counts only after it has been rounded.
//!
//! Points do not wait for one another, so their order does not matter. A. Chen et al., "Offset Geometric Contact", 2025, bound steps by
//! half the distance instead; half-spaces leave motion along the surface free (arXiv 2604.15513).

pub mod boxes;
mod closest;
mod cut;
mod flat;
mod planes;
pub mod spread;
pub mod surface;
#[cfg(test)]
mod tests;

use boxes::{Bound, Boxes, CellPair};
use planes::{Planes, Points};
use spread::Spread;
use surface::Surface;

use crate::cpu::untangle::loose::Loose;
use crate::memory::Tally;
use crate::number::real::{V3, add, dot, scale, sub};

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

/// Steps that half-spaces hold at least, where no point has used up its reach: a point that they hold back waits for so long.
const HELD_STEPS: u32 = 3;
/// Searches in a step in which points that cannot go on as they do are let go on as they can, one after the other.
const MAX_TRIES: usize = 3;

/// The outcome of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Pins that went where cloth cannot give way: crossings may follow.
    pub forced: usize,
    /// Points that are slower than they should be, as they would have had to pass more than [`MAX_SEARCHES`] times their reach.
    pub slowed: usize,
    /// Points that half-spaces held back.
    pub held: usize,
    /// Searches.
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
    /// Where the cut of a step puts points, and whether a point cannot go on as it did.
    next: Vec<V3<f64>>,
    stuck: Vec<bool>,
    /// Where points were in the last search, and how far they may be from there.
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
    /// For each point, and for a gap.
    ways: Vec<Way>,
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
            next: Vec::new(),
            stuck: vec![false; count],
            at: Vec::new(),
            reach: Vec::new(),
            even: vec![false; surface.corners.len()],
            surface,
            spacing,
            floor: FLOOR_SHARE * spacing,
            due: true,
            age: MAX_AHEAD,
            ahead: MAX_AHEAD,
            ways: Vec::new(),
            drifts: Vec::new(),
        }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        let lists = [&self.last, &self.want, &self.next, &self.at, &self.pace, &self.drift];
        lists.into_iter().for_each(|list| tally.state(list));
        tally.state(&self.reach);
        tally.state(&self.loose);
        tally.state(&self.ways);
        tally.state(&self.drifts);
        tally.state(&self.boxes.spreads);
        tally.state(&self.boxes.bounds);
        self.surface.tally(tally);
        self.planes.tally(tally);
    }

    /// The next step searches, and knows of no step before.
    pub fn forget(&mut self) {
        (self.due, self.age) = (true, MAX_AHEAD);
        self.pace.fill([0.0; 3]);
    }

    /// From the next step on features whose points are all loose alike may pass one another. A search follows where this lets others pass, or keeps
    /// apart features that could pass before.
    pub fn loosen(&mut self, loose: Vec<(u32, Loose)>) {
        self.due |= self.loose != loose;
        self.loose = loose;
    }

    /// Takes all points from where they are to where they want to be, as far as they may go.
    pub fn step(&mut self) -> Outcome {
        let mut outcome = Outcome::default();
        let start = self.last.clone();
        self.advance(&mut outcome);
        let each = self.pace.iter_mut().zip(&self.last).zip(&start);
        each.for_each(|((pace, now), was)| *pace = sub(*now, *was));
        outcome
    }

    fn advance(&mut self, outcome: &mut Outcome) {
        self.age += 1;
        self.stuck.fill(false);
        let mut fresh = self.due || self.age > self.ahead || self.pins_leave();
        if fresh {
            self.search(outcome, true);
        }
        loop {
            let cut = self.cut();
            let stale = cut.held > 0 && self.age >= HELD_STEPS && !fresh;
            if cut.stuck > 0 || ((cut.short > 0 || stale) && !fresh) {
                // From where the step began, with the pace of points as it is now.
                self.search(outcome, outcome.searches < MAX_TRIES);
                fresh = true;
                continue;
            }
            std::mem::swap(&mut self.last, &mut self.next);
            (outcome.forced, outcome.slowed) = (outcome.forced.max(cut.forced), cut.short);
            outcome.held = cut.held;
            if cut.short == 0 || outcome.searches >= MAX_SEARCHES {
                return;
            }
            // On from here, as far as points go with a reach around where they are.
            self.search(outcome, false);
        }
    }

    /// Finds what points may meet from where they are: if each goes on as in the last step, or else if they stay there.
    fn search(&mut self, outcome: &mut Outcome, goes_on: bool) {
        outcome.searches += 1;
        // A step that goes on from a search of its own says nothing about how long one holds.
        if goes_on {
            let most = self.slow_steps().clamp(MAX_AHEAD, MAX_AHEAD_AT_REST);
            self.ahead = (2 * self.age).saturating_sub(2).clamp(MIN_AHEAD, most);
        }
        (self.due, self.age) = (false, 1);
        self.at.clone_from(&self.last);
        let far = self.at.iter().flatten().filter(|x| x.is_finite()).fold(0.0f64, |far, x| far.max(x.abs()));
        self.floor = (FLOOR_SHARE * self.spacing).max(8.0 * ROUNDING * far);
        self.find_reach(goes_on);
        self.bound();
        self.planes.clear();
        let Truncation {
            surface, boxes, planes, want, free, loose, drift, drifts, at, reach, even, floor, ahead, ..
        } = self;
        let points = Points { at, want, free, loose, drift, reach, floor: *floor, ahead: f64::from(*ahead) };
        boxes.pairs(|pair| {
            let near = pair.apart.and_then(|apart| flat::shared(&surface.patches[pair.patch], pair.cells[0], apart));
            let skip = near.is_some_and(|[i, j]| {
                let patch = &surface.patches[pair.patch];
                even[patch.first + j * patch.width + i]
            });
            if !skip {
                let near = points.floor + drifts[pair.cells[0]].near(&drifts[pair.cells[1]], points.ahead);
                compare((surface, &boxes.bounds), planes, &points, &pair, near);
            }
        });
        self.planes.arrange(self.at.len());
    }

    /// Steps in which no point goes farther than the largest reach, if all go on as they do.
    fn slow_steps(&self) -> u32 {
        let fastest = self.pace.iter().map(|pace| dot(*pace, *pace)).fold(0.0, f64::max).sqrt();
        (MAX_REACH * self.spacing / fastest.max(f64::MIN_POSITIVE)).min(f64::from(MAX_AHEAD_AT_REST)) as u32
    }

    /// How far points may go until the next search.
    fn find_reach(&mut self, goes_on: bool) {
        let [least, most] = [MIN_REACH, MAX_REACH].map(|share| share * self.spacing);
        self.drift.clear();
        let each = self.pace.iter().zip(&self.stuck);
        self.drift.extend(each.map(|(pace, stuck)| {
            let goes = goes_on && !stuck && pace.iter().all(|x| x.is_finite());
            if goes { *pace } else { [0.0; 3] }
        }));
        let each = self.at.iter().zip(&self.want).zip(&self.free).zip(&self.drift);
        self.reach.clear();
        self.reach.extend(each.map(|(((at, want), free), drift)| {
            let way = sub(sub(*want, *at), *drift);
            let step = dot(way, way).sqrt();
            let step = if step.is_finite() { step } else { 0.0 };
            let ahead = (f64::from(self.ahead) * step).clamp(least, most);
            if *free { ahead } else { ahead.max(1.01 * step) }
        }));
    }

    /// Makes the boxes of cells, and finds where cloth is even.
    fn bound(&mut self) {
        let Truncation { surface, boxes, even, at, reach, drift, floor, ways, drifts, ahead, .. } = self;
        let far = f64::from(*ahead);
        ways.clear();
        let each = at.iter().zip(&*drift).zip(&*reach);
        ways.extend(each.map(|((p, drift), reach)| Way { from: *p, to: add(*p, scale(*drift, far)), reach: *reach }));
        // Comparisons with NaN are false: nothing is even beside a gap.
        ways.push(Way { from: [f64::NAN; 3], to: [f64::NAN; 3], reach: 0.0 });
        let gap = at.len();
        let of = |cell: usize| ways[(surface.corners[cell] as usize).min(gap)];
        drifts.resize(surface.corners.len(), Drift::default());
        for patch in &surface.patches {
            let (width, height) = (patch.width, patch.height);
            for j in 1..height.saturating_sub(1) {
                for i in 1..width.saturating_sub(1) {
                    even[patch.first + j * width + i] = flat::is_even(patch, [i, j], *floor, of);
                }
            }
            for j in 0..height {
                for i in 0..width {
                    let cell = patch.first + j * width + i;
                    // A cell without a triangle meets nothing.
                    (boxes.bounds[cell], boxes.spreads[cell]) = (Bound::NONE, Spread::NONE);
                    if i + 1 == width || j + 1 == height {
                        continue;
                    }
                    let corners = [cell, cell + 1, cell + width, cell + width + 1].map(of);
                    let triangles = surface.triangles(cell).len();
                    let whole = triangles == 2 && spread::is_even(patch, even, i, j);
                    // A way along edges must not cross a gap.
                    boxes.spreads[cell] = if whole { Spread::of(corners) } else { Spread::WIDE };
                    if triangles > 0 {
                        boxes.bounds[cell] = around(corners.iter().filter(|way| way.from[0].is_finite()), *floor);
                        drifts[cell] = Drift::of(corners, far);
                    }
                }
            }
        }
        boxes.floor = *floor as f32;
        boxes.refit();
    }
}

/// Where a point is, where its drift takes it until the next search, and how far it may be from there.
#[derive(Clone, Copy)]
struct Way {
    from: V3<f64>,
    to: V3<f64>,
    reach: f64,
}

/// The drifts of a cell's points: a mean, how far they are off it, and the largest reach \[m\].
#[derive(Clone, Copy, Default)]
struct Drift {
    mean: V3<f64>,
    off: f64,
    reach: f64,
}

impl Drift {
    fn of(corners: [Way; 4], ahead: f64) -> Self {
        let there = || corners.iter().filter(|way| way.from[0].is_finite());
        let drift = |way: &Way| scale(sub(way.to, way.from), 1.0 / ahead);
        let mean = scale(there().map(drift).fold([0.0; 3], add), 0.25);
        let off = there().map(|way| sub(drift(way), mean)).map(|d| dot(d, d)).fold(0.0, f64::max).sqrt();
        Drift { mean, off, reach: there().map(|way| way.reach).fold(0.0, f64::max) }
    }

    /// By how much features of two cells can come nearer until the next search, at most.
    fn near(&self, other: &Self, ahead: f64) -> f64 {
        let apart = sub(self.mean, other.mean);
        // With room for rounding.
        self.reach + other.reach + 1.000001 * ahead * (dot(apart, apart).sqrt() + self.off + other.off)
    }
}

/// The box around the ways of points with their reach and half of the least gap.
fn around<'a>(points: impl Iterator<Item = &'a Way>, floor: f64) -> Bound {
    let (mut bound, mut reach) = (Bound::NONE, 0.0f64);
    for way in points {
        reach = reach.max(way.reach);
        for p in [way.from, way.to] {
            let p = p.map(|x| x as f32);
            bound = bound.with(&Bound { low: p, high: p });
        }
    }
    // Half of the floor would do; positions are f32, and the sum is rounded.
    let wide = (reach + floor) as f32;
    Bound { low: bound.low.map(|x| x - wide), high: bound.high.map(|x| x + wide) }
}

/// Finds the pairs of features of two cells, which are not farther apart than `near` \[m\].
fn compare((surface, bounds): (&Surface, &[Bound]), planes: &mut Planes, points: &Points, pair: &CellPair, near: f64) {
    let [a, b] = pair.cells;
    let at = |k: u32| points.at[k as usize];
    for (one, other) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
        for vertex in surface.vertices(one) {
            if !points.box_of(&[*vertex]).meets(&bounds[other]) {
                continue;
            }
            for triangle in surface.triangles(other).iter().filter(|t| !t.contains(vertex)) {
                if points.may_meet(&[*vertex], triangle, near) {
                    let way = closest::to_triangle(at(*vertex), triangle.map(at));
                    planes.separate(points, (&[*vertex], triangle), way);
                }
            }
        }
    }
    for (n, edge) in surface.edges(a).iter().enumerate() {
        if a != b && !points.box_of(edge).meets(&bounds[b]) {
            continue;
        }
        let others = if a == b { &surface.edges(b)[n + 1..] } else { surface.edges(b) };
        for other in others.iter().filter(|other| !other.contains(&edge[0]) && !other.contains(&edge[1])) {
            if points.may_meet(edge, other, near) {
                let way = closest::to_edge(edge.map(at), other.map(at));
                planes.separate(points, (edge, other), way);
            }
        }
    }
}
