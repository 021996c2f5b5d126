//! Least squares instead of point samples: texels move off the surface so that the triangles between them come closest.
//!
//! All texels, the duplicates of a seam point as one, minimise over the surface S
//! `int_S |X - P|^2 + mu w |dX - dP|^2`, where X is the piecewise linear surface the image stands for (each texel quad
//! split by its shorter diagonal), P the original and d the gradient in texel units. Distance along the surface is no
//! error, so P and dP slide along it to where X was in the round before (the iterated point-to-plane fit of Chen, Medioni
//! 1992, majorised so that every round is one scalar system); rounds are extrapolated (Nesterov 1983). That lets texels
//! settle on folds. The second term holds the normals; its weight w falls with the angle between X and the surface, so
//! that facets of one plane stay flat although a fold beside them cannot be matched. All integrals are exact: the mesh is
//! clipped against the texel triangles and every term is quadratic on a fragment. Texels of the garment's own boundary do
//! not slide: its curves and corners stay.

use rayon::prelude::*;

use crate::disk::Disk;
use crate::normal::Normal;
use crate::parameterize::distortion::{planar, signed_area2};
use crate::vec3::{cross, distance, dot, norm, scale, sub};

/// How the texels are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Weight of the gradient term, 0..1; larger keeps normals truer and distance less.
    pub gradient: f64,
    /// How far the target slides along the surface with the fit, 0..1: only the distance across it counts if 1.
    pub slip: f64,
    /// Angle between normals at which the gradient term counts half \[rad\]: folds hold less than flat parts.
    pub sharp: f64,
    /// Rounds of the fit, 1..; more is closer.
    pub rounds: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { gradient: 0.3, slip: 0.9, sharp: 0.05, rounds: 6 }
    }
}

/// How near the solve of a round comes, as a share of where it began: the next round moves the target anyway.
const NEAR: f64 = 2e-2;

/// How much more the gradient term counts where the image is turned over by more than a right angle.
const TURNED: f64 = 2.0;

/// Above this share of the area turned over, that is how the image of a shell thinner than texels looks: nothing is held.
const MOST_TURNED: f64 = 0.005;

/// How firmly the garment's own boundary is held to where it was sampled, as a share of what pulls at it: beyond a
/// boundary is no surface that would hold it.
const RIM: f64 = 1.0;

/// Cuts a convex polygon by `n . x <= d`.
pub(crate) fn clip(polygon: &[[f64; 2]], n: [f64; 2], d: f64, out: &mut Vec<[f64; 2]>) {
    out.clear();
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (sp, sq) = (n[0] * p[0] + n[1] * p[1] - d, n[0] * q[0] + n[1] * q[1] - d);
        if sp <= 0.0 {
            out.push(p);
        }
        if (sp < 0.0 && sq > 0.0) || (sp > 0.0 && sq < 0.0) {
            let t = sp / (sp - sq);
            out.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
}

/// One mesh triangle as an affine map of the plane: P(u, v) = o + u du + v dv.
struct Facet {
    o: [f64; 3],
    du: [f64; 3],
    dv: [f64; 3],
    normal: [f64; 3],
    /// Surface per area of the plane.
    density: f64,
}

impl Facet {
    /// `None` for a triangle without area on the surface or in the plane.
    fn new(x: [[f64; 3]; 3], p: [[f64; 2]; 3]) -> Option<Self> {
        let area2 = signed_area2(p);
        let (e, f) = (sub(x[1], x[0]), sub(x[2], x[0]));
        let n = cross(e, f);
        if area2 <= 1e-14 || norm(n) <= 0.0 {
            return None;
        }
        let (a, b) = ([p[1][0] - p[0][0], p[1][1] - p[0][1]], [p[2][0] - p[0][0], p[2][1] - p[0][1]]);
        let du = [0, 1, 2].map(|c| (e[c] * b[1] - f[c] * a[1]) / area2);
        let dv = [0, 1, 2].map(|c| (f[c] * a[0] - e[c] * b[0]) / area2);
        let o = [0, 1, 2].map(|c| x[0][c] - p[0][0] * du[c] - p[0][1] * dv[c]);
        Some(Self { o, du, dv, normal: scale(n, 1.0 / norm(n)), density: norm(n) / area2 })
    }

    fn at(&self, q: [f64; 2]) -> [f64; 3] {
        [0, 1, 2].map(|c| self.o[c] + q[0] * self.du[c] + q[1] * self.dv[c])
    }

    /// From `p` towards `x` along the facet.
    #[inline]
    fn slide(&self, p: [f64; 3], x: [f64; 3], slip: f64) -> [f64; 3] {
        let off = [x[0] - p[0], x[1] - p[1], x[2] - p[2]];
        let across = slip * dot(off, self.normal);
        let n = self.normal;
        [
            p[0] + slip * off[0] - across * n[0],
            p[1] + slip * off[1] - across * n[1],
            p[2] + slip * off[2] - across * n[2],
        ]
    }
}

/// The integrals over one fragment: a mesh triangle within a texel triangle.
struct Fragment {
    facet: u32,
    /// First texel of the quad, and which of its four triangles this is.
    quad: u32,
    half: u8,
    /// Of b b^T (00, 01, 02, 11, 12, 22), b the corner functions of the texel triangle. In f32: there are many.
    mass: [f32; 6],
    /// Of b P^T.
    moment: [[f32; 3]; 3],
}

/// The corners of a quad's triangles, as steps right and down: both halves by one diagonal and by the other.
const HALVES: [[[usize; 2]; 3]; 4] =
    [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]], [[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]];

