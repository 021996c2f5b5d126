//! The waves from all pins, spreading over the surface in the order of their distance.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bridge::{Bridge, PAIRS};
use super::labels::{Label, Labels, PINS_OF_A_GROUP};
use super::unfold::unfold;
use super::{Anchor, RestLengths, SpringGrid};
use crate::particle::Particle;
use crate::rings::find_rings;

/// Neighbours in a circle: right, down-right, down, down-left, left, up-left, up, up-right.
const CIRCLE: [(isize, isize); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// The triangles around a texel: two of [`CIRCLE`], and the spring between them as the one of the two that stores it and
/// its place there. Twelve, as each quad is split both ways.
const TRIANGLES: [(usize, usize, usize, usize); 12] = [
    (0, 1, 0, 1),
    (1, 2, 2, 0),
    (0, 2, 2, 3),
    (2, 3, 3, 0),
    (3, 4, 4, 1),
    (2, 4, 4, 2),
    (4, 5, 5, 1),
    (5, 6, 5, 0),
    (4, 6, 4, 3),
    (6, 7, 6, 0),
    (7, 0, 7, 1),
    (6, 0, 6, 2),
];

/// A neighbour of a texel: the point it belongs to, its texel in the grid, and the spring to it.
#[derive(Clone, Copy)]
struct Neighbour {
    point: u32,
    texel: usize,
    length: f64,
    /// How far the pin that spreads is from it, and whether it has spread there.
    distance: f64,
    spread: bool,
}

pub(super) struct Front<'a> {
    grids: &'a [SpringGrid<'a>],
    /// First particle of each grid.
    firsts: Vec<usize>,
    particles: &'a [Particle],
    /// The lowest duplicate of each texel, which stands for the point.
    point: Vec<u32>,
    /// The next duplicate of each texel, itself off the seams.
    next: Vec<u32>,
    /// Ends of bridges at points, in the order of the points: 0 to 3 for a corner, 4 for the particle.
    ends: Vec<(u32, u32, u8)>,
    bridges: Vec<Bridge>,
    labels: Labels,
    /// Distance as ordered bits, point, pin.
    queue: BinaryHeap<Reverse<(u64, u32, u32)>>,
}

