//! The distance from a surface to its image, bounded at a few thousand points without a search tree.
//!
//! The map tells where on the image each point of the surface went, so the distance to the texel triangles around that
//! place bounds the distance to the image from above. The bound is near the true distance for a good map and grows
//! without limit for a bad one. Where the map is far from an isometry, points of the image are compared with the surface
//! around their place too: texels may then span what the surface does not fill. That is enough to choose between images
//! of one surface and to notice a wreck; the exact figures are those of [`crate::stage::measure`].

use rayon::prelude::*;

use crate::base::grid::Grid;
use crate::base::locate::Locator;
use crate::base::surface::Surface;
use crate::base::vec3::{add, cross, distance, dot, norm, scale, sub};
use crate::stage::cut::disk::Disk;
use crate::stage::parameterize::distortion::{CHUNK, Distortion};

/// Points of the surface at which an image is judged.
const POINTS: usize = 2000;

/// The quality of an image. Lengths are in units of the diagonal of the surface's bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Root mean square distance from the surface to the image (and back, where the map is far from an isometry), at most.
    pub rms: f64,
    /// Largest of these distances at the points judged, at most.
    pub largest: f64,
    /// How far the farthest texel lies outside the surface's bounding box.
    pub outside: f64,
    /// Share of the surface whose image faces the other way, each point compared with its own place on the image.
    pub folded: f64,
    /// Mean angle between a point's normal and that of its place on the image \[degrees\].
    pub normal_degrees: f64,
}

impl Verdict {
    /// The image of one that could not be judged: worse than any other.
    pub(crate) const WORST: Self =
        Self { rms: f64::INFINITY, largest: f64::INFINITY, outside: f64::INFINITY, folded: 1.0, normal_degrees: 180.0 };

    /// 20 log10(1 / `rms`) \[dB\]: a lower bound of the PSNR from the surface to the image.
    pub fn psnr(&self) -> f64 {
        -20.0 * self.rms.log10()
    }

    /// One number to choose by: the larger of the RMS distance and what the extremes make of it.
    pub(crate) fn badness(&self) -> f64 {
        let b = self.rms.max(0.02 * self.largest).max(0.1 * self.outside);
        if b.is_finite() { b } else { f64::INFINITY }
    }
}

/// Energy or stretch of a map above which its image is judged in both directions: texels may then span what the surface
/// does not fill. Maps of clean garments stay below it.
const DISTORTED: f64 = 15.0;

/// Finds triangles by place on the image, where the map is so far from an isometry that both directions count.
pub(crate) fn locator_if_distorted<'a>(
    disk: &'a Disk,
    uv: &'a [[f64; 2]],
    distortion: &Distortion,
    w: usize,
    h: usize,
) -> Option<Locator<'a>> {
    let far = distortion.symmetric_dirichlet > DISTORTED || distortion.linf > DISTORTED;
    far.then(|| Locator::new(disk, uv, w, h))
}

/// The bounding box of a surface.
pub(crate) fn bounds(surface: &Surface) -> [[f64; 3]; 2] {
    let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    surface
        .positions
        .iter()
        .fold(start, |[lo, hi], p| [[0, 1, 2].map(|c| lo[c].min(p[c])), [0, 1, 2].map(|c| hi[c].max(p[c]))])
}

/// How far the farthest of `points` lies outside a box, in units of its diagonal.
pub(crate) fn outside([lo, hi]: [[f64; 3]; 2], points: &[[f64; 3]]) -> f64 {
    let diagonal = distance(lo, hi).max(1e-300);
    let beyond = |p: &[f64; 3]| -> f64 {
        let d = [0, 1, 2].map(|c| (lo[c] - p[c]).max(p[c] - hi[c]).max(0.0));
        if p.iter().all(|x| x.is_finite()) { norm(d) / diagonal } else { f64::INFINITY }
    };
    points.iter().map(beyond).fold(0.0, f64::max)
}