/// Gradients of the corner functions of [`HALVES`], each of which is half a unit square.
const SLOPES: [[[f64; 2]; 3]; 4] = [
    [[-1.0, 0.0], [1.0, -1.0], [0.0, 1.0]],
    [[0.0, -1.0], [1.0, 0.0], [-1.0, 1.0]],
    [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]],
    [[0.0, -1.0], [1.0, 1.0], [-1.0, 0.0]],
];

impl Fragment {
    /// Integrates over a convex polygon of the plane, `at` the first texel of the quad.
    fn new(polygon: &[[f64; 2]], facet: (u32, &Facet), quad: u32, at: [usize; 2], half: u8) -> Self {
        let place = HALVES[half as usize].map(|c| [(at[0] + c[0]) as f64, (at[1] + c[1]) as f64]);
        let (mut mass, mut moment) = ([0.0; 6], [[0.0; 3]; 3]);
        for k in 1..polygon.len() - 1 {
            let tri = [polygon[0], polygon[k], polygon[k + 1]];
            let w = 0.5 * signed_area2(tri).abs() * facet.1.density / 3.0;
            // Midpoints of the edges integrate quadratics exactly.
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let q = [0.5 * (tri[a][0] + tri[b][0]), 0.5 * (tri[a][1] + tri[b][1])];
                let (b1, b2) = (signed_area2([place[0], q, place[2]]), signed_area2([place[0], place[1], q]));
                let b = [1.0 - b1 - b2, b1, b2];
                let p = facet.1.at(q);
                for (m, (x, y)) in mass.iter_mut().zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]) {
                    *m += w * b[x] * b[y];
                }
                for x in 0..3 {
                    (0..3).for_each(|c| moment[x][c] += w * b[x] * p[c]);
                }
            }
        }
        let moment = moment.map(|m| m.map(|x| x as f32));
        Self { facet: facet.0, quad, half, mass: mass.map(|m| m as f32), moment }
    }

    /// The area of the fragment, and whether texels at `points` turn it over by more than a right angle.
    fn turned(&self, facet: &Facet, points: &[[f64; 3]], columns: usize) -> (f64, bool) {
        let [p, q, r] = HALVES[self.half as usize].map(|c| points[self.quad as usize + c[1] * columns + c[0]]);
        let [a, b, c, d, e, f] = self.mass.map(f64::from);
        (a + d + f + 2.0 * (b + c + e), dot(cross(sub(q, p), sub(r, p)), facet.normal) < 0.0)
    }

    /// Adds the fragment's terms with texels now at `points`. What is turned over is held harder if `turned`.
    fn add(
        &self,
        normal: &mut Normal,
        facet: &Facet,
        points: &[[f64; 3]],
        rim: &[bool],
        (options, turned): (&FitOptions, bool),
    ) {
        let (columns, half) = (normal.columns, self.half as usize & 3);
        let corner = HALVES[half].map(|c| self.quad as usize + c[1] * columns + c[0]);
        let now = corner.map(|k| points[k]);
        let slip = if corner.iter().any(|&k| rim[k]) { 0.0 } else { options.slip };
        let [a, b, c, d, e, f] = self.mass.map(f64::from);
        let mass = [[a, b, c], [b, d, e], [c, e, f]];
        let slope = &SLOPES[half];
        let sum = |w: [f64; 3]| [0, 1, 2].map(|c| w[0] * now[0][c] + w[1] * now[1][c] + w[2] * now[2][c]);
        let [xu, xv] = [0, 1].map(|c| sum([slope[0][c], slope[1][c], slope[2][c]]));
        let (du, dv) = (facet.slide(facet.du, xu, slip), facet.slide(facet.dv, xv, slip));
        // What points away is held all the harder: left to itself it stays turned over.
        let across = cross(xu, xv);
        let square = dot(across, across);
        let cos = if square > 0.0 { dot(across, facet.normal) / square.sqrt() } else { 0.5 };
        let off = (2.0 - 2.0 * cos).max(0.0).sqrt();
        let (off, hold) = if turned && cos < 0.0 { (0.0, TURNED) } else { (off, 1.0) };
        let total = a + d + f + 2.0 * (b + c + e);
        let w = hold * total * options.gradient * options.sharp / (options.sharp + off);
        let mut stencil = mass;
        for x in 0..3 {
            let s = [w * slope[x][0], w * slope[x][1]];
            for y in 0..3 {
                stencil[x][y] += s[0] * slope[y][0] + s[1] * slope[y][1];
            }
            let p = facet.slide(self.moment[x].map(f64::from), sum(mass[x]), slip);
            normal.add_rhs(corner[x], [0, 1, 2].map(|c| p[c] + s[0] * du[c] + s[1] * dv[c]));
        }
        normal.add_three(corner, HALVES[half], &stencil);
    }
}

