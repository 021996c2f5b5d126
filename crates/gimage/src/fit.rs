//! Least squares instead of point samples: texels move off the surface so that the triangles between them come closest.
//!
//! With border texels held, the inner ones minimise, over the surface S,
//! `int_S |X - P|^2 + mu |dX - dP|^2`, where X is the piecewise linear surface the image stands for (each texel quad
//! split by its shorter diagonal), P the original and d the gradient in texel units. The first term alone is the L2
//! projection, which gains the most distance but tilts facets; the second holds the tangent planes. All integrals are
//! exact: the mesh is clipped against the texel triangles and every term is quadratic on a fragment.

use rayon::prelude::*;

use crate::disk::Disk;
use crate::parameterize::Cholesky;
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

/// Normal equations on the grid: a 3 x 3 stencil and a right-hand side for each texel.
struct Normal {
    stencil: Vec<[f64; 9]>,
    rhs: Vec<[f64; 3]>,
    columns: usize,
}

impl Normal {
    fn new(columns: usize, rows: usize) -> Self {
        Self { stencil: vec![[0.0; 9]; columns * rows], rhs: vec![[0.0; 3]; columns * rows], columns }
    }

    fn add(&mut self, a: usize, b: usize, x: f64) {
        let (ai, aj) = (a % self.columns, a / self.columns);
        let (bi, bj) = (b % self.columns, b / self.columns);
        self.stencil[a][(bj + 1 - aj) * 3 + (bi + 1 - ai)] += x;
    }
}

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
                for c in 0..3 {
                    normal.rhs[corner[x]][c] += w * b3[x] * p[c];
                }
            }
        }
    }
    let w = total * gradient;
    for x in 0..3 {
        for y in 0..3 {
            normal.add(corner[x], corner[y], w * (slope[x][0] * slope[y][0] + slope[x][1] * slope[y][1]));
        }
        for c in 0..3 {
            normal.rhs[corner[x]][c] += w * (slope[x][0] * map.du[c] + slope[x][1] * map.dv[c]);
        }
    }
}

/// The texel triangles of the quad whose first corner is `at`, split by the shorter diagonal.
fn halves(points: &[[f64; 3]], columns: usize, at: usize) -> ([[usize; 3]; 2], bool) {
    let (a, b, c, d) = (at, at + 1, at + columns + 1, at + columns);
    let ac = distance(points[a], points[c]) <= distance(points[b], points[d]);
    (if ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }, ac)
}

/// Mesh triangles per parallel chunk; chunks are summed in order.
const CHUNK: usize = 8192;

