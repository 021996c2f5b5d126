//! Rest lengths of the springs between texels: C. Zeller, "Cloth Simulation on the GPU", SIGGRAPH 2005.
//!
//! Each texel stores four springs, to the right, down, down-right and up-right. Two differences from the sketch: a rest
//! length may follow the surface instead of the chord, and the two copies of a spring along a seam are bit-equal.

pub use gimage_bundle::other_end;

use crate::base::grid::Grid;
use crate::base::vec3::distance;
use rayon::prelude::*;
use std::collections::HashMap;

/// Index of the spring (i, j)-(i+1, j).
pub const RIGHT: usize = 0;
/// Index of the spring (i, j)-(i, j+1).
pub const DOWN: usize = 1;
/// Index of the spring (i, j)-(i+1, j+1).
pub const DOWN_RIGHT: usize = 2;
/// Index of the spring (i, j)-(i+1, j-1).
pub const UP_RIGHT: usize = 3;

/// The surface under an image.
pub trait SurfaceMap: Sync {
    /// The point at (u, v), where texel (i, j) lies at u = i, v = j \[m\].
    fn point(&self, u: f64, v: f64) -> [f64; 3];
}

impl<F: Fn(f64, f64) -> [f64; 3] + Sync> SurfaceMap for F {
    fn point(&self, u: f64, v: f64) -> [f64; 3] {
        self(u, v)
    }
}

/// How rest lengths are measured.
#[derive(Clone, Copy)]
pub enum Rest<'a> {
    /// The distance of the stored texels.
    Chord,
    /// The length along the surface of the straight line between the texels' parameters; the chord where that is not
    /// finite.
    Arc(&'a dyn SurfaceMap),
}

/// Rest lengths of the springs at each texel \[m\], in the order of [`RIGHT`] to [`UP_RIGHT`]; 0 = no spring.
#[derive(Clone, Debug, PartialEq)]
pub enum RestLengths {
    /// The same at every texel, for the springs that do not leave the grid.
    Constant([f32; 4]),
    /// One entry a texel.
    Image(Vec<[f32; 4]>),
}

impl RestLengths {
    /// The entry of texel `k`; 0 outside of the image.
    pub fn at(&self, k: usize) -> [f32; 4] {
        match self {
            Self::Constant(c) => *c,
            Self::Image(image) => image.get(k).copied().unwrap_or_default(),
        }
    }

    /// How many springs of each kind a grid of this size has; a spring along a seam counts on each side.
    pub fn counts(&self, width: usize, height: usize) -> [usize; 4] {
        let mut counts = [0; 4];
        for k in 0..width.saturating_mul(height) {
            let r = self.at(k);
            for kind in 0..4 {
                counts[kind] += (other_end(width, height, k, kind).is_some() && r[kind] > 0.0) as usize;
            }
        }
        counts
    }
}

/// The springs of an image. Two ends that are one surface point, or are stored as one, have none between them.
pub fn springs(grid: &Grid, rest: Rest) -> RestLengths {
    if !grid.is_sized() {
        return RestLengths::Constant([0.0; 4]);
    }
    let (w, h) = (grid.width, grid.height);
    let representative = grid.representative();
    let mut lengths: Vec<[f64; 4]> = (0..w * h)
        .into_par_iter()
        .map(|k| {
            [0, 1, 2, 3].map(|kind| {
                let Some(end) = other_end(w, h, k, kind) else { return 0.0 };
                let (a, b) = (representative[k], representative[end]);
                // Equal on mates, though one may run the other way: a difference and its negative have one square.
                let chord = distance(grid.stored(a), grid.stored(b));
                match rest {
                    _ if a == b || !chord.is_finite() => 0.0,
                    Rest::Chord => chord,
                    Rest::Arc(map) => {
                        let at = |k: usize| [(k % w) as f64, (k / w) as f64];
                        // Texels are rounded to f32, and fitted ones lie off the surface: no arc is shorter than its chord.
                        arc_length(map, at(k), at(end)).unwrap_or(chord).max(chord)
                    }
                }
            })
        })
        .collect();
    if let Rest::Arc(_) = rest {
        share_along_seams(grid, &representative, &mut lengths);
    }
    constant(grid, &lengths).map_or_else(
        || RestLengths::Image(lengths.iter().map(|l| l.map(|x| x as f32)).collect()),
        RestLengths::Constant,
    )
}

