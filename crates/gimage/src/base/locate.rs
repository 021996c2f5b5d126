//! Which disk triangle covers a point of the plane.

use crate::stage::cut::disk::Disk;
use crate::stage::parameterize::distortion::{planar, signed_area2};
use crate::stage::sample::resample::Sample;

/// The triangles of a map sorted into the cells of its rectangle.
pub(crate) struct Locator<'a> {
    disk: &'a Disk,
    uv: &'a [[f64; 2]],
    w: usize,
    h: usize,
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl<'a> Locator<'a> {
    /// For a flip-free map onto `w` x `h` cells. O(triangles + cells).
    pub(crate) fn new(disk: &'a Disk, uv: &'a [[f64; 2]], w: usize, h: usize) -> Self {
        let cells = |t: [u32; 3]| {
            let p = planar(uv, t);
            let range = |c: usize, n: usize| {
                let lo = p.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min) - 1e-9;
                let hi = p.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max) + 1e-9;
                (lo.max(0.0) as usize).min(n - 1)..=(hi.max(0.0) as usize).min(n - 1)
            };
            let (columns, rows) = (range(0, w), range(1, h));
            rows.flat_map(move |j| columns.clone().map(move |i| j * w + i))
        };
        let mut first = vec![0u32; w * h + 1];
        disk.triangles.iter().for_each(|&t| cells(t).for_each(|c| first[c + 1] += 1));
        (0..w * h).for_each(|c| first[c + 1] += first[c]);
        let mut next = first.clone();
        let mut triangles = vec![0u32; first[w * h] as usize];
        for (f, &t) in disk.triangles.iter().enumerate() {
            for c in cells(t) {
                triangles[next[c] as usize] = f as u32;
                next[c] += 1;
            }
        }
        Self { disk, uv, w, h, first, triangles }
    }

    /// The disk triangles whose image meets the box of the cell that holds a point of the rectangle.
    pub(crate) fn around(&self, q: [f64; 2]) -> &[u32] {
        let cell = |x: f64, n: usize| (x.max(0.0) as usize).min(n - 1);
        let cell = cell(q[1], self.h) * self.w + cell(q[0], self.w);
        &self.triangles[self.first[cell] as usize..self.first[cell + 1] as usize]
    }

    /// The place on the disk of a point of the rectangle, in cells; the most central triangle where rounding leaves a
    /// choice. `None` outside the rectangle.
    pub(crate) fn at(&self, q: [f64; 2]) -> Option<Sample> {
        let inside = |x: f64, n: usize| (0.0..=n as f64).contains(&x);
        if !inside(q[0], self.w) || !inside(q[1], self.h) {
            return None;
        }
        let cell = (q[1] as usize).min(self.h - 1) * self.w + (q[0] as usize).min(self.w - 1);
        let mut best: Option<(f64, Sample)> = None;
        for &f in &self.triangles[self.first[cell] as usize..self.first[cell + 1] as usize] {
            let p = planar(self.uv, self.disk.triangles[f as usize]);
            let area = signed_area2(p);
            if area <= 0.0 {
                continue;
            }
            let b1 = signed_area2([p[0], q, p[2]]) / area;
            let b2 = signed_area2([p[0], p[1], q]) / area;
            let bary = [1.0 - b1 - b2, b1, b2];
            let inside = bary.iter().copied().fold(f64::INFINITY, f64::min);
            if best.is_none_or(|b| inside > b.0) {
                best = Some((inside, Sample { triangle: f, bary }));
            }
        }
        best.map(|(_, mut s)| {
            s.bary = s.bary.map(|b| b.max(0.0));
            let sum: f64 = s.bary.iter().sum();
            s.bary = s.bary.map(|b| b / sum);
            s
        })
    }
}