/// Moves the inner texels of `points` (row by row, `columns` x `rows`) to the least-squares fit; border texels stay.
/// `uv` is the flip-free map in texel units. `false` (and no change) if the system cannot be solved.
/// O(triangles + texels) plus one sparse factorisation.
pub(crate) fn fit(
    disk: &Disk,
    uv: &[[f64; 2]],
    points: &mut [[f64; 3]],
    columns: usize,
    rows: usize,
    options: &FitOptions,
) -> bool {
    if columns < 3 || rows < 3 {
        return true;
    }
    // Work around the middle of the piece, in its own size: a garment far from the origin loses nothing.
    let n = disk.positions.len().max(1) as f64;
    let centre = disk.positions.iter().fold([0.0; 3], |m, p| [0, 1, 2].map(|c| m[c] + p[c] / n));
    let local: Vec<[f64; 3]> = points.iter().map(|p| sub(*p, centre)).collect();
    let parts: Vec<Normal> = disk
        .triangles
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut normal = Normal::new(columns, rows);
            let (mut cell, mut next, mut half) = (Vec::new(), Vec::new(), Vec::new());
            for &t in chunk {
                let p = planar(uv, t);
                let area2 = signed_area2(p);
                let x = t.map(|v| sub(disk.positions[v as usize], centre));
                let surface = norm(cross(sub(x[1], x[0]), sub(x[2], x[0])));
                if area2 <= 1e-14 || surface <= 0.0 {
                    continue;
                }
                let map = Affine::new(x, p, area2);
                let density = surface / area2;
                let span = |c: usize, top: usize| {
                    let lo = p.iter().map(|q| q[c]).fold(f64::INFINITY, f64::min).floor().max(0.0) as usize;
                    let hi = p.iter().map(|q| q[c]).fold(f64::NEG_INFINITY, f64::max).ceil().max(1.0) as usize;
                    (lo, hi.min(top - 1).max(lo + 1).min(top - 1))
                };
                let ((i0, i1), (j0, j1)) = (span(0, columns), span(1, rows));
                for j in j0..j1 {
                    for i in i0..i1 {
                        let (u, v) = (i as f64, j as f64);
                        cell.clear();
                        cell.extend_from_slice(&p);
                        for (n, d) in
                            [([-1.0, 0.0], -u), ([1.0, 0.0], u + 1.0), ([0.0, -1.0], -v), ([0.0, 1.0], v + 1.0)]
                        {
                            clip(&cell, n, d, &mut next);
                            std::mem::swap(&mut cell, &mut next);
                            if cell.len() < 3 {
                                break;
                            }
                        }
                        if cell.len() < 3 {
                            continue;
                        }
                        let (corner, ac) = halves(&local, columns, j * columns + i);
                        // The diagonal a-c is v - j = u - i; b-d is (u - i) + (v - j) = 1.
                        let (n, d) = if ac { ([-1.0, 1.0], v - u) } else { ([1.0, 1.0], u + v + 1.0) };
                        for (k, sign) in [(0, 1.0), (1, -1.0)] {
                            clip(&cell, [sign * n[0], sign * n[1]], sign * d, &mut half);
                            if half.len() >= 3 {
                                fragment(&mut normal, &half, corner[k], density, &map, options.gradient);
                            }
                        }
                    }
                }
            }
            normal
        })
        .collect();
    let mut parts = parts.into_iter();
    let Some(mut normal) = parts.next() else { return false };
    for part in parts {
        normal.stencil.iter_mut().zip(part.stencil).for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += b));
        normal.rhs.iter_mut().zip(part.rhs).for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += b));
    }
    let Some(inner) = solve(&normal, &local, columns, rows) else { return false };
    for (k, p) in inner {
        points[k] = crate::vec3::add(p, centre);
    }
    true
}

/// Solves for the inner texels with the border held; a trace of Tikhonov keeps texels that almost no surface falls on.
fn solve(normal: &Normal, points: &[[f64; 3]], columns: usize, rows: usize) -> Option<Vec<(usize, [f64; 3])>> {
    let inner = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        i > 0 && j > 0 && i + 1 < columns && j + 1 < rows
    };
    let number = |k: usize| (k / columns - 1) * (columns - 2) + k % columns - 1;
    let n = (columns - 2) * (rows - 2);
    let mean = normal.stencil.iter().map(|s| s[4]).sum::<f64>() / normal.stencil.len() as f64;
    let hold = 1e-4 * mean;
    let (mut col_ptr, mut row_idx, mut values) = (vec![0u32], Vec::new(), Vec::new());
    let mut rhs = vec![0.0; 3 * n];
    let texels: Vec<usize> = (0..points.len()).filter(|&k| inner(k)).collect();
    for &k in &texels {
        let x = number(k);
        for (c, r) in normal.rhs[k].iter().enumerate() {
            rhs[c * n + x] += r + hold * points[k][c];
        }
        for (s, &a) in normal.stencil[k].iter().enumerate() {
            let other = (k + (s / 3) * columns + s % 3) - columns - 1;
            if !inner(other) {
                for c in 0..3 {
                    rhs[c * n + x] -= a * points[other][c];
                }
            } else if other >= k {
                row_idx.push(number(other) as u32);
                values.push(if other == k { a + hold } else { a });
            }
        }
        col_ptr.push(row_idx.len() as u32);
    }
    let mut cholesky = Cholesky::new(n, col_ptr, row_idx, None)?;
    if !cholesky.factorize(&values) {
        return None;
    }
    cholesky.solve(&mut rhs);
    if rhs.iter().any(|x| !x.is_finite()) {
        return None;
    }
    Some(texels.iter().enumerate().map(|(x, &k)| (k, [rhs[x], rhs[n + x], rhs[2 * n + x]])).collect())
}
