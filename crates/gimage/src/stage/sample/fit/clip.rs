//! The mesh clipped against the triangles of texels: what falls on which, and how much of it.

use super::facet::{Affine, Facet};
use super::patch::{Fragment, Patch};
use crate::base::vec3::sub;
use crate::stage::cut::disk::Disk;
use crate::stage::parameterize::distortion::{planar, signed_area2};

/// Cuts a convex polygon by `n . x <= d`.
pub(crate) fn clip(polygon: &[[f64; 2]], n: [f64; 2], d: f64, out: &mut Vec<[f64; 2]>) {
    out.clear();
    along(polygon, n, d, |p, below, _| out.extend(below.then_some(p)));
}

/// Both parts of a convex polygon, with `n . x <= d` and with `n . x >= d`.
fn halves(polygon: &[[f64; 2]], n: [f64; 2], d: f64, [below, above]: &mut [Vec<[f64; 2]>; 2]) {
    below.clear();
    above.clear();
    along(polygon, n, d, |p, is_below, is_above| {
        below.extend(is_below.then_some(p));
        above.extend(is_above.then_some(p));
    });
}

/// Every corner of a polygon and where it crosses a line, in order, and whether that belongs to what is below the line, and
/// to what is above.
#[inline(always)]
fn along(polygon: &[[f64; 2]], n: [f64; 2], d: f64, mut each: impl FnMut([f64; 2], bool, bool)) {
    let Some(&first) = polygon.first() else { return };
    let side = |p: [f64; 2]| n[0] * p[0] + n[1] * p[1] - d;
    let (mut p, mut sp) = (first, side(first));
    for &q in polygon[1..].iter().chain([&first]) {
        let sq = side(q);
        each(p, sp <= 0.0, sp >= 0.0);
        if (sp < 0.0 && sq > 0.0) || (sp > 0.0 && sq < 0.0) {
            let t = sp / (sp - sq);
            each([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])], true, true);
        }
        (p, sp) = (q, sq);
    }
}

/// Cell rows of a slice, whose triangles are clipped one after another.
pub(super) const SLICE: usize = 4;

/// Slices of a band. Bands are summed apart and in order, so that nothing depends on the threads.
pub(super) const SLICES: usize = 4;

/// The triangles whose image meets each slice of cell rows, in order.
pub(super) fn slices(disk: &Disk, uv: &[[f64; 2]], cell_rows: usize) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); cell_rows.div_ceil(SLICE)];
    for (f, &t) in disk.triangles.iter().enumerate() {
        let v = planar(uv, t).map(|p| p[1]);
        let lo = v.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as usize;
        let hi = v.into_iter().fold(f64::NEG_INFINITY, f64::max).max(0.0) as usize;
        let last = out.len() - 1;
        for slice in &mut out[(lo / SLICE).min(last)..=(hi / SLICE).min(last)] {
            slice.push(f as u32);
        }
    }
    out
}

/// The patches of some cell rows, with their fragments in the order of the patches and the facets that these lie on.
#[derive(Default)]
pub(super) struct Patches {
    pub patches: Vec<Patch>,
    pub fragments: Vec<Fragment>,
    pub facets: Vec<Facet>,
}

impl Patches {
    /// Each patch with its fragments, and the facets of all.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&Patch, (&[Fragment], &[Facet]))> {
        let mut from = 0;
        self.patches.iter().map(move |p| {
            let fragments = self.fragments.get(from..p.end as usize).unwrap_or_default();
            from = p.end as usize;
            (p, (fragments, &self.facets[..]))
        })
    }
}

/// The image as the clipping sees it.
#[derive(Clone, Copy)]
pub(super) struct Cells<'a> {
    /// Texels a row.
    pub columns: usize,
    /// Texel positions, which tell the shorter diagonal of every quad.
    pub points: &'a [[f64; 3]],
    /// Cells down.
    pub rows: usize,
}