impl<'a> Front<'a> {
    /// Sets every pin to 0. `groups` has the group of every pinned particle; each particle keeps `kept` of them.
    pub fn new(grids: &'a [SpringGrid<'a>], particles: &'a [Particle], groups: &[u32], kept: usize) -> Self {
        let mut point: Vec<u32> = (0..particles.len() as u32).collect();
        let mut next = point.clone();
        for ring in find_rings(particles).0.iter() {
            for (k, &member) in ring.iter().enumerate() {
                point[member as usize] = ring[0];
                next[member as usize] = ring[(k + 1) % ring.len()];
            }
        }
        let firsts = grids.iter().scan(0, |sum, g| {
            let first = *sum;
            *sum += g.width as usize * g.height as usize;
            Some(first)
        });
        let firsts = firsts.collect();
        let pins = if lone_pins(groups, &point) { 1 } else { PINS_OF_A_GROUP };
        let labels = Labels::new(particles.len(), kept, pins);
        let (ends, bridges) = (Vec::new(), Vec::new());
        let mut front =
            Front { grids, firsts, particles, point, next, ends, bridges, labels, queue: BinaryHeap::new() };
        for (k, &group) in groups.iter().enumerate().filter(|(_, group)| **group != u32::MAX) {
            let pin = front.point[k];
            front.offer(pin, Label { distance: 0.0, pin, group, spread: false });
        }
        front
    }

    /// Takes bridges, to and from particles that exist.
    pub fn with(mut self, bridges: &[Bridge]) -> Self {
        let there = |k: &u32| self.particles.get(*k as usize).is_some_and(|p| p.exists());
        let whole = |b: &&Bridge| b.corners.iter().chain([&b.particle]).all(there);
        self.bridges = bridges.iter().filter(whole).copied().collect();
        for (n, bridge) in self.bridges.iter().enumerate() {
            let ends = bridge.corners.iter().chain([&bridge.particle]).zip(0..);
            self.ends.extend(ends.map(|(k, end)| (self.point[*k as usize], n as u32, end)));
        }
        self.ends.sort_unstable();
        self
    }

    /// Lets all waves run out.
    pub fn spread(&mut self) {
        while let Some(Reverse((bits, point, pin))) = self.queue.pop() {
            let Some(label) = self.labels.of_mut(point, pin).filter(|l| l.distance.to_bits() == bits && !l.spread)
            else {
                continue;
            };
            label.spread = true;
            let label = *label;
            self.labels.count(point);
            let mut texel = point;
            loop {
                self.spread_from(texel as usize, label);
                texel = self.next[texel as usize];
                if texel == point {
                    break;
                }
            }
            self.spread_over(point, label);
        }
    }

    /// Over the bridges of a point. A wave that passes between two corners comes to the point of the stitch straight.
    fn spread_over(&mut self, point: u32, label: Label) {
        let mut at = self.ends.partition_point(|(end, ..)| *end < point);
        while let Some(&(_, n, end)) = self.ends.get(at).filter(|(end, ..)| *end == point) {
            at += 1;
            let bridge = self.bridges[n as usize];
            let corners = bridge.corners.map(|k| self.point[k as usize]);
            let end = usize::from(end);
            if end == 4 {
                for (corner, k) in corners.into_iter().enumerate() {
                    self.offer(k, Label { distance: label.distance + bridge.length(corner), spread: false, ..label });
                }
                continue;
            }
            let to = self.point[bridge.particle as usize];
            self.offer(to, Label { distance: label.distance + bridge.length(end), spread: false, ..label });
            for (&side, (a, b)) in bridge.sides.iter().zip(PAIRS) {
                let other = if a == end { b } else { a };
                if side <= 0.0 || (a != end && b != end) {
                    continue;
                }
                let beside = self.labels.of(corners[other], label.pin);
                let (here, there) = (bridge.inner[end], bridge.inner[other]);
                let straight = || unfold(label.distance, beside.distance, side, here, there);
                if let Some(distance) = beside.spread.then(straight).flatten() {
                    self.offer(to, Label { distance: distance + bridge.thread, spread: false, ..label });
                }
            }
        }
    }

    /// The nearest pin of each group kept, nearest first.
    pub fn nearest(&self, texel: usize) -> Vec<Anchor> {
        self.labels.nearest(self.point[texel])
    }

    fn spread_from(&mut self, texel: usize, label: Label) {
        let grid_index = self.firsts.partition_point(|&first| first <= texel).saturating_sub(1);
        let Some(&grid) = self.grids.get(grid_index) else { return };
        let first = self.firsts[grid_index];
        if texel - first >= grid.width as usize * grid.height as usize {
            return;
        }
        let circle = self.circle(&grid, first, texel - first, label.pin);
        let a = label.distance;
        for n in circle.iter().flatten() {
            if n.length > 0.0 && n.distance > a {
                self.offer(n.point, Label { distance: a + n.length, spread: false, ..label });
            }
        }
        for (x, y, stores, kind) in TRIANGLES {
            let (Some(x), Some(y), Some(end)) = (circle[x], circle[y], circle[stores]) else { continue };
            if x.length <= 0.0 || y.length <= 0.0 || !(x.spread || y.spread) {
                continue;
            }
            let side = length(&grid, end.texel, kind);
            if side <= 0.0 {
                continue;
            }
            for (b, c) in [(x, y), (y, x)] {
                // C may be nearer than A and have spread: where its angle is obtuse, the way to it passes between A and B.
                if !b.spread {
                    continue;
                }
                if let Some(distance) = unfold(a, b.distance, b.length, c.length, side) {
                    self.offer(c.point, Label { distance, spread: false, ..label });
                }
            }
        }
    }

    /// The particles around texel `k` of a grid and what they know of a pin.
    fn circle(&self, grid: &SpringGrid<'_>, first: usize, k: usize, pin: u32) -> [Option<Neighbour>; 8] {
        let (w, h) = (grid.width as usize, grid.height as usize);
        let (i, j) = (k % w, k / w);
        let mut circle = [None; 8];
        for (d, &(di, dj)) in CIRCLE.iter().enumerate() {
            let (Some(ni), Some(nj)) = (i.checked_add_signed(di), j.checked_add_signed(dj)) else { continue };
            let n = nj * w + ni;
            if ni >= w || nj >= h || !self.particles.get(first + n).is_some_and(|p| p.exists()) {
                continue;
            }
            // The springs to the left and straight up, and the diagonals that end here, are stored at the neighbour.
            let length = match d {
                0 => length(grid, k, 0),
                1 => length(grid, k, 2),
                2 => length(grid, k, 1),
                3 => length(grid, n, 3),
                4 => length(grid, n, 0),
                5 => length(grid, n, 2),
                6 => length(grid, n, 1),
                _ => length(grid, k, 3),
            };
            let point = self.point[first + n];
            let label = self.labels.of(point, pin);
            circle[d] = Some(Neighbour { point, texel: n, length, distance: label.distance, spread: label.spread });
        }
        circle
    }

    fn offer(&mut self, point: u32, label: Label) {
        if self.labels.offer(point, label) {
            self.queue.push(Reverse((label.distance.to_bits(), point, label.pin)));
        }
    }
}

/// Whether every group is one point.
fn lone_pins(groups: &[u32], point: &[u32]) -> bool {
    let mut pins = Vec::new();
    for (k, &group) in groups.iter().enumerate().filter(|(_, g)| **g != u32::MAX) {
        let group = group as usize;
        if group >= pins.len() {
            pins.resize(group + 1, u32::MAX);
        }
        if pins[group] != u32::MAX && pins[group] != point[k] {
            return false;
        }
        pins[group] = point[k];
    }
    true
}

/// A rest length \[m\], 0 where there is no spring.
pub(super) fn length(grid: &SpringGrid<'_>, texel: usize, kind: usize) -> f64 {
    let length = match grid.rest {
        RestLengths::Constant(all) => all[kind],
        RestLengths::Image(image) => image.get(texel).map_or(0.0, |l| l[kind]),
    };
    if length > 0.0 && length.is_finite() { f64::from(length) } else { 0.0 }
}
