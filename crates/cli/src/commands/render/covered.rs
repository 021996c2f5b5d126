//! Parts of a body that clothes cover: near the borders of clothes they are drawn deeper within the body, and elsewhere not at all, so that
//! skin does not show where it bulges through cloth.
//!
//! Cloth rests on the colliders of the body, which are rigid, while the skin between two of them bulges as a joint bends: at the shoulders by
//! more than a centimetre.

use std::collections::HashMap;

use gimage::mesh::Mesh;

/// How far \[m\] within its surface a body is drawn at least: cloth lies on colliders, which are that near to it at best.
const INSET: f64 = 0.004;
/// The same below clothes, at most.
pub const DEEP: f64 = 0.025;
/// How near \[m\] a garment covers, and how far from its borders it hides the body.
const NEAR: f64 = 0.05;
const BORDER: f64 = 0.06;
/// Points of a garment are that far apart \[m\] at most, and a side of a triangle has at most `MAX_SPLITS`.
const SPACING: f64 = 0.015;
const MAX_SPLITS: usize = 64;

type Point = [f64; 3];

/// How far \[m\] within the surface each vertex of a mesh is drawn; infinite where cloth hides it from all sides, for the unit normals of the vertices. O(vertices and points of cloth).
pub fn depths(mesh: &Mesh, is_cloth: impl Fn(u32) -> bool, normals: &[Point]) -> Vec<f64> {
    let worn: Vec<[u32; 3]> =
        mesh.triangles.iter().zip(&mesh.triangle_part).filter(|(_, part)| is_cloth(**part)).map(|(t, _)| *t).collect();
    let at = |v: u32| mesh.positions[v as usize];
    // Vertices of one position are one: a seam of a texture is not a border.
    let mut first: HashMap<[u64; 3], u32> = HashMap::new();
    let mut weld = |v: u32| *first.entry(at(v).map(f64::to_bits)).or_insert(v);
    let mut points = Cells::new(NEAR);
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    for t in &worn {
        let [a, b, c] = t.map(at);
        let n = splits(a, b).max(splits(b, c)).max(splits(c, a));
        let weight = |k: usize| k as f64 / n as f64;
        let pairs = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        pairs.for_each(|(i, j)| {
            points.add([0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * weight(i) + (c[k] - a[k]) * weight(j)))
        });
        for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (p, q) = (weld(p), weld(q));
            *sides.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
    }
    let mut borders = Cells::new(BORDER);
    for ([p, q], _) in sides.iter().filter(|(_, count)| **count == 1) {
        let (p, q) = (at(*p), at(*q));
        let n = splits(p, q);
        (0..=n).for_each(|k| borders.add(between(p, q, k as f64 / n as f64)));
    }
    let depth = |(p, normal): (&Point, &Point)| {
        // Cloth above the skin, or, within twice the inset, anywhere.
        let above = |q: &Point| {
            let length = squared(q, p).sqrt();
            let along = (0..3).map(|k| (q[k] - p[k]) * normal[k]).sum::<f64>();
            length < 2.0 * INSET || along > 0.5 * length
        };
        if points.nearest(p, above).is_none() {
            return INSET;
        }
        let far = borders.nearest(p, |_| true).map_or(1.0, |d| d / BORDER);
        // Where no border is found, a garment may be a closed shell, through whose openings the body shows.
        if far >= 1.0 && !borders.cells.is_empty() {
            return f64::INFINITY;
        }
        INSET + (DEEP - INSET) * far * far * (3.0 - 2.0 * far)
    };
    mesh.positions.iter().zip(normals).map(depth).collect()
}

fn between(a: Point, b: Point, s: f64) -> Point {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * s)
}

fn squared(a: &Point, b: &Point) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

/// Parts of an edge no longer than the spacing.
fn splits(a: Point, b: Point) -> usize {
    ((squared(&a, &b).sqrt() / SPACING).ceil() as usize).clamp(1, MAX_SPLITS)
}

/// Points by cells of a size.
struct Cells {
    size: f64,
    cells: HashMap<[i64; 3], Vec<Point>>,
}

impl Cells {
    fn new(size: f64) -> Self {
        Cells { size, cells: HashMap::new() }
    }

    fn add(&mut self, p: Point) {
        self.cells.entry(p.map(|x| (x / self.size).floor() as i64)).or_default().push(p);
    }

    /// The distance to the nearest point within the size of a cell.
    fn nearest(&self, p: &Point, counts: impl Fn(&Point) -> bool) -> Option<f64> {
        let cell = p.map(|x| (x / self.size).floor() as i64);
        let around = (0..27).map(|n: i64| {
            [
                cell[0].saturating_add(n % 3 - 1),
                cell[1].saturating_add(n / 3 % 3 - 1),
                cell[2].saturating_add(n / 9 - 1),
            ]
        });
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten().filter(|q| counts(q));
        let least = near.map(|q| squared(p, q)).fold(f64::INFINITY, f64::min).sqrt();
        (least <= self.size).then_some(least)
    }
}