impl Cells<'_> {
    /// Whether a quad is split from its first corner to the opposite one.
    fn falls(&self, at: usize) -> bool {
        let apart = |a: usize, b: usize| crate::base::vec3::distance(self.points[a], self.points[b]);
        apart(at, at + self.columns + 1) <= apart(at + 1, at + self.columns)
    }
}

/// A disk and its map, each triangle an affine map of the plane.
#[derive(Clone, Copy)]
pub(super) struct MappedDisk<'a> {
    pub disk: &'a Disk,
    pub uv: &'a [[f64; 2]],
    /// Where positions are counted from.
    pub centre: [f64; 3],
    /// Side of a mean texel \[m\].
    pub texel: f64,
}

impl MappedDisk<'_> {
    fn place(&self, f: usize) -> [[f64; 2]; 3] {
        planar(self.uv, self.disk.triangles[f])
    }

    /// A triangle as a facet, if it has an area.
    pub(super) fn facet(&self, f: usize) -> Option<Affine> {
        let corners = self.disk.triangles[f].map(|v| sub(self.disk.positions[v as usize], self.centre));
        Affine::new(corners, self.place(f), self.texel)
    }
}

/// Clips `triangles` against the texel triangles of a slice.
pub(super) fn clipped(disk: MappedDisk<'_>, triangles: &[u32], cells: Cells<'_>, slice: usize) -> Patches {
    let rows = slice * SLICE..((slice + 1) * SLICE).min(cells.rows);
    let across = cells.columns - 1;
    let mut patches: Vec<Patch> = Vec::with_capacity(2 * rows.len() * across);
    for j in rows.clone() {
        for i in 0..across {
            let at = j * cells.columns + i;
            let half = if cells.falls(at) { 0 } else { 2 };
            patches.extend([half, half + 1].map(|half| Patch::new(at as u32, half)));
        }
    }
    // About two fall on a texel triangle where the mesh is as fine as the texels, one where it is coarser.
    let mut made: Vec<(u32, Fragment)> = Vec::with_capacity(2 * patches.len() + triangles.len());
    let mut facets = Vec::new();
    let (mut row, mut cell, mut next, mut parts) = (Vec::new(), Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for &f in triangles {
        let p = disk.place(f as usize);
        let (j0, j1) = span(&p, 1);
        let met = j0.max(rows.start)..j1.min(rows.end);
        let Some(affine) = (!met.is_empty()).then(|| disk.facet(f as usize)).flatten() else { continue };
        for j in met {
            let v = j as f64;
            clip(&p, [0.0, -1.0], -v, &mut next);
            clip(&next, [0.0, 1.0], v + 1.0, &mut row);
            let (i0, i1) = span(&row, 0);
            for i in i0..i1.min(across) {
                let u = i as f64;
                clip(&row, [-1.0, 0.0], -u, &mut next);
                clip(&next, [1.0, 0.0], u + 1.0, &mut cell);
                if cell.len() < 3 {
                    continue;
                }
                let k = (j - rows.start) * across + i;
                // One diagonal is v - j = u - i, the other (u - i) + (v - j) = 1.
                let falls = patches[2 * k].half == 0;
                let (n, limit) = if falls { ([-1.0, 1.0], v - u) } else { ([1.0, 1.0], u + v + 1.0) };
                halves(&cell, n, limit, &mut parts);
                for (which, part) in parts.iter().enumerate() {
                    if part.len() >= 3 {
                        let patch = &mut patches[2 * k + which];
                        let mass = integrate(part, affine.density, [u, v], patch.half);
                        patch.add(mass, &affine, [u, v]);
                        made.push((2 * k as u32 + which as u32, Fragment::new(facets.len() as u32, mass)));
                    }
                }
            }
        }
        facets.push(affine.facet);
    }
    facets.shrink_to_fit();
    // Dealt out to the patches; within one they stay in the order of the mesh.
    let mut start = vec![0u32; patches.len() + 1];
    made.iter().for_each(|(key, _)| start[*key as usize + 1] += 1);
    (0..patches.len()).for_each(|k| start[k + 1] += start[k]);
    let mut fragments = vec![Fragment::default(); made.len()];
    for (key, fragment) in made {
        let at = &mut start[key as usize];
        fragments[*at as usize] = fragment;
        *at += 1;
    }
    // After the dealing each start is the end.
    patches.iter_mut().zip(&start).for_each(|(p, end)| p.end = *end);
    Patches { patches, fragments, facets }
}

/// The first cell that a polygon meets along a coordinate, and the one past the last.
fn span(polygon: &[[f64; 2]], c: usize) -> (usize, usize) {
    let lo = polygon.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min);
    let hi = polygon.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max);
    (lo.floor().max(0.0) as usize, hi.ceil().max(0.0) as usize)
}

