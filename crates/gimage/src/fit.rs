//! Least squares instead of point samples: texels move off the surface so that the triangles between them come closest.
//!
//! All texels, the duplicates of a seam point as one, minimise over the surface S
//! `int_S |X - P|^2 + mu |dX - dP|^2`, where X is the piecewise linear surface the image stands for (each texel quad
//! split by its shorter diagonal), P the original and d the gradient in texel units. The first term alone is the L2
//! projection, which gains the most distance but tilts facets; the second holds the tangent planes. All integrals are
//! exact: the mesh is clipped against the texel triangles and every term is quadratic on a fragment.

use rayon::prelude::*;

use crate::disk::Disk;
use crate::normal::Normal;
use crate::parameterize::distortion::{planar, signed_area2};
use crate::vec3::{cross, distance, norm, sub};

/// How the texels are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Weight of the gradient term, 0..1; larger keeps normals truer and distance less.
    pub gradient: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { gradient: GRADIENT }
    }
}

const GRADIENT: f64 = 0.1;

/// Cuts a convex polygon by `n . x <= d`.
fn clip(polygon: &[[f64; 2]], n: [f64; 2], d: f64, out: &mut Vec<[f64; 2]>) {
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
struct Affine {
    o: [f64; 3],
    du: [f64; 3],
    dv: [f64; 3],
}

impl Affine {
    fn new(x: [[f64; 3]; 3], p: [[f64; 2]; 3], area2: f64) -> Self {
        let (e, f) = (sub(x[1], x[0]), sub(x[2], x[0]));
        let (a, b) = ([p[1][0] - p[0][0], p[1][1] - p[0][1]], [p[2][0] - p[0][0], p[2][1] - p[0][1]]);
        let du = [0, 1, 2].map(|c| (e[c] * b[1] - f[c] * a[1]) / area2);
        let dv = [0, 1, 2].map(|c| (f[c] * a[0] - e[c] * b[0]) / area2);
        let o = [0, 1, 2].map(|c| x[0][c] - p[0][0] * du[c] - p[0][1] * dv[c]);
        Self { o, du, dv }
    }

    fn at(&self, q: [f64; 2]) -> [f64; 3] {
        [0, 1, 2].map(|c| self.o[c] + q[0] * self.du[c] + q[1] * self.dv[c])
    }
}

/// Adds the integrals over one fragment (a convex polygon in the plane) under one texel triangle.
fn fragment(normal: &mut Normal, polygon: &[[f64; 2]], corner: [usize; 3], density: f64, map: &Affine, gradient: f64) {
    let columns = normal.columns;
    let place = corner.map(|k| [(k % columns) as f64, (k / columns) as f64]);
    // Texel triangles are half unit squares: twice their area is 1.
    let hat = |q: [f64; 2]| {
        let b1 = signed_area2([place[0], q, place[2]]);
        let b2 = signed_area2([place[0], place[1], q]);
        [1.0 - b1 - b2, b1, b2]
    };
    let slope = {
        let e = |a: usize, b: usize| [place[a][0] - place[b][0], place[a][1] - place[b][1]];
        let g1 = [e(2, 0)[1], -e(2, 0)[0]];
        let g2 = [-e(1, 0)[1], e(1, 0)[0]];
        [[-g1[0] - g2[0], -g1[1] - g2[1]], g1, g2]
    };
    let mut total = 0.0;
    for k in 1..polygon.len() - 1 {
        let tri = [polygon[0], polygon[k], polygon[k + 1]];
        let area = 0.5 * signed_area2(tri).abs() * density;
        total += area;
        // Midpoints of the edges integrate quadratics exactly.
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let q = [0.5 * (tri[a][0] + tri[b][0]), 0.5 * (tri[a][1] + tri[b][1])];
            let (b3, p, w) = (hat(q), map.at(q), area / 3.0);
            for x in 0..3 {
                for y in 0..3 {
                    normal.add(corner[x], corner[y], w * b3[x] * b3[y]);
                }
                normal.add_rhs(corner[x], p.map(|p| w * b3[x] * p));
            }
        }
    }
    let w = total * gradient;
    for x in 0..3 {
        for y in 0..3 {
            normal.add(corner[x], corner[y], w * (slope[x][0] * slope[y][0] + slope[x][1] * slope[y][1]));
        }
        normal.add_rhs(corner[x], [0, 1, 2].map(|c| w * (slope[x][0] * map.du[c] + slope[x][1] * map.dv[c])));
    }
}

