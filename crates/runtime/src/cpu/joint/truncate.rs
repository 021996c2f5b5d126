//! Twin of shaders/truncate.wgsl: puts each particle as near to where it wants to be as its half-spaces let it.

use super::even::Spread;
use super::faces::EDGES;
use super::paths::{end_of, floor_of, largest};
use super::planes::{self, Bound};
use super::{Lists, Patch, TILE};
use crate::levels::safe::{HALVINGS, MAX_PLANES, MERGES, PROJECTIONS, ROUNDING};
use crate::number::real::{Real, V3, add, dot, scale, sub, with_w, xyz};

/// The room of a particle in a round.
#[derive(Clone, Debug)]
pub struct Room<T> {
    /// Half-spaces.
    pub planes: Vec<(V3<T>, T)>,
    /// Whether it has to stay where it is.
    pub still: bool,
    /// Its way, and the radius of the ball around the middle of that in which it stays \[m\].
    way: V3<T>,
    radius: T,
    /// Rounding of a position \[m\].
    slop: T,
    /// By how much less room two half-spaces may leave that become one \[m\].
    merges: T,
}

impl<T: Real> Room<T> {
    fn new(lists: &Lists<T>, patch: &Patch<T>, k: usize) -> Self {
        let (base, way) = (lists.bases[k], xyz(lists.ways[k]));
        let slop = largest(xyz(base)).max(largest(way)) * T::of(ROUNDING);
        let merges = patch.spacing * T::of(MERGES);
        Room { planes: Vec::new(), still: false, way, radius: base[3], slop, merges }
    }

    /// Takes in what keeps the particle apart from a feature.
    fn take(&mut self, bound: Bound<T>) {
        match bound {
            Bound::Free => {}
            Bound::Still => self.still = true,
            Bound::Plane { normal, most } => {
                // All of its ball may lie in it.
                if T::of(0.5) * dot(normal, self.way) + self.radius > most {
                    self.add(normal, most);
                }
            }
        }
    }

    /// Adds a half-space. If it nearly equals another one, or the list is full, the other one shrinks until it implies both.
    fn add(&mut self, normal: V3<T>, most: T) {
        let far = T::of(0.5) * dot(self.way, self.way).sqrt() + self.radius;
        // The room that is left of each other one, and how much less that is.
        let (mut best, mut loss, mut least) = (0, T::of(f64::from(f32::MAX)), T::of(0.0));
        for (n, (other, room)) in self.planes.iter().enumerate() {
            let turn = sub(normal, *other);
            let within = most - dot(turn, turn).sqrt() * far;
            if *room - within < loss {
                (best, loss, least) = (n, *room - within, within);
            }
        }
        if loss > self.merges && self.planes.len() < MAX_PLANES {
            self.planes.push((normal, most));
        } else if let Some((_, room)) = self.planes.get_mut(best) {
            *room = room.min(least);
        }
    }

    fn has(&self, way: V3<T>) -> bool {
        let off = sub(way, scale(self.way, T::of(0.5)));
        !self.still
            && dot(off, off) <= self.radius * self.radius
            && self.planes.iter().all(|(normal, most)| dot(*normal, way) <= *most)
    }

    /// The nearest way that is, after some rounds, nearly in all half-spaces.
    fn project(&self) -> V3<T> {
        let half = scale(self.way, T::of(0.5));
        let radius = self.radius - self.slop;
        let mut way = self.way;
        for _ in 0..PROJECTIONS {
            for (normal, most) in &self.planes {
                let over = dot(*normal, way) - *most;
                if over > T::of(0.0) {
                    way = sub(way, scale(*normal, over + self.slop));
                }
            }
            let off = sub(way, half);
            let long = dot(off, off).sqrt();
            if long > radius {
                way = add(half, scale(off, radius / long));
            }
        }
        way
    }

    /// The position nearest to the end of a way that the room has.
    fn clip(&self, base: V3<T>, way: V3<T>) -> V3<T> {
        let mut share = T::of(1.0);
        for (normal, most) in &self.planes {
            let end = dot(*normal, way);
            if end > *most - self.slop && end > T::of(0.0) {
                share = share.min(((*most - self.slop) / end).max(T::of(0.0)));
            }
        }
        let mut tries = [T::of(1.0); HALVINGS + 1];
        for n in 0..HALVINGS {
            tries[n + 1] = share;
            share = share * T::of(0.5);
        }
        for share in tries {
            let p = add(base, scale(way, share));
            if self.has(sub(p, base)) {
                return p;
            }
        }
        base
    }
}

