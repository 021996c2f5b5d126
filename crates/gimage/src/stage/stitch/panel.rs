//! The connected surfaces of a garment as stitching sees them: their images, their borders, and what is nearest to a point.

use std::collections::BTreeMap;
use std::ops::Range;

use gimage_bundle::{Bundle, MapKind};

use crate::base::closest::Closest;
use crate::base::grid::{Grid, representatives};
use crate::base::vec3::{distance, norm, sub};
use crate::stage::assemble::{Family, Piece};

/// A texel of a bundle: its piece, and its index in that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Texel {
    pub piece: usize,
    pub texel: u32,
}

/// A point of a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// The first of its duplicates.
    pub texel: Texel,
    /// Where it is \[m\].
    pub at: [f64; 3],
}

/// A piece, or all parts of a surface that was split.
pub(super) struct Panel {
    /// Its name in messages.
    pub name: String,
    /// Area of its surface \[m2\].
    pub area: f64,
    /// Whether any particle is pinned, or limited.
    pub pinned: bool,
    /// All its points.
    pub points: Vec<Point>,
    /// The points of its boundary loops, each loop in its order.
    pub loops: Vec<Vec<Point>>,
    /// Mean distance of neighbouring texels \[m\].
    pub spacing: f64,
    /// Low and high corner of the box around its image \[m\].
    pub bounds: [[f64; 3]; 2],
    source: Closest,
    image: Closest,
    triangles: Vec<(usize, [u32; 3])>,
}

/// The panels of a garment, in the order of their pieces. `bundle` has the pins and limits.
pub(super) fn panels(pieces: &[Piece<'_>], families: &[Family<'_>], bundle: &Bundle) -> Vec<Panel> {
    let mut out = Vec::new();
    let mut at = 0;
    while at < pieces.len() {
        let family = families.iter().find(|f| f.first == at && f.count > 0);
        let range = family.map_or(at..at + 1, Family::pieces);
        let name = family.map_or(&pieces[at].component.name, |f| &f.whole.name).clone();
        out.push(panel(pieces, range.clone(), family, name, bundle));
        at = range.end;
    }
    out
}

fn panel(
    pieces: &[Piece<'_>],
    range: Range<usize>,
    family: Option<&Family<'_>>,
    name: String,
    bundle: &Bundle,
) -> Panel {
    let own = &pieces[range.clone()];
    let grids: Vec<&Grid> = own.iter().map(|p| &p.image.grid).collect();
    let none = Vec::new();
    let (firsts, same) = representatives(&grids, family.map_or(&none, |f| &f.rings));
    let locate = |k: u32| {
        let home = firsts.partition_point(|f| *f <= k as usize) - 1;
        Point {
            texel: Texel { piece: range.start + home, texel: k - firsts[home] as u32 },
            at: grids[home].stored(k - firsts[home] as u32),
        }
    };
    let (mut corners, mut triangles, mut welded) = (Vec::new(), Vec::new(), Vec::new());
    for (n, (grid, first)) in grids.iter().zip(&firsts).enumerate() {
        for t in grid.triangulate() {
            corners.push(t.map(|k| grid.stored(k)));
            triangles.push((range.start + n, t));
            welded.push(t.map(|k| same[*first + k as usize]));
        }
    }
    let source: Vec<[[f64; 3]; 3]> =
        own.iter().flat_map(|p| (0..p.surface.triangles.len()).map(|t| p.surface.corners(t))).collect();
    let points = (0..same.len() as u32).filter(|k| same[*k as usize] == *k).map(locate).collect();
    let area: f64 = own.iter().map(|p| p.component.area).sum();
    let texels: usize = grids.iter().map(|g| g.positions.len()).sum();
    let all = grids.iter().flat_map(|g| &g.positions);
    let bounds = all.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[lo, hi], p| {
        [[0, 1, 2].map(|c: usize| lo[c].min(p[c])), [0, 1, 2].map(|c: usize| hi[c].max(p[c]))]
    });
    let pinned = |k: usize| {
        let codes = bundle.image(k, &MapKind::Position);
        let limits = bundle.image(k, &MapKind::Limit);
        let constant = bundle.manifest.pieces.get(k).and_then(|p| p.constants.limit);
        codes.is_some_and(|image| image.data.chunks_exact(4).any(|t| t[3] < 0.0))
            || limits.is_some_and(|image| image.data.iter().any(|x| *x >= 0.0))
            || constant.is_some_and(|x| x >= 0.0)
    };
    Panel {
        name,
        area,
        pinned: range.clone().any(pinned),
        points,
        loops: loops(&welded).into_iter().map(|l| l.into_iter().map(locate).collect()).collect(),
        spacing: (area / texels.max(1) as f64).sqrt(),
        bounds,
        source: Closest::of(&source),
        image: Closest::of(&corners),
        triangles,
    }
}

