//! Measures how close an image is to its source mesh: distances in both directions, normals and folds.
//!
//! Samples are spread evenly over both surfaces; maxima also take every vertex. Where triangles overlap so much that a
//! query is expensive (a crumpled sheet, a soup), fewer samples are taken, and fewer vertices: the work has a limit, which
//! [`Quality::samples`] and [`Quality::vertices`] tell. Sums run in the order of the samples, and work is counted in boxes
//! and triangles looked at, so the numbers depend neither on the number of threads nor on the machine.

pub(crate) mod facing;
pub mod stretch;

use crate::base::closest::Closest;
use crate::base::frame::{Frame, usable_corners, used_positions};
use crate::base::scatter::Sampler;
use crate::base::vec3::{cross, distance, dot, normalize, sub};
use rayon::prelude::*;
use serde::Serialize;

/// Options of [`measure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MeasureOptions {
    /// Samples on each surface, 1 or more, default 100,000. Larger: surer numbers, more time. Fewer are taken where a
    /// query looks at more than [`VISITS`] boxes and triangles in the mean.
    pub samples: usize,
    /// Which samples, default 1. No direction is better.
    pub seed: u64,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self { samples: 100_000, seed: 1 }
    }
}

/// Boxes and triangles that a query may look at in the mean; some 50 on a clean garment. Beyond, fewer samples are taken,
/// so that all together look at no more.
pub const VISITS: f64 = 500.0;

/// Samples that tell what a query costs.
const PILOT: usize = 256;

/// Samples that are taken whatever they cost.
const LEAST_SAMPLES: usize = 500;

/// The result of [`measure`]. "Relative" is in units of the source's bounding-box diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// Bounding-box diagonal of the source \[m\].
    pub diagonal: f64,
    /// Root mean square distance from the source to the image's surface \[m\].
    pub rms_source_to_image: f64,
    /// Root mean square distance from the image's surface to the source \[m\].
    pub rms_image_to_source: f64,
    /// 20 log10 (diagonal / larger RMS) \[dB\]; infinite (null in JSON) when both are 0.
    pub psnr: f64,
    /// Largest distance from the source to the image's surface \[m\].
    pub hausdorff_source_to_image: f64,
    /// Largest distance from the image's surface to the source \[m\].
    pub hausdorff_image_to_source: f64,
    /// The larger of the two \[m\].
    pub hausdorff: f64,
    /// The larger of the two, relative.
    pub hausdorff_relative: f64,
    /// Mean angle between the source's normal and that of the nearest triangle of the image \[degrees\], 0..=180; 0..=90
    /// where the source is one-sided, as normals then have no sign.
    pub normal_error_mean: f64,
    /// Share of the image's surface that faces against the source's nearest triangle; 0 where the source is one-sided.
    pub fold_area: f64,
    /// Area of the image's surface / area of the source.
    pub area_ratio: f64,
    /// Samples on each surface: as many as asked for, or fewer where queries are expensive.
    pub samples: usize,
    /// Share of the vertices of both surfaces that the largest distances were taken at, 0..=1: 1 unless queries are
    /// expensive.
    pub vertices: f64,
}