/// Judges the image that `grid` makes of a disk mapped to `uv` (in texels), in both directions if there is a `locator`.
/// O(triangles + texels) and a few thousand points.
pub(crate) fn judge(
    surface: &Surface,
    disk: &Disk,
    uv: &[[f64; 2]],
    grid: &Grid,
    locator: Option<&Locator<'_>>,
) -> Verdict {
    let frame = bounds(surface);
    let diagonal = distance(frame[0], frame[1]);
    let outside = outside(frame, &grid.positions);
    let corners = |t: [u32; 3]| t.map(|v| disk.positions[v as usize]);
    let mut sum = 0.0;
    let cumulative: Vec<f64> = disk
        .triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = corners(t);
            sum += 0.5 * norm(cross(sub(b, a), sub(c, a)));
            sum
        })
        .collect();
    if !(diagonal > 0.0 && sum > 0.0 && sum.is_finite()) {
        return Verdict::WORST;
    }
    let image = Image { grid, columns: grid.width - 1, rows: grid.height - 1 };
    let at = |i: usize| -> (f64, f64) {
        let target = (i as f64 + 0.5) / POINTS as f64 * sum;
        let t = disk.triangles[cumulative.partition_point(|&c| c <= target).min(cumulative.len() - 1)];
        // The R2 sequence (Roberts 2018), folded into the triangle.
        let [mut x, mut y] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2].map(|g| (0.5 + g * i as f64).fract());
        if x + y > 1.0 {
            (x, y) = (1.0 - x, 1.0 - y);
        }
        let b = [1.0 - x - y, x, y];
        let [p, q, r] = corners(t);
        let point = add(add(scale(p, b[0]), scale(q, b[1])), scale(r, b[2]));
        let place = [0, 1].map(|c| (0..3).map(|k| b[k] * uv[t[k] as usize][c]).sum::<f64>());
        let (near, facing) = image.nearest(place, point);
        let normal = cross(sub(q, p), sub(r, p));
        let cosine = |facing: [f64; 3]| dot(normal, facing) / (norm(normal) * norm(facing)).max(1e-300);
        // A texel slid over a sharp edge is not a fold: either triangle may speak for the point.
        (near / diagonal, cosine(facing[0]).max(cosine(facing[1])))
    };
    let found: Vec<(f64, f64)> = (0..POINTS).into_par_iter().with_min_len(CHUNK).map(at).collect();
    let n = POINTS as f64;
    let back = locator.map_or_else(Vec::new, |l| image.towards(disk, l, diagonal));
    let rms = |d: &mut dyn Iterator<Item = f64>| (d.map(|x| x * x).sum::<f64>() / n).sqrt();
    Verdict {
        rms: rms(&mut found.iter().map(|x| x.0)).max(rms(&mut back.iter().copied())),
        largest: found.iter().map(|x| x.0).chain(back).fold(0.0, f64::max),
        outside,
        folded: found.iter().filter(|x| x.1 < 0.0).count() as f64 / n,
        normal_degrees: found.iter().map(|x| x.1.clamp(-1.0, 1.0).acos().to_degrees()).sum::<f64>() / n,
    }
}

/// The surface that a grid of texels draws.
struct Image<'a> {
    grid: &'a Grid,
    /// Cells across and down.
    columns: usize,
    rows: usize,
}

