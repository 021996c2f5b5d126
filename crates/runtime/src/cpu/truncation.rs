//! Contact that no triangle crosses: after each step points are held back on their way so that no two features of the surface meet.
//!
//! A search finds all features (vertex and triangle, edge and edge) that can meet while no point moves farther than its reach, and gives
//! the points of each pair half-spaces that keep them apart ([`planes`]). A step ends where each point is in all of its half-spaces and
//! within its reach; a point that has used up its reach makes a new search, from where all points are. In exact arithmetic and in f32 the
//! result never crosses if the start does not: a position counts only after it has been rounded.
//!
//! Points do not wait for one another, so their order does not matter. A. Chen et al., "Offset Geometric Contact", 2025, bound steps by
//! half the distance instead; half-spaces leave motion along the surface free (arXiv 2604.15513).

mod boxes;
mod closest;
mod cut;
mod flat;
mod planes;
mod spread;
pub mod surface;
#[cfg(test)]
mod tests;

use boxes::{Bound, Boxes, CellPair};
use planes::{Planes, Points};
use spread::Spread;
use surface::Surface;

use crate::memory::Tally;
use crate::number::real::{V3, add, dot, sub};

/// The least and the largest reach of a point, as shares of the distance of neighbours.
const MIN_REACH: f64 = 0.04;
const MAX_REACH: f64 = 0.3;
/// Steps of the present speed that a point may go until the next search.
const STEPS_AHEAD: f64 = 6.0;
/// Least gap of features, as a share of the distance of neighbours.
const FLOOR_SHARE: f64 = 0.01;
/// Rounding of a position, over its largest coordinate: some units in the last place of f32.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Searches in a step, at most: points go [`MAX_REACH`] in each.
const MAX_SEARCHES: usize = 32;

/// Steps that half-spaces hold at least, where no point has used up its reach: a point that they hold back waits for so long.
const HELD_STEPS: u32 = 3;

/// What became of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Pins that went where cloth cannot give way: crossings may follow.
    pub forced: usize,
    /// Points that are slower than they should be, as they would have had to pass more than [`MAX_SEARCHES`] times their reach.
    pub slowed: usize,
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
    /// Where points were in the last search, and how far they may be from there.
    at: Vec<V3<f64>>,
    reach: Vec<f64>,
    /// For each texel whether the cells around it are even.
    even: Vec<bool>,
    /// Mean distance of neighbours \[m\].
    spacing: f64,
    floor: f64,
    due: bool,
    /// Steps since the last search.
    age: u32,
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
            at: Vec::new(),
            reach: Vec::new(),
            even: vec![false; surface.corners.len()],
            surface,
            spacing,
            floor: FLOOR_SHARE * spacing,
            due: true,
            age: 0,
        }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        [&self.last, &self.want, &self.at].into_iter().for_each(|list| tally.state(list));
        tally.state(&self.reach);
        tally.state(&self.boxes.bounds);
        self.surface.tally(tally);
        self.planes.tally(tally);
    }

    /// The next step searches.
    pub fn forget(&mut self) {
        self.due = true;
    }

    /// Takes all points from where they are to where they want to be, as far as they may go.
    pub fn step(&mut self) -> Outcome {
        let mut outcome = Outcome::default();
        self.age += 1;
        if self.due || self.pins_leave() {
            self.search(&mut outcome);
        }
        loop {
            let cut = self.cut();
            (outcome.forced, outcome.slowed) = (cut.forced, cut.short);
            let stale = cut.held > 0 && self.age >= HELD_STEPS;
            if !(cut.short > 0 || stale) || outcome.searches == MAX_SEARCHES {
                return outcome;
            }
            self.search(&mut outcome);
        }
    }

    /// Finds what points may meet from where they are.
    fn search(&mut self, outcome: &mut Outcome) {
        outcome.searches += 1;
        (self.due, self.age) = (false, 0);
        self.at.clone_from(&self.last);
        let far = self.at.iter().flatten().filter(|x| x.is_finite()).fold(0.0f64, |far, x| far.max(x.abs()));
        self.floor = (FLOOR_SHARE * self.spacing).max(8.0 * ROUNDING * far);
        self.find_reach();
        self.bound();
        self.planes.clear();
        let Truncation { surface, boxes, planes, want, free, at, reach, even, floor, .. } = self;
        let points = Points { at, want, free, floor: *floor };
        boxes.pairs(|pair| {
            let near = pair.apart.and_then(|apart| flat::shared(&surface.patches[pair.patch], pair.cells[0], apart));
            let skip = near.is_some_and(|[i, j]| {
                let patch = &surface.patches[pair.patch];
                even[patch.first + j * patch.width + i]
            });
            if !skip {
                compare((surface, &boxes.bounds), planes, (&points, reach), &pair);
            }
        });
        self.planes.arrange(self.at.len());
    }

    /// How far points may go until the next search.
    fn find_reach(&mut self) {
        let [least, most] = [MIN_REACH, MAX_REACH].map(|share| share * self.spacing);
        let each = self.at.iter().zip(&self.want).zip(&self.free);
        self.reach.clear();
        self.reach.extend(each.map(|((at, want), free)| {
            let way = sub(*want, *at);
            let step = dot(way, way).sqrt();
            let step = if step.is_finite() { step } else { 0.0 };
            let ahead = (STEPS_AHEAD * step).clamp(least, most);
            if *free { ahead } else { ahead.max(1.01 * step) }
        }));
    }

    /// Makes the boxes of cells, and finds where cloth is even.
    fn bound(&mut self) {
        for patch in &self.surface.patches {
            let of = |cell: usize| {
                let point = *self.surface.corners.get(cell)? as usize;
                Some((*self.at.get(point)?, self.reach[point]))
            };
            for n in 0..patch.width * patch.height {
                let (i, j, cell) = (n % patch.width, n / patch.width, patch.first + n);
                self.boxes.bounds[cell] = Bound::NONE;
                self.even[cell] = false;
                if !self.surface.triangles(cell).is_empty() {
                    let corners = [cell, cell + 1, cell + patch.width, cell + patch.width + 1];
                    self.boxes.bounds[cell] = around(corners.into_iter().filter_map(of), self.floor);
                }
                if (1..patch.width - 1).contains(&i) && (1..patch.height - 1).contains(&j) {
                    self.even[cell] = flat::is_even(patch, [i, j], self.floor, of);
                }
            }
        }
        for patch in &self.surface.patches {
            let of = |cell: usize| {
                let point = *self.surface.corners.get(cell)? as usize;
                Some((*self.at.get(point)?, self.reach[point]))
            };
            for n in 0..patch.width * patch.height {
                let (i, j, cell) = (n % patch.width, n / patch.width, patch.first + n);
                // Past the last quads there is nothing to meet.
                self.boxes.spreads[cell] = Spread::NONE;
                if i + 1 < patch.width && j + 1 < patch.height {
                    let corners = [cell, cell + 1, cell + patch.width, cell + patch.width + 1].map(of);
                    let whole = self.surface.triangles(cell).len() == 2 && spread::is_even(patch, &self.even, i, j);
                    self.boxes.spreads[cell] = match corners {
                        [Some(a), Some(b), Some(c), Some(d)] if whole => Spread::of([a, b, c, d]),
                        _ => Spread::WIDE,
                    };
                }
            }
        }
        self.boxes.floor = self.floor as f32;
        self.boxes.refit();
    }
}