/// The outcome of a round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Particles that were held back, and pins that left their half-spaces.
    pub held: usize,
    pub forced: usize,
    /// Particles that have farther to go.
    pub more: usize,
}

/// Puts all particles.
pub fn run<T: Real>(lists: &mut Lists<T>) -> Counts {
    let mut counts = Counts::default();
    let mut places = lists.places.clone();
    for g in 0..lists.grids() {
        let patch = lists.patch(g);
        let all = patch.first..patch.first + patch.width * patch.height;
        for k in all.filter(|k| patch.spacing > T::of(0.0) && lists.point(*k) == *k as u32) {
            let (place, held) = put(lists, &patch, k);
            let free = is_free(lists, k);
            counts.held += usize::from(held && free);
            counts.forced += usize::from(held && !free);
            counts.more += usize::from(goes_on(lists, k, place));
            let mut mate = k;
            loop {
                places[mate] = with_w(place, lists.places[mate][3]);
                mate = lists.mate(mate);
                if mate == k {
                    break;
                }
            }
        }
    }
    lists.places = places;
    counts
}

/// Whether the step takes a particle farther than it may go in a round. Half-spaces that held it would hold it in a further round too.
fn goes_on<T: Real>(lists: &Lists<T>, k: usize, place: V3<T>) -> bool {
    let (gone, way) = (sub(place, xyz(lists.bases[k])), xyz(lists.ways[k]));
    end_of(lists, k).1 && dot(gone, gone) > T::of(0.25) * dot(way, way)
}

fn is_free<T: Real>(lists: &Lists<T>, k: usize) -> bool {
    let mut mate = k;
    loop {
        if lists.ways[mate][3] <= T::of(0.0) {
            return false;
        }
        mate = lists.mate(mate);
        if mate == k {
            return true;
        }
    }
}

/// Where a particle goes, and whether half-spaces hold it back.
fn put<T: Real>(lists: &Lists<T>, patch: &Patch<T>, k: usize) -> (V3<T>, bool) {
    let room = room_of(lists, patch, k);
    let (end, _) = end_of(lists, k);
    let base = xyz(lists.bases[k]);
    if room.has(sub(end, base)) {
        return (end, false);
    }
    if is_free(lists, k) { (room.clip(base, room.project()), true) } else { (end, true) }
}

/// The room of a particle: from all features near those that it belongs to.
pub fn room_of<T: Real>(lists: &Lists<T>, patch: &Patch<T>, k: usize) -> Room<T> {
    let mut room = Room::new(lists, patch, k);
    let mut mate = k;
    loop {
        Star::new(lists, *patch, mate).search(&mut room);
        mate = lists.mate(mate);
        if mate == k {
            return room;
        }
    }
}

/// A cell, and the corner of it that is the particle.
#[derive(Clone, Copy)]
struct Own {
    at: [usize; 2],
    place: usize,
    corner: usize,
}

/// The cells around a duplicate of a particle.
struct Star<'a, T: Real> {
    lists: &'a Lists<T>,
    patch: Patch<T>,
    tile: [usize; 2],
    cells: Vec<Own>,
    low: V3<T>,
    high: V3<T>,
    /// Whether the tiles around cannot meet one another.
    calm: bool,
}

impl<'a, T: Real> Star<'a, T> {
    fn new(lists: &'a Lists<T>, of: Patch<T>, k: usize) -> Self {
        // Duplicates may lie in another grid of the cloth.
        let has = |p: &Patch<T>| (p.first..p.first + p.width * p.height).contains(&k);
        let patch = if has(&of) { of } else { (0..lists.grids()).map(|g| lists.patch(g)).find(has).unwrap_or(of) };
        let [i, j] = [(k - patch.first) % patch.width, (k - patch.first) / patch.width];
        let far = T::of(f64::from(f32::MAX));
        let (mut cells, mut low, mut high) = (Vec::new(), [far; 3], [-far; 3]);
        for (corner, [left, up]) in [[0, 0], [0, 1], [1, 1], [1, 0]].into_iter().enumerate() {
            if i < left || j < up {
                continue;
            }
            let at = [i - left, j - up];
            let place = patch.place(at);
            let [a, b] = bounds(lists, lists.cell(place));
            for c in 0..3 {
                (low[c], high[c]) = (low[c].min(a[c]), high[c].max(b[c]));
            }
            cells.push(Own { at, place, corner });
        }
        let mut star = Star { lists, patch, tile: [i / 4, j / 4], cells, low, high, calm: false };
        star.calm = star.is_calm(k);
        star
    }