/// The texel triangles of the quad whose first corner is `at`, split by the shorter diagonal.
fn halves(points: &[[f64; 3]], columns: usize, at: usize) -> ([[usize; 3]; 2], bool) {
    let (a, b, c, d) = (at, at + 1, at + columns + 1, at + columns);
    let ac = distance(points[a], points[c]) <= distance(points[b], points[d]);
    (if ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }, ac)
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

/// Moves `points` (row by row, `columns` x `rows`) to the least-squares fit. Members of a ring stay bit-identical.
/// `uv` is the flip-free map in texel units. `false` (and no change) if the solve breaks down.
/// O(triangles + texels) for the integrals, O(texels) for each of some tens of conjugate-gradient steps.
pub(crate) fn fit(
    disk: &Disk,
    uv: &[[f64; 2]],
    points: &mut [[f64; 3]],
    columns: usize,
    rows: usize,
    rings: &[Vec<u32>],
    options: &FitOptions,
) -> bool {
    if columns < 3 || rows < 3 {
        return true;
    }
    // Work around the middle of the piece: a garment far from the origin loses nothing.
    let n = disk.positions.len().max(1) as f64;
    let centre = disk.positions.iter().fold([0.0; 3], |m, p| [0, 1, 2].map(|c| m[c] + p[c] / n));
    let mut local: Vec<[f64; 3]> = points.iter().map(|p| sub(*p, centre)).collect();
    let parts: Vec<Normal> = bands(disk, uv, rows - 1)
        .par_iter()
        .enumerate()
        .map(|(band, triangles)| {
            let cells = band * BAND..((band + 1) * BAND).min(rows - 1);
            let mut normal = Normal::new(columns, cells.start, cells.len() + 1);
            for &f in triangles {
                integrate(&mut normal, disk, uv, f, centre, &local, &cells, options.gradient);
            }
            normal
        })
        .collect();
    let mut normal = Normal::new(columns, 0, rows);
    for part in parts {
        normal.add_rows(&part);
    }
    if !normal.solve(&mut local, rings) {
        return false;
    }
    for (p, l) in points.iter_mut().zip(&local) {
        *p = crate::vec3::add(*l, centre);
    }
    true
}

/// Adds the integrals over mesh triangle `f`, within the cell rows `cells`.
fn integrate(
    normal: &mut Normal,
    disk: &Disk,
    uv: &[[f64; 2]],
    f: u32,
    centre: [f64; 3],
    points: &[[f64; 3]],
    cells: &std::ops::Range<usize>,
    gradient: f64,
) {
    let t = disk.triangles[f as usize];
    let p = planar(uv, t);
    let area2 = signed_area2(p);
    let x = t.map(|v| sub(disk.positions[v as usize], centre));
    let surface = norm(cross(sub(x[1], x[0]), sub(x[2], x[0])));
    if area2 <= 1e-14 || surface <= 0.0 {
        return;
    }
    let columns = normal.columns;
    let map = Affine::new(x, p, area2);
    let density = surface / area2;
    let span = |c: usize| {
        let lo = p.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min).floor().max(0.0) as usize;
        let hi = p.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max).ceil().max(0.0) as usize;
        (lo, hi)
    };
    let ((i0, i1), (j0, j1)) = (span(0), span(1));
    let (mut cell, mut next, mut half) = (Vec::new(), Vec::new(), Vec::new());
    for j in j0.max(cells.start)..j1.min(cells.end) {
        for i in i0..i1.min(columns - 1) {
            let (u, v) = (i as f64, j as f64);
            cell.clear();
            cell.extend_from_slice(&p);
            for (n, d) in [([-1.0, 0.0], -u), ([1.0, 0.0], u + 1.0), ([0.0, -1.0], -v), ([0.0, 1.0], v + 1.0)] {
                clip(&cell, n, d, &mut next);
                std::mem::swap(&mut cell, &mut next);
                if cell.len() < 3 {
                    break;
                }
            }
            if cell.len() < 3 {
                continue;
            }
            let (corner, ac) = halves(points, columns, j * columns + i);
            // The diagonal a-c is v - j = u - i; b-d is (u - i) + (v - j) = 1.
            let (n, d) = if ac { ([-1.0, 1.0], v - u) } else { ([1.0, 1.0], u + v + 1.0) };
            for (k, sign) in [(0, 1.0), (1, -1.0)] {
                clip(&cell, [sign * n[0], sign * n[1]], sign * d, &mut half);
                if half.len() >= 3 {
                    fragment(normal, &half, corner[k], density, &map, gradient);
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
        assert!(fit(&m.disk, &m.uv, &mut p, columns, rows, &rings(m), &FitOptions::default()));
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