/// The boundary loops of a surface: the sides that one triangle has, each from its end to the next. Longest first.
fn loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut sides: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for t in triangles.iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *sides.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ((a, b), count) in sides.into_iter().filter(|(_, count)| *count != 0) {
        let (from, to) = if count > 0 { (a, b) } else { (b, a) };
        onward.entry(from).or_default().push(to);
    }
    let mut out = Vec::new();
    while let Some((&start, _)) = onward.first_key_value() {
        let (mut ring, mut k) = (Vec::new(), start);
        while let Some(mut ends) = onward.remove(&k) {
            let next = ends.remove(0);
            if !ends.is_empty() {
                onward.insert(k, ends);
            }
            ring.push(k);
            k = next;
            if k == start {
                break;
            }
        }
        out.push(ring);
    }
    out.sort_by_key(|ring: &Vec<u32>| (std::cmp::Reverse(ring.len()), ring[0]));
    out
}

/// Where a point of one panel meets the image of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Landing {
    /// The piece.
    pub piece: usize,
    /// Column and row there, with fractions.
    pub cell: [f64; 2],
}

impl Panel {
    /// Distance \[m\] from a point to the surface that the panel was made from, if it is at most `most` \[m\].
    pub fn within(&self, p: [f64; 3], most: f64) -> Option<f64> {
        let [lo, hi] = self.bounds;
        let beyond = [0, 1, 2].map(|c: usize| (lo[c] - p[c]).max(p[c] - hi[c]).max(0.0));
        // The surface may stick out of its image a little.
        if norm(beyond) > 2.0 * most + self.spacing {
            return None;
        }
        self.source.project(p).map(|near| near.distance).filter(|d| *d <= most)
    }

    /// Distance \[m\] from a point to the surface, however far it is.
    pub fn distance(&self, p: [f64; 3]) -> Option<f64> {
        self.source.project(p).map(|near| near.distance)
    }

    /// The nearest point of its image; `width_of` is the width of a piece.
    pub fn landing(&self, p: [f64; 3], width_of: impl Fn(usize) -> u32) -> Option<Landing> {
        let near = self.image.project(p)?;
        let (piece, texels) = self.triangles[near.triangle as usize];
        let width = width_of(piece);
        let sum = |of: &dyn Fn(u32) -> u32| {
            texels.iter().zip(near.barycentric).map(|(k, share)| share * f64::from(of(*k))).sum::<f64>()
        };
        Some(Landing { piece, cell: [sum(&|k| k % width), sum(&|k| k / width)] })
    }

    /// Diagonal of its box \[m\].
    pub fn diagonal(&self) -> f64 {
        distance(self.bounds[0], self.bounds[1])
    }
}

/// Length \[m\] of a loop around point `k` that this point stands for.
pub(super) fn share(points: &[Point], k: usize) -> f64 {
    let n = points.len();
    let to = |other: usize| norm(sub(points[other].at, points[k].at));
    0.5 * (to((k + 1) % n) + to((k + n - 1) % n))
}