/// Compares two surfaces; `None` if either has no usable triangle or the source no extent.
///
/// Cost: O(n log n) to prepare n triangles, then at most [`VISITS`] boxes and triangles per sample asked for and side, and
/// as many for the vertices.
pub fn measure(
    source_positions: &[[f64; 3]],
    source_triangles: &[[u32; 3]],
    image_positions: &[[f64; 3]],
    image_triangles: &[[u32; 3]],
    options: &MeasureOptions,
) -> Option<Quality> {
    let frame = Frame::around(used_positions(source_positions, source_triangles));
    let source = Side::new(&frame, source_positions, source_triangles)?;
    let image = Side::new(&frame, image_positions, image_triangles)?;
    let (lo, hi) = source.bounds();
    let diagonal = distance(lo, hi);
    if diagonal == 0.0 {
        return None;
    }
    let asked = options.samples.max(1);
    let cost = source.cost(&image, asked, options.seed).max(image.cost(&source, asked, options.seed.wrapping_add(1)));
    let n = affordable(asked, cost, asked);
    let most = |side: &Side| affordable(side.vertices.len(), cost, asked);
    let to_image = source.towards(&image, n, options.seed, most(&source));
    let to_source = image.towards(&source, n, options.seed.wrapping_add(1), most(&image));
    // The image may wind either way; what counts is where it faces against itself.
    let sign = if to_source.cosines.iter().sum::<f64>() >= 0.0 { 1.0 } else { -1.0 };
    let one_sided = winds_against_itself(source_triangles);
    let facing = |c: &f64| if one_sided { c.abs() } else { sign * c };
    let degrees = |c: &f64| facing(c).clamp(-1.0, 1.0).acos().to_degrees();
    let rms = to_image.rms.max(to_source.rms);
    let largest = to_image.largest.max(to_source.largest);
    let source_area = Sampler::new(&source.corners, n, 0).area();
    let image_area = Sampler::new(&image.corners, n, 0).area();
    Some(Quality {
        diagonal: diagonal * frame.size,
        rms_source_to_image: to_image.rms * frame.size,
        rms_image_to_source: to_source.rms * frame.size,
        psnr: if rms > 0.0 { 20.0 * (diagonal / rms).log10() } else { f64::INFINITY },
        hausdorff_source_to_image: to_image.largest * frame.size,
        hausdorff_image_to_source: to_source.largest * frame.size,
        hausdorff: largest * frame.size,
        hausdorff_relative: largest / diagonal,
        normal_error_mean: to_image.cosines.iter().map(degrees).sum::<f64>() / n as f64,
        fold_area: to_source.cosines.iter().filter(|c| facing(c) < 0.0).count() as f64 / n as f64,
        area_ratio: if source_area > 0.0 { image_area / source_area } else { 0.0 },
        samples: n,
        vertices: (to_image.vertices + to_source.vertices) as f64
            / (source.vertices.len() + image.vertices.len()) as f64,
    })
}

/// How many of `wanted` queries fit into the work that `asked` samples may make, at `cost` each.
fn affordable(wanted: usize, cost: f64, asked: usize) -> usize {
    let most = (VISITS * asked as f64 / cost.max(1.0)) as usize;
    wanted.min(most.max(LEAST_SAMPLES))
}

/// Whether two triangles run along an edge the same way, as they must somewhere on a one-sided surface.
fn winds_against_itself(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    edges.windows(2).any(|e| e[0] == e[1])
}

/// One of the two surfaces.
struct Side {
    corners: Vec<[[f64; 3]; 3]>,
    /// Unit, or zero where a triangle has no area.
    normals: Vec<[f64; 3]>,
    /// The corners, each place once.
    vertices: Vec<[f64; 3]>,
    closest: Closest,
}

/// Distances from one side to the other.
struct Towards {
    rms: f64,
    largest: f64,
    /// Of the angle between the two normals, a sample each; 0 where one of them has none.
    cosines: Vec<f64>,
    /// Vertices that were asked.
    vertices: usize,
}