/// Coarsest and finest number of pieces of a line.
const PIECES: (u32, u32) = (2, 64);

/// The length of the image of a line, by halving its pieces until a step adds less than 1e-4.
fn arc_length(map: &dyn SurfaceMap, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
    let length = |n: u32| -> f64 {
        let at = |k: u32| {
            let t = f64::from(k) / f64::from(n);
            map.point(from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]))
        };
        let mut last = at(0);
        (1..=n)
            .map(|k| {
                let p = at(k);
                distance(std::mem::replace(&mut last, p), p)
            })
            .sum()
    };
    let (mut n, mut best) = (PIECES.0, length(PIECES.0));
    while n < PIECES.1 {
        n *= 2;
        let finer = length(n);
        let done = (finer - best).abs() <= 1e-4 * finer;
        best = finer;
        if done {
            break;
        }
    }
    (best.is_finite() && best > 0.0).then_some(best)
}

/// Gives both copies of a spring along a seam the length computed on the first: the two lines have one image, but are
/// rounded differently.
fn share_along_seams(grid: &Grid, representative: &[u32], lengths: &mut [[f64; 4]]) {
    let (w, h) = (grid.width, grid.height);
    let mut first: HashMap<(u32, u32), f64> = HashMap::new();
    for k in 0..w * h {
        for kind in [RIGHT, DOWN] {
            let Some(end) = other_end(w, h, k, kind) else { continue };
            let across = if kind == RIGHT { k / w } else { k % w };
            let last = if kind == RIGHT { h } else { w } - 1;
            if across == 0 || across == last {
                // At the end of a cut only one of the two ends has duplicates.
                let (a, b) = (representative[k], representative[end]);
                let length = lengths[k][kind];
                lengths[k][kind] = *first.entry((a.min(b), a.max(b))).or_insert(length);
            }
        }
    }
}