/// Cell rows a band: bands are worked on in parallel and summed in order, so that nothing depends on the threads.
const BAND: usize = 16;

/// The triangles whose image meets each band of cell rows, in order.
fn bands(disk: &Disk, uv: &[[f64; 2]], cell_rows: usize) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); cell_rows.div_ceil(BAND)];
    for (f, &t) in disk.triangles.iter().enumerate() {
        let v = planar(uv, t).map(|p| p[1]);
        let lo = v.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as usize;
        let hi = v.into_iter().fold(f64::NEG_INFINITY, f64::max).max(0.0) as usize;
        let last = out.len() - 1;
        for band in &mut out[(lo / BAND).min(last)..=(hi / BAND).min(last)] {
            band.push(f as u32);
        }
    }
    out
}

/// What the image is to the fit.
pub(crate) struct Image<'a> {
    pub columns: usize,
    pub rows: usize,
    /// Texels that are one point: members stay bit-identical.
    pub rings: &'a [Vec<u32>],
    /// Texels on the surface's own boundary: their curves and corners stay.
    pub rim: &'a [bool],
}

/// Moves `points` (row by row) to the least-squares fit. `uv` is the flip-free map in texel units. `false` (and no change)
/// if the solve breaks down. O(triangles + texels) for the integrals, O(texels) for each of some tens of
/// conjugate-gradient steps a round.
pub(crate) fn fit(
    disk: &Disk,
    uv: &[[f64; 2]],
    points: &mut [[f64; 3]],
    image: &Image<'_>,
    options: &FitOptions,
) -> bool {
    let &Image { columns, rows, rings, rim } = image;
    if columns < 3 || rows < 3 {
        return true;
    }
    // Work around the middle of the piece: a garment far from the origin loses nothing.
    let n = disk.positions.len().max(1) as f64;
    let centre = disk.positions.iter().fold([0.0; 3], |m, p| [0, 1, 2].map(|c| m[c] + p[c] / n));
    let mut local: Vec<[f64; 3]> = points.iter().map(|p| sub(*p, centre)).collect();
    let facets: Vec<Option<Facet>> = disk
        .triangles
        .iter()
        .map(|&t| Facet::new(t.map(|v| sub(disk.positions[v as usize], centre)), planar(uv, t)))
        .collect();
    let bands = bands(disk, uv, rows - 1);
    let cells = |band: usize| band * BAND..((band + 1) * BAND).min(rows - 1);
    // Texels move little, and with them the diagonals: one clipping serves all rounds.
    let fragments: Vec<Vec<Fragment>> = bands
        .par_iter()
        .enumerate()
        .map(|(band, triangles)| {
            let mut out = Vec::new();
            for &f in triangles {
                if let Some(facet) = &facets[f as usize] {
                    let p = planar(uv, disk.triangles[f as usize]);
                    clipped(&mut out, (f, facet), p, columns, &local, &cells(band));
                }
            }
            out
        })
        .collect();
    let (mut all, mut over) = (0.0, 0.0);
    for x in fragments.iter().flatten() {
        if let Some(facet) = &facets[x.facet as usize] {
            let (area, turned) = x.turned(facet, &local, columns);
            all += area;
            over += if turned { area } else { 0.0 };
        }
    }
    let hold = over <= MOST_TURNED * all;
    let sampled = local.clone();
    let mut before = local.clone();
    let mut last = local.clone();
    let mut parts: Vec<Normal> =
        (0..bands.len()).map(|band| Normal::new(columns, cells(band).start, cells(band).len() + 1)).collect();
    let mut normal = Normal::new(columns, 0, rows);
    for round in 0..options.rounds {
        last.copy_from_slice(&local);
        if round > 1 {
            local.iter_mut().zip(&before).for_each(|(x, b)| (0..3).for_each(|c| x[c] += x[c] - b[c]));
        }
        std::mem::swap(&mut before, &mut last);
        parts.par_iter_mut().zip(&fragments).for_each(|(part, fragments)| {
            part.clear();
            for x in fragments {
                if let Some(facet) = &facets[x.facet as usize] {
                    x.add(part, facet, &local, rim, (options, hold));
                }
            }
        });
        normal.clear();
        for part in &parts {
            normal.add_rows(part);
        }
        normal.hold(rim, &sampled, RIM);
        if !normal.solve(&mut local, rings, NEAR) {
            return false;
        }
    }
    for (p, l) in points.iter_mut().zip(&local) {
        *p = crate::vec3::add(*l, centre);
    }
    true
}

