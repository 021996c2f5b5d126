//! Points of triangles, and points by cells of space.

use std::collections::HashMap;

use crate::commands::character::cross;

/// A side of a triangle is split into at most this number of parts.
const MAX_SPLITS: usize = 64;

pub type Point = [f64; 3];

pub fn squared(a: &Point, b: &Point) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

/// A vector of length 1; `None` of one that is zero or not finite.
pub fn unit(v: Point) -> Option<Point> {
    let length = squared(&v, &[0.0; 3]).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|x| x / length))
}

/// The normal of a triangle, of twice the length of its area.
pub fn face([a, b, c]: [Point; 3]) -> Point {
    cross([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]))
}

/// Points of an edge that are at most `spacing` \[m\] apart.
pub fn on_edge(a: Point, b: Point, spacing: f64) -> impl Iterator<Item = Point> {
    let n = parts(a, b, spacing);
    (0..=n).map(move |i| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * (i as f64 / n as f64)))
}

/// Points of a triangle that are at most `spacing` \[m\] apart.
pub fn on_triangle([a, b, c]: [Point; 3], spacing: f64) -> Vec<Point> {
    let n = parts(a, b, spacing).max(parts(b, c, spacing)).max(parts(c, a, spacing));
    let weight = |k: usize| k as f64 / n as f64;
    let pairs = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
    pairs.map(|(i, j)| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * weight(i) + (c[k] - a[k]) * weight(j))).collect()
}

/// Parts of an edge no longer than the spacing.
fn parts(a: Point, b: Point, spacing: f64) -> usize {
    ((squared(&a, &b).sqrt() / spacing).ceil() as usize).clamp(1, MAX_SPLITS)
}

/// The cell of a size \[m\] that has a point.
pub fn cell(p: &Point, size: f64) -> [i64; 3] {
    p.map(|x| (x / size).floor() as i64)
}

/// A cell and all that are at most `most` cells from it.
pub fn cells_around(cell: [i64; 3], most: i64) -> impl Iterator<Item = [i64; 3]> {
    let wide = 2 * most + 1;
    (0..wide * wide * wide).map(move |n| {
        let step = [n % wide, n / wide % wide, n / (wide * wide)];
        [0, 1, 2].map(|k| cell[k].saturating_add(step[k] - most))
    })
}

/// Points by cells of a size.
pub struct Cells {
    size: f64,
    cells: HashMap<[i64; 3], Vec<Point>>,
}

impl Cells {
    pub fn new(size: f64) -> Self {
        Cells { size, cells: HashMap::new() }
    }

    pub fn add(&mut self, p: Point) {
        self.cells.entry(cell(&p, self.size)).or_default().push(p);
    }

    /// The distance to the nearest point within the size of a cell.
    pub fn nearest(&self, p: &Point, counts: impl Fn(&Point) -> bool) -> Option<f64> {
        let around = cells_around(cell(p, self.size), 1);
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten().filter(|q| counts(q));
        let least = near.map(|q| squared(p, q)).fold(f64::INFINITY, f64::min).sqrt();
        (least <= self.size).then_some(least)
    }
}