/// The box around points with their reach and half of the least gap.
fn around(points: impl Iterator<Item = (V3<f64>, f64)>, floor: f64) -> Bound {
    let (mut bound, mut reach) = (Bound::NONE, 0.0f64);
    for (p, own) in points {
        reach = reach.max(own);
        let p = p.map(|x| x as f32);
        bound = bound.with(&Bound { low: p, high: p });
    }
    // Half of the floor would do; positions are f32, and the sum is rounded.
    let wide = (reach + floor) as f32;
    Bound { low: bound.low.map(|x| x - wide), high: bound.high.map(|x| x + wide) }
}

/// Finds the pairs of features of two cells.
fn compare(
    (surface, bounds): (&Surface, &[Bound]),
    planes: &mut Planes,
    (points, reach): (&Points, &mut [f64]),
    pair: &CellPair,
) {
    let [a, b] = pair.cells;
    let at = |k: u32| points.at[k as usize];
    // A feature without its reach, which the box of the other cell has: that of a cell holds the reach of all its points.
    let meets = |list: &[u32], cell: usize, reach: &[f64]| {
        let own = list.iter().map(|k| (at(*k), reach[*k as usize]));
        around(own, points.floor).meets(&bounds[cell])
    };
    for (one, other) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
        for vertex in surface.vertices(one) {
            if !meets(&[*vertex], other, reach) {
                continue;
            }
            for triangle in surface.triangles(other).iter().filter(|t| !t.contains(vertex)) {
                if meets_feature(points, reach, &[*vertex], triangle) {
                    let way = closest::to_triangle(at(*vertex), triangle.map(at));
                    planes.separate(points, reach, (&[*vertex], triangle), way);
                }
            }
        }
    }
    for (n, edge) in surface.edges(a).iter().enumerate() {
        if a != b && !meets(edge, b, reach) {
            continue;
        }
        let others = if a == b { &surface.edges(b)[n + 1..] } else { surface.edges(b) };
        for other in others.iter().filter(|other| !other.contains(&edge[0]) && !other.contains(&edge[1])) {
            if meets_feature(points, reach, edge, other) {
                let way = closest::to_edge(edge.map(at), other.map(at));
                planes.separate(points, reach, (edge, other), way);
            }
        }
    }
}

/// Whether the boxes of two features are near enough.
#[inline]
fn meets_feature(points: &Points, reach: &[f64], a: &[u32], b: &[u32]) -> bool {
    let extent = |list: &[u32]| {
        let (mut low, mut high, mut far) = ([f64::MAX; 3], [-f64::MAX; 3], 0.0f64);
        for k in list {
            let p = points.at[*k as usize];
            far = far.max(reach[*k as usize]);
            for c in 0..3 {
                (low[c], high[c]) = (low[c].min(p[c]), high[c].max(p[c]));
            }
        }
        (low, high, far)
    };
    let ((low, high, far), (lower, higher, further)) = (extent(a), extent(b));
    let near = far + further + points.floor;
    (0..3).all(|c| low[c] - higher[c] <= near && lower[c] - high[c] <= near)
}

/// A point on the way, 0 at its beginning.
fn along(from: V3<f64>, to: V3<f64>, share: f64) -> V3<f64> {
    add(from, sub(to, from).map(|x| x * share))
}
