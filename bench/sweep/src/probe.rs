//! Distances between a source and its image, by code of its own: none of it is the pipeline's.
//!
//! A tree of boxes over triangles, halved at the median of the longest side; the distance to a triangle after Ericson,
//! "Real-Time Collision Detection", 5.1.5. Coordinates are scaled to the source, so that any size can be measured.

use gimage_bundle::Image;

use crate::random::Random;
use crate::record::Probe;

/// Samples on each surface.
const SAMPLES: usize = 4000;

/// Triangles of a leaf of the tree.
const LEAF: usize = 4;

type Point = [f64; 3];
type Triangle = [Point; 3];

/// A surface as loose triangles.
pub struct Surface {
    triangles: Vec<Triangle>,
}

impl Surface {
    /// Of these corners.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        Self { triangles }
    }

    /// Of a position map: two triangles a quad by its shorter diagonal, quads with an absent corner left out.
    pub fn of_image(image: &Image) -> Self {
        let (w, h, c) = (image.width as usize, image.height as usize, image.channels as usize);
        let at = |k: usize| [0, 1, 2].map(|d| f64::from(image.data[k * c + d]));
        let there = |k: usize| image.data[k * c + 3] != 0.0;
        let mut out = Vec::new();
        for j in 1..h {
            for i in 1..w {
                let quad = [(j - 1) * w + i - 1, (j - 1) * w + i, j * w + i, j * w + i - 1];
                if !quad.iter().all(|&k| there(k)) {
                    continue;
                }
                let [p, q, r, s] = quad.map(at);
                let short = length(sub(p, r)) <= length(sub(q, s));
                out.extend(if short { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] });
            }
        }
        Self { triangles: out }
    }

    fn bounds(&self) -> (Point, Point) {
        let mut out = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in self.triangles.iter().flatten() {
            (0..3).for_each(|c| (out.0[c], out.1[c]) = (out.0[c].min(p[c]), out.1[c].max(p[c])));
        }
        out
    }

    /// Points spread by area.
    fn samples(&self, seed: u64) -> Vec<Point> {
        let mut sums = Vec::with_capacity(self.triangles.len());
        let mut total = 0.0;
        for &[a, b, c] in &self.triangles {
            total += length(cross(sub(b, a), sub(c, a)));
            sums.push(total);
        }
        if !(total > 0.0 && total.is_finite()) {
            return self.triangles.iter().map(|t| t[0]).take(SAMPLES).collect();
        }
        let mut r = Random::new(seed, 0);
        (0..SAMPLES)
            .map(|k| {
                let want = total * (k as f64 + r.unit()) / SAMPLES as f64;
                let [a, b, c] = self.triangles[sums.partition_point(|&s| s < want).min(sums.len() - 1)];
                let (mut u, mut v) = (r.unit(), r.unit());
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                [0, 1, 2].map(|d| a[d] + u * (b[d] - a[d]) + v * (c[d] - a[d]))
            })
            .collect()
    }
}

/// Compares an image with its source. Where the source is more than the image's own (`both` false), only the way back
/// to it is measured.
pub fn compare(source: &Surface, image: &Surface, both: bool) -> Probe {
    let (lo, hi) = source.bounds();
    let size = (0..3).map(|c| hi[c] - lo[c]).fold(0.0, f64::max);
    if source.triangles.is_empty() || image.triangles.is_empty() || !(size > 0.0 && size.is_finite()) {
        return Probe { outside: if image.triangles.is_empty() { 0.0 } else { f64::MAX }, ..Probe::default() };
    }
    let scaled = |s: &Surface| Surface {
        triangles: s.triangles.iter().map(|t| t.map(|p| [0, 1, 2].map(|c| (p[c] - lo[c]) / size))).collect(),
    };
    let (source, image) = (scaled(source), scaled(image));
    let ((lo, hi), (from, to)) = (source.bounds(), image.bounds());
    let diagonal = length(sub(hi, lo));
    let outside = (0..3).map(|c| (lo[c] - from[c]).max(to[c] - hi[c])).fold(0.0, f64::max) / diagonal;
    let back = distances(&image, &source);
    let mut out =
        Probe { outside, rms_back: Some(back.0 / diagonal), hausdorff: Some(back.1 / diagonal), rms_out: None };
    if both {
        let there = distances(&source, &image);
        out.rms_out = Some(there.0 / diagonal);
        out.hausdorff = Some(there.1.max(back.1) / diagonal);
    }
    out
}

/// Root mean square and largest distance from samples of one surface to another.
fn distances(from: &Surface, to: &Surface) -> (f64, f64) {
    let tree = Tree::new(&to.triangles);
    let all: Vec<f64> = from.samples(1).into_iter().map(|p| tree.distance(p)).collect();
    let mean = all.iter().map(|d| d * d).sum::<f64>() / all.len().max(1) as f64;
    (mean.sqrt(), all.iter().copied().fold(0.0, f64::max))
}

/// Boxes over runs of triangles; node k has the children 2 k + 1 and 2 k + 2.
struct Tree {
    triangles: Vec<Triangle>,
    boxes: Vec<(Point, Point)>,
}