    fn is_calm(&self, k: usize) -> bool {
        let Patch { width, height, tile, .. } = self.patch;
        if width < 3 || height < 3 {
            return false;
        }
        let columns = width.div_ceil(4);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let mut all = Spread::none();
        for row in near(self.tile[1], height.div_ceil(4)) {
            for column in near(self.tile[0], columns) {
                let at = self.lists.spread(tile + row * columns + column);
                let rows = &self.lists.boxes[at..at + 4];
                all = all.with(&Spread {
                    right: [xyz(rows[0]), xyz(rows[1])],
                    down: [xyz(rows[2]), xyz(rows[3])],
                    reach: rows[0][3],
                    even: rows[1][3] > T::of(0.0),
                });
            }
        }
        all.is_apart(floor_of(self.lists, &self.patch, k))
    }

    /// Whether a box meets that of these cells.
    fn meets(&self, at: usize) -> bool {
        overlap([self.low, self.high], bounds(self.lists, at))
    }

    fn search(&self, room: &mut Room<T>) {
        for g in 0..self.lists.grids() {
            let at = self.lists.table[2] as usize + 2 * g;
            let [rows, count] = [self.lists.table[at] as usize, self.lists.table[at + 1] as usize];
            self.descend(room, (g, rows), count - 1, [0, 0]);
        }
    }

    fn descend(&self, room: &mut Room<T>, (g, rows): (usize, usize), level: usize, at: [usize; 2]) {
        let row = &self.lists.table[rows + 3 * level..][..3];
        let [first, columns, lines] = [0, 1, 2].map(|n| row[n] as usize);
        if at[0] >= columns || at[1] >= lines || !self.meets(2 * (first + at[1] * columns + at[0])) {
            return;
        }
        if level > 0 {
            for n in 0..4 {
                self.descend(room, (g, rows), level - 1, [2 * at[0] + n % 2, 2 * at[1] + n / 2]);
            }
            return;
        }
        let beside = |d: usize| at[d].abs_diff(self.tile[d]) <= 1;
        if self.calm && g == self.patch.number && beside(0) && beside(1) {
            return;
        }
        let other = self.lists.patch(g);
        for lane in 0..TILE {
            let cell = [4 * at[0] + lane % 4, 4 * at[1] + lane / 4];
            let place = (first + at[1] * columns + at[0]) * TILE + lane;
            if cell[0] + 1 < other.width && cell[1] + 1 < other.height && self.meets(self.lists.cell(place)) {
                self.cells.iter().for_each(|own| self.compare(room, *own, (other, cell, place)));
            }
        }
    }