impl Image<'_> {
    /// Distance of a point from the triangles of the four quads nearest to its place, and the normals (of any length) of
    /// the triangle at the place and of the nearest one.
    fn nearest(&self, place: [f64; 2], p: [f64; 3]) -> (f64, [[f64; 3]; 2]) {
        let own = [self.cell(place[0], self.columns), self.cell(place[1], self.rows)];
        let beside = |c: usize, n: usize| -> usize {
            let (k, f) = (own[c], place[c] - own[c] as f64);
            if f < 0.5 { k.saturating_sub(1) } else { (k + 1).min(n - 1) }
        };
        let other = [beside(0, self.columns), beside(1, self.rows)];
        let mut near = f64::INFINITY;
        let mut facing = [[0.0; 3]; 2];
        for j in [own[1], other[1]] {
            for i in [own[0], other[0]] {
                for (half, [a, b, c]) in self.quad(i, j).into_iter().enumerate() {
                    let (d, normal) = (distance(p, closest_on([a, b, c], p)), cross(sub(b, a), sub(c, a)));
                    if d < near {
                        (near, facing[1]) = (d, normal);
                    }
                    if [i, j] == own && self.holds(place, [i, j], half) {
                        facing[0] = normal;
                    }
                }
            }
        }
        (near, facing)
    }

    /// Distances, in units of `diagonal`, of points spread evenly over the image from the surface around their places.
    fn towards(&self, disk: &Disk, locator: &Locator<'_>, diagonal: f64) -> Vec<f64> {
        let mut sum = 0.0;
        let mut cumulative = Vec::with_capacity(2 * self.columns * self.rows);
        for j in 0..self.rows {
            for i in 0..self.columns {
                for [a, b, c] in self.quad(i, j) {
                    sum += 0.5 * norm(cross(sub(b, a), sub(c, a)));
                    cumulative.push(sum);
                }
            }
        }
        if !sum.is_finite() {
            return vec![f64::INFINITY; POINTS];
        }
        let at = |k: usize| {
            let target = (k as f64 + 0.5) / POINTS as f64 * sum;
            let t = cumulative.partition_point(|&c| c <= target).min(cumulative.len() - 1);
            let (i, j) = (t / 2 % self.columns, t / 2 / self.columns);
            let [a, b, c] = self.quad(i, j)[t % 2];
            let p = scale(add(add(a, b), c), 1.0 / 3.0);
            let place = [i as f64 + 0.5, j as f64 + 0.5];
            let near =
                |&f: &u32| distance(p, closest_on(disk.triangles[f as usize].map(|v| disk.positions[v as usize]), p));
            locator.around(place).iter().map(near).fold(f64::INFINITY, f64::min) / diagonal
        };
        (0..POINTS).into_par_iter().with_min_len(CHUNK).map(at).collect()
    }

    fn cell(&self, x: f64, n: usize) -> usize {
        (x.max(0.0) as usize).min(n - 1)
    }

    /// Whether the diagonal of the quad runs from its first corner.
    fn straight(&self, i: usize, j: usize) -> bool {
        let (a, w) = (j * self.grid.width + i, self.grid.width);
        let at = |k: usize| self.grid.positions[k];
        distance(at(a), at(a + w + 1)) <= distance(at(a + 1), at(a + w))
    }

    /// The two triangles of a quad by its shorter diagonal.
    fn quad(&self, i: usize, j: usize) -> [[[f64; 3]; 3]; 2] {
        let a = j * self.grid.width + i;
        let at = |k: usize| self.grid.positions[k];
        let (a, b, c, d) = (at(a), at(a + 1), at(a + self.grid.width + 1), at(a + self.grid.width));
        if self.straight(i, j) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    }

    /// Whether a place of a quad is in this half of it.
    fn holds(&self, place: [f64; 2], [i, j]: [usize; 2], half: usize) -> bool {
        let (x, y) = (place[0] - i as f64, place[1] - j as f64);
        let first = if self.straight(i, j) { y <= x } else { x + y <= 1.0 };
        first == (half == 0)
    }
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest_on([a, b, c]: [[f64; 3]; 3], p: [f64; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return add(a, scale(ab, d1 / (d1 - d3)));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return add(a, scale(ac, d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 && d4 - d3 + d5 - d6 > 0.0 {
        return add(b, scale(sub(c, b), (d4 - d3) / (d4 - d3 + d5 - d6)));
    }
    let all = va + vb + vc;
    if all > 0.0 { add(a, add(scale(ab, vb / all), scale(ac, vc / all))) } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::stage::measure::{MeasureOptions, measure};
    use proptest::prelude::*;

    fn mapped(s: &Surface, w: u32, h: u32) -> (shapes::Mapped, Grid) {
        let m = shapes::mapped(s, w, h);
        let points = m.samples.iter().map(|x| x.position(&m.disk)).collect();
        let grid = Grid::new(m.w as usize + 1, m.h as usize + 1, points);
        (m, grid)
    }

    #[test]
    fn the_verdict_bounds_the_measured_distance_and_is_near_it() {
        for (name, s) in shapes::all() {
            let (m, grid) = mapped(&s, 24, 20);
            let v = judge(&s, &m.disk, &m.uv, &grid, None);
            let options = MeasureOptions { samples: 20_000, seed: 1 };
            let q = measure(&s.positions, &s.triangles, &grid.positions, &grid.triangulate(), &options).unwrap();
            let true_rms = q.rms_source_to_image / q.diagonal;
            // The true figure is itself a sum over samples.
            assert!(v.rms > 0.9 * true_rms - 1e-9, "{name}: {} {true_rms}", v.rms);
            assert!(v.rms < 3.0 * true_rms + 1e-6, "{name}: {} {true_rms}", v.rms);
            assert!(v.outside < 1e-12, "{name}: texels on the surface lie in its box");
        }
    }

    #[test]
    fn texels_over_what_the_surface_does_not_fill_are_seen_from_the_image() {
        // A frame: its middle, a third of each side, is open.
        let all = shapes::rectangle(24, 24, 1.0, 1.0);
        let s = shapes::without(&all, |t| {
            let p = all.corners(t).iter().fold([0.0; 3], |m, p| [m[0] + p[0] / 3.0, m[1] + p[1] / 3.0, 0.0]);
            p[0].max(p[1]) < 2.0 / 3.0 && p[0].min(p[1]) > 1.0 / 3.0
        });
        let (m, mut grid) = mapped(&s, 40, 40);
        let locator = Locator::new(&m.disk, &m.uv, m.w as usize, m.h as usize);
        let before = judge(&s, &m.disk, &m.uv, &grid, Some(&locator));
        assert!(before.largest < 0.05, "{before:?}");
        // A texel of the inner rim goes to the middle of the opening.
        let near = |p: &[f64; 3]| distance(*p, [0.5, 0.5, 0.0]);
        let k = (0..grid.positions.len())
            .min_by(|&a, &b| near(&grid.positions[a]).total_cmp(&near(&grid.positions[b])))
            .unwrap();
        grid.positions[k] = [0.5, 0.5, 0.0];
        let (there, both) = (judge(&s, &m.disk, &m.uv, &grid, None), judge(&s, &m.disk, &m.uv, &grid, Some(&locator)));
        assert!(both.rms > 2.0 * there.rms.max(before.rms), "{there:?} {both:?}");
    }

    #[test]
    fn a_one_sided_surface_is_not_folded() {
        let (m, grid) = mapped(&shapes::moebius(96, 8), 48, 12);
        let v = judge(&shapes::moebius(96, 8), &m.disk, &m.uv, &grid, None);
        assert!(v.folded < 0.002 && v.normal_degrees < 10.0, "{v:?}");
    }

    #[test]
    fn a_texel_far_out_and_a_fold_are_seen() {
        let s = shapes::rectangle(16, 16, 1.0, 1.0);
        let (m, good) = mapped(&s, 32, 32);
        let clean = judge(&s, &m.disk, &m.uv, &good, None);
        assert!(clean.rms < 1e-9 && clean.folded == 0.0 && clean.outside == 0.0, "{clean:?}");
        let mut far = good.clone();
        far.positions[33 * 16 + 16][2] = 10.0 * 2f64.sqrt();
        assert!((judge(&s, &m.disk, &m.uv, &far, None).outside - 10.0).abs() < 1e-9);
        let mut folded = good;
        folded.positions[33 * 8..33 * 20].iter_mut().for_each(|p| p[1] = 0.6 - p[1]);
        let v = judge(&s, &m.disk, &m.uv, &folded, None);
        assert!(v.folded > 0.2 && v.normal_degrees > 30.0, "{v:?}");
    }

    proptest! {
        #[test]
        fn the_nearest_point_is_nearer_than_any_other(v in proptest::collection::vec(-1.0f64..1.0, 12)) {
            let p = |k: usize| [v[3 * k], v[3 * k + 1], v[3 * k + 2]];
            let t = [p(0), p(1), p(2)];
            let d = distance(closest_on(t, p(3)), p(3));
            for i in 0..=20 { for j in 0..=20 - i {
                let (x, y) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let q = add(add(scale(t[0], 1.0 - x - y), scale(t[1], x)), scale(t[2], y));
                prop_assert!(d <= distance(q, p(3)) + 1e-12);
            }}
        }
    }
}