/// Clips a mesh triangle, at `p` in the plane, against the texel triangles of the cell rows `cells`.
fn clipped(
    out: &mut Vec<Fragment>,
    facet: (u32, &Facet),
    p: [[f64; 2]; 3],
    columns: usize,
    points: &[[f64; 3]],
    cells: &std::ops::Range<usize>,
) {
    let span = |c: usize| {
        let lo = p.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min).floor().max(0.0) as usize;
        let hi = p.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max).ceil().max(0.0) as usize;
        (lo, hi)
    };
    let ((i0, i1), (j0, j1)) = (span(0), span(1));
    let (mut row, mut cell, mut next, mut half) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for j in j0.max(cells.start)..j1.min(cells.end) {
        let v = j as f64;
        clip(&p, [0.0, -1.0], -v, &mut next);
        clip(&next, [0.0, 1.0], v + 1.0, &mut row);
        for i in i0..i1.min(columns - 1) {
            let u = i as f64;
            clip(&row, [-1.0, 0.0], -u, &mut next);
            clip(&next, [1.0, 0.0], u + 1.0, &mut cell);
            if cell.len() < 3 {
                continue;
            }
            let at = j * columns + i;
            let [a, b, c, d] = [at, at + 1, at + columns + 1, at + columns].map(|k| points[k]);
            // The diagonal a-c is v - j = u - i; b-d is (u - i) + (v - j) = 1.
            let ac = distance(a, c) <= distance(b, d);
            let (n, limit) = if ac { ([-1.0, 1.0], v - u) } else { ([1.0, 1.0], u + v + 1.0) };
            for (k, sign) in [(0, 1.0), (1, -1.0)] {
                clip(&cell, [sign * n[0], sign * n[1]], sign * limit, &mut half);
                if half.len() >= 3 {
                    let which = if ac { k } else { 2 + k };
                    out.push(Fragment::new(&half, facet, at as u32, [i, j], which));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::measure::{MeasureOptions, measure};
    use crate::shapes::{self, Mapped};

    fn points(m: &Mapped) -> Vec<[f64; 3]> {
        m.samples.iter().map(|s| s.position(&m.disk)).collect()
    }

    /// The texels of every surface point that has several.
    fn rings(m: &Mapped) -> Vec<Vec<u32>> {
        let mut of_key = std::collections::BTreeMap::<_, Vec<u32>>::new();
        for (p, t) in m.texels.iter().enumerate() {
            of_key.entry(t.key).or_default().push(crate::resample::border_index(p as u32, m.w, m.h) as u32);
        }
        of_key.into_values().filter(|r| r.len() > 1).collect()
    }

    fn fitted(m: &Mapped) -> Vec<[f64; 3]> {
        let mut p = points(m);
        for ring in rings(m) {
            ring.iter().for_each(|&k| p[k as usize] = p[ring[0] as usize]);
        }
        let (columns, rows) = (m.w as usize + 1, m.h as usize + 1);
        let (rings, rim) = (rings(m), vec![false; columns * rows]);
        let image = Image { columns, rows, rings: &rings, rim: &rim };
        assert!(fit(&m.disk, &m.uv, &mut p, &image, &FitOptions::default()));
        p
    }

    #[test]
    fn a_flat_sheet_stays_flat_to_the_last_bit() {
        let m = shapes::mapped(&shapes::rectangle(7, 5, 1.4, 1.0), 20, 14);
        let (a, b) = (points(&m), fitted(&m));
        // In its plane texels may slide where the map bends.
        assert!(a.iter().zip(&b).all(|(p, q)| (p[2] - q[2]).abs() < 1e-12));
    }

    #[test]
    fn a_curved_patch_comes_closer() {
        let ball = shapes::sphere(96, 48);
        let s = shapes::without(&ball, |t| ball.corners(t).iter().any(|p| p[1] < 0.2));
        let m = shapes::mapped(&s, 16, 16);
        let (a, b) = (points(&m), fitted(&m));
        let quality = |p: &[[f64; 3]]| {
            let g = Grid::new(17, 17, p.to_vec());
            let options = MeasureOptions { samples: 20_000, seed: 1 };
            measure(&s.positions, &s.triangles, &g.positions, &g.triangulate(), &options).unwrap().psnr
        };
        assert!(quality(&b) > quality(&a) + 2.0, "{} {}", quality(&a), quality(&b));
    }

    #[test]
    fn duplicates_stay_one_point_to_the_last_bit() {
        let m = shapes::mapped(&shapes::torus(24, 16), 40, 40);
        let (before, after) = (points(&m), fitted(&m));
        let rings = rings(&m);
        assert!(rings.iter().any(|r| r.len() > 2));
        assert!(rings.iter().all(|r| r.iter().all(|&k| after[k as usize] == after[r[0] as usize])));
        assert!(rings.iter().any(|r| before[r[0] as usize] != after[r[0] as usize]), "seams are fitted too");
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let m = shapes::mapped(&shapes::torus(24, 16), 60, 60);
        let run = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| fitted(&m));
        assert_eq!(run(1), run(3));
    }
}