/// One length for each kind, if no spring is missing and all are as equal as rounding the positions to f32 lets them be.
fn constant(grid: &Grid, lengths: &[[f64; 4]]) -> Option<[f32; 4]> {
    let (w, h) = (grid.width, grid.height);
    let largest = grid.positions.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let rounding = 2.0 * f64::from(f32::EPSILON) * largest;
    let mut out = [0.0; 4];
    for kind in 0..4 {
        let of_kind = || (0..w * h).filter(move |&k| other_end(w, h, k, kind).is_some()).map(move |k| lengths[k][kind]);
        let count = of_kind().count();
        if count == 0 {
            continue;
        }
        let mean = of_kind().sum::<f64>() / count as f64;
        // Far from the origin rounding would hide true differences: there the image is stored.
        let tolerance = 1e-6 * mean + rounding.min(1e-3 * mean);
        if mean <= 0.0 || of_kind().any(|l| (l - mean).abs() > tolerance) {
            return None;
        }
        out[kind] = mean as f32;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::samples::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_flat_rectangle_is_constant() {
        for (w, h, ex, ey) in [(5, 4, 1.0, 2.0), (257, 129, 1.3, 0.7), (2, 2, 0.1, 0.1), (1024, 64, 1.7, 0.4)] {
            let (dx, dy) = (ex / (w - 1) as f64, ey / (h - 1) as f64);
            let g = grid(w, h, |u, v| [ex * u - 0.3, 1.0, ey * v]);
            let r = springs(&g, Rest::Chord);
            let RestLengths::Constant(c) = r else { panic!("{w} x {h} is not constant") };
            for (x, y) in c.iter().zip([dx, dy, dx.hypot(dy), dx.hypot(dy)]) {
                assert!((f64::from(*x) - y).abs() < 3e-7 * y, "{w} x {h}: {x} {y}");
            }
            let shear = (w - 1) * (h - 1);
            assert_eq!(r.counts(w, h), [(w - 1) * h, w * (h - 1), shear, shear]);
        }
    }

    #[test]
    fn a_rectangle_with_one_texel_moved_is_not() {
        let mut g = grid(9, 9, |u, v| [u, v, 0.0]);
        g.positions[40][2] = 0.01;
        assert!(matches!(springs(&g, Rest::Chord), RestLengths::Image(_)));
    }

    #[test]
    fn an_arc_follows_the_surface() {
        let (w, h) = (5, 3);
        let g = cylinder(w, h, 1.0, 2.0);
        let map = |u: f64, v: f64| [(TAU * u / 4.0).cos(), v, (TAU * u / 4.0).sin()];
        let (RestLengths::Constant(chord), RestLengths::Constant(arc)) =
            (springs(&g, Rest::Chord), springs(&g, Rest::Arc(&map)))
        else {
            panic!("a cylinder is constant")
        };
        assert!((f64::from(chord[RIGHT]) - 2f64.sqrt()).abs() < 1e-6);
        assert!((f64::from(arc[RIGHT]) - PI / 2.0).abs() < 2e-4 && (arc[DOWN] - 1.0).abs() < 1e-6);
        assert!((f64::from(arc[UP_RIGHT]) - (PI / 2.0).hypot(1.0)).abs() < 2e-4);
    }

    #[test]
    fn mates_along_a_seam_are_bit_equal_and_folds_have_no_spring() {
        let (w, h) = (9, 11);
        let g = sphere(w, h);
        // A bump that differs on the two sides of the seam stands for rounding.
        let map = |u: f64, v: f64| [u * 0.1, v * 0.1 + 1e-3 * (7.0 * u + v).sin(), 0.0];
        let RestLengths::Image(r) = springs(&g, Rest::Arc(&map)) else { panic!("not constant") };
        for i in 0..w - 1 {
            assert_eq!(r[i][RIGHT].to_bits(), r[(h - 1) * w + i][RIGHT].to_bits());
        }
        for j in 0..h / 2 {
            assert_eq!(r[j * w][DOWN].to_bits(), r[(h - 2 - j) * w][DOWN].to_bits());
        }
        let RestLengths::Image(chords) = springs(&g, Rest::Chord) else { panic!("not constant") };
        for i in 0..w - 1 {
            assert_eq!(chords[i][RIGHT].to_bits(), chords[(h - 1) * w + i][RIGHT].to_bits());
        }
        // Two neighbours in one ring: the ends of a fold one texel wide.
        let mut g = grid(4, 3, |u, v| [u, v, 0.0]);
        link(&mut g, [vec![0, 2]]);
        let r = springs(&g, Rest::Chord);
        assert_eq!(r.at(0)[RIGHT].to_bits(), r.at(1)[RIGHT].to_bits());
        link(&mut g, [vec![4, 9]]);
        assert_eq!(springs(&g, Rest::Chord).at(4)[DOWN_RIGHT], 0.0);
    }

    #[test]
    fn bad_grids_and_maps_are_survived() {
        assert_eq!(springs(&Grid::default(), Rest::Chord), RestLengths::Constant([0.0; 4]));
        let g = grid(3, 3, |u, v| [u, v, 0.0]);
        let nan = |_: f64, _: f64| [f64::NAN; 3];
        assert_eq!(springs(&g, Rest::Arc(&nan)), springs(&g, Rest::Chord));
        let g = grid(3, 3, |u, v| [u * 1e300, v, f64::NAN]);
        assert!(springs(&g, Rest::Chord).at(0).iter().all(|x| x.is_finite()));
        assert_eq!(springs(&Grid::new(1, 3, vec![[0.0; 3]; 3]), Rest::Chord).counts(1, 3), [0; 4]);
    }
}