impl Tree {
    fn new(triangles: &[Triangle]) -> Self {
        let mut triangles = triangles.to_vec();
        let mut boxes = Vec::new();
        Self::halve(&mut triangles, 0, &mut boxes);
        Self { triangles, boxes }
    }

    fn halve(part: &mut [Triangle], node: usize, boxes: &mut Vec<(Point, Point)>) {
        let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in part.iter().flatten() {
            (0..3).for_each(|c| (bounds.0[c], bounds.1[c]) = (bounds.0[c].min(p[c]), bounds.1[c].max(p[c])));
        }
        if boxes.len() <= node {
            boxes.resize(node + 1, ([0.0; 3], [0.0; 3]));
        }
        boxes[node] = bounds;
        if part.len() <= LEAF {
            return;
        }
        let side = |c: usize| bounds.1[c] - bounds.0[c];
        let axis = (0..3).fold(0, |best, c| if side(c) > side(best) { c } else { best });
        let key = |t: &Triangle| t[0][axis] + t[1][axis] + t[2][axis];
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        let (left, right) = part.split_at_mut(middle);
        Self::halve(left, 2 * node + 1, boxes);
        Self::halve(right, 2 * node + 2, boxes);
    }

    fn distance(&self, p: Point) -> f64 {
        let mut best = f64::INFINITY;
        self.visit(p, 0, 0, self.triangles.len(), &mut best);
        best.sqrt()
    }

    fn visit(&self, p: Point, node: usize, from: usize, to: usize, best: &mut f64) {
        if self.gap(p, node) >= *best {
            return;
        }
        if to - from <= LEAF {
            for t in &self.triangles[from..to] {
                *best = best.min(squared(p, t));
            }
            return;
        }
        let middle = from + (to - from) / 2;
        let children = [(2 * node + 1, from, middle), (2 * node + 2, middle, to)];
        let nearer = usize::from(self.gap(p, children[0].0) > self.gap(p, children[1].0));
        for (node, from, to) in [children[nearer], children[1 - nearer]] {
            self.visit(p, node, from, to, best);
        }
    }

    /// Squared distance to a box.
    fn gap(&self, p: Point, node: usize) -> f64 {
        let (lo, hi) = self.boxes[node];
        (0..3).map(|c| (lo[c] - p[c]).max(p[c] - hi[c]).max(0.0).powi(2)).sum()
    }
}

/// Squared distance from a point to a triangle.
fn squared(p: Point, &[a, b, c]: &Triangle) -> f64 {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let n = cross(ab, ac);
    let area = dot(n, n);
    let inside = area > 0.0 && {
        let (v, w) = (dot(cross(ap, ac), n) / area, dot(cross(ab, ap), n) / area);
        v >= 0.0 && w >= 0.0 && v + w <= 1.0
    };
    if inside {
        return dot(ap, n).powi(2) / area;
    }
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .map(|(q, r)| {
            let (d, x) = (sub(r, q), sub(p, q));
            let whole = dot(d, d);
            let t = if whole > 0.0 { (dot(x, d) / whole).clamp(0.0, 1.0) } else { 0.0 };
            let gap = [0, 1, 2].map(|k| x[k] - t * d[k]);
            dot(gap, gap)
        })
        .fold(f64::INFINITY, f64::min)
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|c| a[c] - b[c])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;

    fn surface(s: &Shape) -> Surface {
        Surface::new(s.triangles.iter().map(|t| t.map(|v| s.positions[v as usize])).collect())
    }

    #[test]
    fn the_tree_finds_the_nearest_of_all_triangles() {
        let mut r = Random::new(5, 0);
        let soup: Vec<Triangle> = (0..300).map(|_| [r.point(), r.point(), r.point()]).collect();
        let tree = Tree::new(&soup);
        for _ in 0..200 {
            let p = r.point().map(|x| 2.0 * x);
            let plain = soup.iter().map(|t| squared(p, t)).fold(f64::INFINITY, f64::min).sqrt();
            assert_eq!(tree.distance(p), plain);
        }
    }

    #[test]
    fn a_sheet_beside_its_source_is_as_far_as_it_was_moved() {
        for scale in [1e-18, 1.0, 1e18] {
            let sheet = |z: f64| surface(&Shape::sheet(9, 9, |u, v| [scale * u, scale * v, scale * z]));
            let p = compare(&sheet(0.0), &sheet(0.01), true);
            let far = 0.01 / 2f64.sqrt();
            for d in [Some(p.outside), p.rms_out, p.rms_back, p.hausdorff] {
                assert!((d.unwrap() - far).abs() < 1e-9, "{scale}: {p:?}");
            }
        }
    }

    #[test]
    fn a_texel_far_away_is_outside() {
        let source = Shape::sheet(9, 9, |u, v| [u, v, 0.0]);
        let mut image = source.clone();
        image.positions[40][2] = 1e11;
        let p = compare(&surface(&source), &surface(&image), true);
        assert!(p.outside > 1e10 && p.hausdorff.unwrap() > 1e10 && p.rms_back.unwrap() > 1e8, "{p:?}");
    }
}