    /// Takes in what keeps the features of one of its cells apart from those of another cell.
    fn compare(&self, room: &mut Room<T>, own: Own, (other, cell, place): (Patch<T>, [usize; 2], usize)) {
        let lists = self.lists;
        let [a, b] = [own.place, place].map(|place| bounds(lists, lists.cell(place)));
        if !overlap(a, b) || (other.number == self.patch.number && self.are_even(own.at, cell)) {
            return;
        }
        let bits = |place: usize| lists.boxes[lists.cell(place)][3].get() as u32;
        let (mine, theirs) = (bits(own.place), bits(place));
        if mine & 3 == 0 || theirs & 3 == 0 {
            return;
        }
        let (one, two) = (self.patch.corners(own.at), other.corners(cell));
        let floor = floor_of(lists, &self.patch, one[own.corner]).max(floor_of(lists, &other, two[first_of(theirs)]));
        let shared =
            |a: &[usize], b: &[usize]| a.iter().any(|p| b.iter().any(|q| lists.point(one[*p]) == lists.point(two[*q])));
        let near =
            |a: &[usize], b: &[usize]| overlap(around(lists, &one, a, floor), around(lists, &two, b, T::of(0.0)));
        let meet = |a: &[usize], b: &[usize]| !shared(a, b) && near(a, b);
        let q = own.corner;
        // Edges from the corner, around the cell and across it.
        for mine_at in [q, (q + 3) % 4, 4 + q % 2] {
            for (theirs_at, f) in EDGES.into_iter().enumerate() {
                let e = EDGES[mine_at];
                if mine >> (10 + mine_at) & 1 == 1 && theirs >> (10 + theirs_at) & 1 == 1 && meet(&e, &f) {
                    let who = usize::from(e[1] == q);
                    let (a, b) = (e.map(|n| one[n]), f.map(|n| two[n]));
                    // Both sides of a pair have it in the same order.
                    let bound = if 6 * own.place + mine_at < 6 * place + theirs_at {
                        planes::bound(lists, ([a[0], a[1], b[0], b[1]], true, who), floor)
                    } else {
                        planes::bound(lists, ([b[0], b[1], a[0], a[1]], true, 2 + who), floor)
                    };
                    room.take(bound);
                }
            }
        }
        for n in 0..2 {
            let corners = corners_of(mine, n);
            for vertex in (0..4).filter(|v| corners.contains(&q) && theirs >> (16 + v) & 1 == 1) {
                if meet(&corners, &[vertex]) {
                    let [a, b, c] = [0, 1, 2].map(|n| corners[n]);
                    let who = 1 + corners.iter().position(|corner| *corner == q).unwrap_or(0);
                    room.take(planes::bound(lists, ([two[vertex], one[a], one[b], one[c]], false, who), floor));
                }
            }
        }
        for n in (0..2).filter(|_| mine >> (16 + q) & 1 == 1) {
            let corners = corners_of(theirs, n);
            if corners.len() == 3 && meet(&[q], &corners) {
                let [a, b, c] = [0, 1, 2].map(|n| two[corners[n]]);
                room.take(planes::bound(lists, ([one[q], a, b, c], false, 0), floor));
            }
        }
    }

    /// Whether two cells of the grid lie in an even block.
    fn are_even(&self, [i, j]: [usize; 2], [m, n]: [usize; 2]) -> bool {
        // The line of texels between both, or one beside a single one.
        let line = |at: usize, other: usize, count: usize| {
            let line = match other.cmp(&at) {
                std::cmp::Ordering::Less => at,
                std::cmp::Ordering::Equal => (at + 1).min(count.saturating_sub(2)),
                std::cmp::Ordering::Greater => at + 1,
            };
            (count > 2 && at.abs_diff(other) <= 1 && (1..count - 1).contains(&line)).then_some(line)
        };
        let (Some(i), Some(j)) = (line(i, m, self.patch.width), line(j, n, self.patch.height)) else { return false };
        let cell = self.lists.cell(self.patch.place([i, j]));
        self.lists.boxes[cell][3].get() as u32 >> 20 & 1 == 1
    }
}

/// The corners of a triangle of a cell; none of one that it has not.
fn corners_of(bits: u32, n: usize) -> Vec<usize> {
    (0..4).filter(|corner| bits >> n & 1 == 1 && bits >> (2 + 4 * n + corner) & 1 == 1).collect()
}

/// The first corner of the triangles of a cell.
fn first_of(bits: u32) -> usize {
    (bits >> 2 | bits >> 6).trailing_zeros() as usize % 4
}

/// Around the balls of some corners of a cell, and `wide` more.
fn around<T: Real>(lists: &Lists<T>, corners: &[usize; 4], some: &[usize], wide: T) -> [V3<T>; 2] {
    let far = T::of(f64::from(f32::MAX));
    let (mut low, mut high) = ([far; 3], [-far; 3]);
    for n in some {
        let ball = lists.ball(corners[*n]);
        for c in 0..3 {
            low[c] = low[c].min(ball.center[c] - ball.radius - wide);
            high[c] = high[c].max(ball.center[c] + ball.radius + wide);
        }
    }
    [low, high]
}

fn bounds<T: Real>(lists: &Lists<T>, at: usize) -> [V3<T>; 2] {
    [xyz(lists.boxes[at]), xyz(lists.boxes[at + 1])]
}

fn overlap<T: Real>([low, high]: [V3<T>; 2], [a, b]: [V3<T>; 2]) -> bool {
    (0..3).all(|c| low[c] <= b[c] && a[c] <= high[c])
}