/// Integrals over a convex polygon of b b^T (00, 01, 02, 11, 12, 22), b the corner functions of a texel triangle of the
/// quad at `at`.
fn integrate(polygon: &[[f64; 2]], density: f64, at: [f64; 2], half: u8) -> [f64; 6] {
    let corners = |q: [f64; 2]| {
        let (s, t) = (q[0] - at[0], q[1] - at[1]);
        match half {
            0 => [1.0 - s, s - t, t],
            1 => [1.0 - t, s, t - s],
            2 => [1.0 - s - t, s, t],
            _ => [1.0 - t, s + t - 1.0, 1.0 - s],
        }
    };
    let mut mass = [0.0; 6];
    let (a, mut c) = (corners(polygon[0]), corners(polygon[1]));
    for k in 1..polygon.len() - 1 {
        let b = c;
        c = corners(polygon[k + 1]);
        let w = signed_area2([polygon[0], polygon[k], polygon[k + 1]]).abs() * density / 24.0;
        let sum = [0, 1, 2].map(|k| a[k] + b[k] + c[k]);
        for (m, (x, y)) in mass.iter_mut().zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]) {
            *m += w * (a[x] * a[y] + b[x] * b[y] + c[x] * c[y] + sum[x] * sum[y]);
        }
    }
    mass
}

#[cfg(test)]
mod tests {
    use super::super::patch::HALVES;
    use super::*;

    #[test]
    fn the_whole_of_each_half_has_the_mass_of_a_triangle() {
        for half in 0..4_u8 {
            let polygon = HALVES[half as usize].map(|c| [7.0 + c[0] as f64, 3.0 + c[1] as f64]);
            let mass = integrate(&polygon, 2.0, [7.0, 3.0], half);
            // Area / 12 between corners, area / 6 at them.
            let expected = [1.0 / 6.0, 1.0 / 12.0, 1.0 / 12.0, 1.0 / 6.0, 1.0 / 12.0, 1.0 / 6.0];
            assert!(mass.iter().zip(expected).all(|(m, e)| (m - e).abs() < 1e-14), "{half}: {mass:?}");
        }
    }

    #[test]
    fn parts_of_a_polygon_add_up() {
        let pentagon = [[2.1, 5.0], [2.6, 5.1], [2.7, 5.2], [2.9, 5.8], [2.3, 5.2]];
        let parts: [&[usize]; 2] = [&[0, 1, 2, 4], &[2, 3, 4]];
        for half in 0..4 {
            let whole = integrate(&pentagon, 1.5, [2.0, 5.0], half);
            let mut sum = [0.0; 6];
            for part in parts {
                let polygon: Vec<_> = part.iter().map(|&k| pentagon[k]).collect();
                let mass = integrate(&polygon, 1.5, [2.0, 5.0], half);
                sum.iter_mut().zip(mass).for_each(|(s, m)| *s += m);
            }
            assert!(whole.iter().zip(sum).all(|(a, b)| (a - b).abs() < 1e-15), "{half}");
        }
    }
}