impl Side {
    fn new(frame: &Frame, positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<Self> {
        let (corners, ids) = usable_corners(frame, positions, triangles);
        if corners.is_empty() {
            return None;
        }
        let normals = corners.iter().map(|&[a, b, c]| unit_normal(a, b, c)).collect();
        // The tree numbers its triangles as `corners` does.
        let closest = Closest::of(&corners);
        let mut is_used = vec![false; positions.len()];
        ids.iter().flat_map(|&t| triangles[t as usize]).for_each(|v| is_used[v as usize] = true);
        let used = positions.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let mut vertices: Vec<[f64; 3]> = used.map(|(&p, _)| frame.inward(p)).collect();
        vertices.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        vertices.dedup();
        Some(Self { corners, normals, vertices, closest })
    }

    /// Mean cost of a query of a sample, in boxes and triangles of the other side.
    fn cost(&self, other: &Side, n: usize, seed: u64) -> f64 {
        let (sampler, pilot) = (Sampler::new(&self.corners, n, seed), PILOT.min(n.div_ceil(64)));
        let visits: Vec<u32> =
            (0..pilot).into_par_iter().map(|k| other.closest.counted(sampler.at(k * n / pilot).0).1).collect();
        visits.iter().map(|&v| f64::from(v)).sum::<f64>() / pilot as f64
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let all = || self.corners.iter().flatten();
        let side = |f: fn(f64, f64) -> f64, from: f64| [0, 1, 2].map(|k| all().map(|p| p[k]).fold(from, f));
        (side(f64::min, f64::INFINITY), side(f64::max, f64::NEG_INFINITY))
    }

    /// From `n` samples and, for the largest, `most` of the vertices.
    fn towards(&self, other: &Side, n: usize, seed: u64, most: usize) -> Towards {
        let sampler = Sampler::new(&self.corners, n, seed);
        let hits: Vec<(f64, f64)> = (0..n)
            .into_par_iter()
            .map(|i| {
                let (p, t) = sampler.at(i);
                let hit = other.closest.project(p);
                hit.map_or((0.0, 0.0), |h| (h.distance, dot(self.normals[t], other.normals[h.triangle as usize])))
            })
            .collect();
        let all = self.vertices.len();
        let chosen: Vec<[f64; 3]> = (0..most).map(|k| self.vertices[k * all / most]).collect();
        let at_vertices = other.closest.project_all(&chosen);
        let largest = hits.iter().map(|h| h.0).chain(at_vertices.iter().flatten().map(|h| h.distance));
        Towards {
            rms: (hits.iter().map(|h| h.0 * h.0).sum::<f64>() / n as f64).sqrt(),
            largest: largest.fold(0.0, f64::max),
            cosines: hits.iter().map(|h| h.1).collect(),
            vertices: most,
        }
    }
}

/// The unit normal, accurate for small triangles too: sides are scaled before they are multiplied.
fn unit_normal(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    normalize(cross(normalize(sub(b, a)), normalize(sub(c, a))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::samples::grid;

    fn square(w: usize, z: impl Fn(f64, f64) -> f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        grid(w, w, |u, v| [u, v, z(u, v)]).welded()
    }

    #[test]
    fn a_shifted_square_is_as_far_as_it_was_shifted() {
        let (p, t) = square(5, |_, _| 0.0);
        let (q, s) = square(9, |_, _| 0.01);
        let m = measure(&p, &t, &q, &s, &MeasureOptions { samples: 2000, seed: 3 }).unwrap();
        let shift = f64::from(0.01f32);
        let psnr = 20.0 * (2f64.sqrt() / shift).log10();
        assert!((m.psnr - psnr).abs() < 1e-6, "{} {psnr}", m.psnr);
        for d in [m.rms_source_to_image, m.rms_image_to_source, m.hausdorff, m.hausdorff_source_to_image] {
            assert!((d - shift).abs() < 1e-12);
        }
        assert!(m.normal_error_mean < 1e-5 && m.fold_area == 0.0 && (m.area_ratio - 1.0).abs() < 1e-12);
    }

    /// The plane z = s x over the unit square against z = 0: a point of the first above x is s x away from the second, a
    /// point of the second at x is s x cos(angle) away from the first.
    #[test]
    fn a_tilted_square_has_the_rms_of_a_ramp() {
        let slope = 0.2;
        let (p, t) = square(9, |_, _| 0.0);
        let (q, s) = square(9, |u, _| slope * u);
        let m = measure(&p, &t, &q, &s, &MeasureOptions::default()).unwrap();
        assert!((m.rms_image_to_source - slope / 3f64.sqrt()).abs() < 2e-4);
        let back = slope / (1.0 + slope * slope).sqrt() / 3f64.sqrt();
        assert!((m.rms_source_to_image - back).abs() < 2e-4);
        assert!((m.psnr - 20.0 * (2f64.sqrt() / (slope / 3f64.sqrt())).log10()).abs() < 0.02);
        assert!((m.hausdorff - slope).abs() < 1e-7);
        assert!((m.normal_error_mean - slope.atan().to_degrees()).abs() < 1e-4);
    }

    #[test]
    fn the_same_surface_is_perfect_and_winding_does_not_matter() {
        let (p, t) = square(6, |u, v| 0.1 * (5.0 * u).sin() * v);
        let turned: Vec<_> = t.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let m = measure(&p, &t, &p, &turned, &MeasureOptions { samples: 500, seed: 1 }).unwrap();
        assert!(m.psnr > 250.0 && m.fold_area < 0.01 && m.normal_error_mean < 1.0, "{m:?}");
    }

    #[test]
    fn a_tenth_of_the_surface_turned_over_is_a_fold() {
        let (p, mut t) = square(11, |_, _| 0.0);
        for t in t.iter_mut().take(20) {
            t.swap(0, 1);
        }
        let (q, s) = square(11, |_, _| 0.0);
        let m = measure(&q, &s, &p, &t, &MeasureOptions { samples: 10_000, seed: 1 }).unwrap();
        assert!((m.fold_area - 0.1).abs() < 1e-3, "{}", m.fold_area);
    }

    #[test]
    fn a_one_sided_surface_is_not_folded() {
        for s in [crate::base::shapes::moebius(40, 6), crate::base::shapes::klein(32, 16)] {
            let o = MeasureOptions { samples: 2000, seed: 1 };
            let m = measure(&s.positions, &s.triangles, &s.positions, &s.triangles, &o).unwrap();
            assert!(m.fold_area == 0.0 && m.normal_error_mean < 2.0, "{m:?}");
        }
    }

    #[test]
    fn the_numbers_do_not_depend_on_threads_or_place() {
        let (p, t) = square(8, |u, v| u * v);
        let (q, s) = square(5, |u, v| u * v);
        let o = MeasureOptions { samples: 3000, seed: 5 };
        let run = |n: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| measure(&p, &t, &q, &s, &o)).unwrap()
        };
        assert_eq!(run(1), run(5));
        let moved = |v: &[[f64; 3]]| v.iter().map(|p| p.map(|x| 1e-9 * (x + 64.0))).collect::<Vec<_>>();
        let m = measure(&moved(&p), &t, &moved(&q), &s, &o).unwrap();
        assert!((m.psnr - run(1).psnr).abs() < 1e-9);
    }

    /// A grid whose vertices lie anywhere in a cube: every triangle's box overlaps a tenth of all others.
    fn crumpled(n: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let mut draw = crate::base::shapes::random(11);
        let (_, t) = square(n, |_, _| 0.0);
        ((0..n * n).map(|_| [0, 1, 2].map(|_| draw(1 << 20) as f64 / f64::from(1 << 20))).collect(), t)
    }

    #[test]
    fn a_crumpled_sheet_is_measured_with_bounded_work() {
        let (p, t) = crumpled(120);
        let (q, s) = (p.iter().map(|p| p.map(|x| x + 1e-3)).collect::<Vec<_>>(), t.clone());
        let o = MeasureOptions { samples: 4000, seed: 1 };
        let m = measure(&p, &t, &q, &s, &o).unwrap();
        assert!(m.samples < o.samples && m.samples >= LEAST_SAMPLES, "{m:?}");
        assert!(m.vertices < 1.0 && m.vertices > 0.0, "{m:?}");
        // The figures stay: no point is farther than the sheet was moved.
        let moved = 1e-3 * 3f64.sqrt();
        assert!(m.hausdorff <= moved * (1.0 + 1e-9) && m.rms_source_to_image > 0.02 * moved, "{m:?}");
        // A clean sheet is measured in full.
        let (p, t) = square(30, |u, v| 0.1 * (6.0 * u).sin() * v);
        let m = measure(&p, &t, &p, &t, &o).unwrap();
        assert_eq!((m.samples, m.vertices), (o.samples, 1.0));
    }

    #[test]
    fn degenerate_input_gives_no_nan() {
        let (p, mut t) = square(4, |_, _| 0.0);
        t.push([0, 0, 1]);
        t.push([0, 1, 2]);
        t.push([0, 1, 99]);
        let m = measure(&p, &t, &p, &t, &MeasureOptions { samples: 100, seed: 1 }).unwrap();
        assert!(m.normal_error_mean.is_finite() && m.rms_source_to_image < 1e-12);
        assert!(measure(&p, &[], &p, &t, &MeasureOptions::default()).is_none());
        assert!(measure(&p, &[[0, 0, 0]], &p, &t, &MeasureOptions::default()).is_none());
        assert!(measure(&[[f64::NAN; 3]; 3], &[[0, 1, 2]], &p, &t, &MeasureOptions::default()).is_none());
    }
}
