//! Twin of shaders/membrane.wgsl: cells that resist to stretch along weft and warp, and to shear.

use crate::cloth::{Cloth, Grid};
use crate::cpu::rows::Threads;
use crate::cpu::sheet::{Sheet, planes};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;

/// The cells of a sheet.
#[derive(Clone)]
pub struct Cells<T> {
    /// Inverses of the rest shapes of two triangles by columns, in the layout of [`Sheet::w`]; 0 means no triangle. The sign
    /// of their determinants says which diagonal divides the cell: down-right, or up-right where it is negative.
    pub inverse: [Vec<T>; 8],
    /// One over the stiffness along the weft, along the warp, and in shear \[m/N\].
    pub soft: [T; 3],
}

/// The membrane of each sheet; empty for cloth of springs.
pub fn cells<T: Real>(cloth: &Cloth, sheets: &[Sheet<T>]) -> Vec<Cells<T>> {
    let Some(membrane) = cloth.membrane() else { return Vec::new() };
    let of = |(sheet, grid): (&Sheet<T>, &Grid)| {
        let entry = |k: usize, n: usize| membrane.cells[2 * (grid.first as usize + k) + n / 4][n % 4];
        let list = |n: usize| sheet.list(T::of(0.0), |k| T::of(entry(k, n).into()));
        Cells { inverse: [0, 1, 2, 3, 4, 5, 6, 7].map(list), soft: membrane.soft.map(|s| T::of(s.into())) }
    };
    sheets.iter().zip(cloth.grids()).map(of).collect()
}

/// Cells of every other column and row from (`column`, `row`) on, which share no particle, in a step of `dt` \[s\].
///
/// With weft and warp as columns of the deformation gradient, the energy of a triangle is half its area times
/// `(|weft| - 1)^2`, `(|warp| - 1)^2` and `(weft . warp)^2`, each over its compliance: D. Baraff, A. Witkin, "Large Steps
/// in Cloth Simulation", SIGGRAPH 98. The three are relaxed one after the other as in M. Macklin, M. Mueller,
/// N. Chentanez, "XPBD", MIG 2016.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, cells: &Cells<T>, (column, first): (usize, usize), dt: T) {
    let (width, half, row) = (sheet.width, sheet.half, sheet.row());
    let count = if column == 0 { width / 2 } else { (width - 1) / 2 };
    let w = &sheet.w[..];
    if first + 1 >= sheet.height {
        return;
    }
    threads.chunks(&mut sheet.now[first * row..], TOGETHER * row, |chunk, rows| {
        let first = first + chunk * TOGETHER;
        widest(Rows { rows, w, first, half, count, column, cells, span: dt * dt });
    });
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

/// Rows whose cells share no particle with those of other rows.
struct Rows<'a, 'b, T> {
    rows: &'b mut [T],
    w: &'a [T],
    first: usize,
    half: usize,
    count: usize,
    column: usize,
    cells: &'a Cells<T>,
    /// Square of the step \[s^2\].
    span: T,
}

/// A particle of each lane: position, inverse mass.
#[derive(Clone, Copy)]
struct Corner<V> {
    at: [V; 3],
    w: V,
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { w, half, count, column, cells, span, .. } = self;
        let soft = [k.splat(cells.soft[0]), k.splat(cells.soft[1]), k.splat(cells.soft[2])];
        let span = k.splat(span);
        for (n, rows) in self.rows.chunks_exact_mut(12 * half).enumerate() {
            let j = self.first + 2 * n;
            let (upper, lower) = rows.split_at_mut(6 * half);
            let (upper, lower) = (planes(upper, half), planes(lower, half));
            let (wu, wl) = (&w[j * 2 * half..], &w[(j + 1) * 2 * half..]);
            let left = column * half;
            // The even column to the right of an odd one is one further on.
            let right = (1 - column) * half + column;
            for at in (0..count).step_by(K::WIDE) {
                let place = [at + left, at + right];
                let corners = [
                    load(k, &upper, wu, place[0]),
                    load(k, &upper, wu, place[1]),
                    load(k, &lower, wl, place[0]),
                    load(k, &lower, wl, place[1]),
                ];
                let stored = j * 2 * half + left + at;
                let [p, q, r, s, e, f, g, h] = &cells.inverse;
                let first = [k.load(p, stored), k.load(q, stored), k.load(r, stored), k.load(s, stored)];
                let [p, q, r, s] = first;
                let inverse = [p, q, r, s, k.load(e, stored), k.load(f, stored), k.load(g, stored), k.load(h, stored)];
                let out = cell(k, corners, inverse, soft, span);
                for c in 0..3 {
                    k.store(upper[c], place[0], out[0].at[c]);
                    k.store(upper[c], place[1], out[1].at[c]);
                    k.store(lower[c], place[0], out[2].at[c]);
                    k.store(lower[c], place[1], out[3].at[c]);
                }
            }
        }
    }
}

#[inline(always)]
fn load<T: Real, K: Machine<T>>(k: K, row: &[&mut [T]; 3], w: &[T], at: usize) -> Corner<K::V> {
    Corner { at: [k.load(row[0], at), k.load(row[1], at), k.load(row[2], at)], w: k.load(w, at) }
}

#[inline(always)]
fn cell<T: Real, K: Machine<T>>(
    k: K,
    [a, b, c, d]: [Corner<K::V>; 4],
    [p, q, r, s, e, f, g, h]: [K::V; 8],
    soft: [K::V; 3],
    span: K::V,
) -> [Corner<K::V>; 4] {
    let first = k.sub(k.mul(p, s), k.mul(q, r));
    let second = k.sub(k.mul(e, h), k.mul(f, g));
    let up = k.above(k.splat(T::of(0.0)), k.add(first, second));
    let ring = [either(k, up, b, a), either(k, up, d, b), either(k, up, c, d), either(k, up, a, c)];
    let [x, y, z] = triangle(k, [ring[0], ring[1], ring[2]], [p, q, r, s], first, (soft, span));
    let [x, z, t] = triangle(k, [x, z, ring[3]], [e, f, g, h], second, (soft, span));
    [either(k, up, t, x), either(k, up, x, y), either(k, up, z, t), either(k, up, y, z)]
}

#[inline(always)]
fn either<T: Real, K: Machine<T>>(k: K, mask: K::M, x: Corner<K::V>, y: Corner<K::V>) -> Corner<K::V> {
    let at = [k.choose(mask, x.at[0], y.at[0]), k.choose(mask, x.at[1], y.at[1]), k.choose(mask, x.at[2], y.at[2])];
    Corner { at, w: k.choose(mask, x.w, y.w) }
}

#[inline(always)]
fn plus<T: Real, K: Machine<T>>(k: K, x: [K::V; 3], y: [K::V; 3]) -> [K::V; 3] {
    [k.add(x[0], y[0]), k.add(x[1], y[1]), k.add(x[2], y[2])]
}

#[inline(always)]
fn minus<T: Real, K: Machine<T>>(k: K, x: [K::V; 3], y: [K::V; 3]) -> [K::V; 3] {
    [k.sub(x[0], y[0]), k.sub(x[1], y[1]), k.sub(x[2], y[2])]
}

#[inline(always)]
fn scaled<T: Real, K: Machine<T>>(k: K, x: [K::V; 3], by: K::V) -> [K::V; 3] {
    [k.mul(x[0], by), k.mul(x[1], by), k.mul(x[2], by)]
}

/// The sum over three corners of inverse mass times two factors.
#[inline(always)]
fn sum<T: Real, K: Machine<T>>(k: K, w: [K::V; 3], x: [K::V; 3], y: [K::V; 3]) -> K::V {
    let first = k.mul(k.mul(w[0], x[0]), y[0]);
    let second = k.mul(k.mul(w[1], x[1]), y[1]);
    k.add(k.add(first, second), k.mul(k.mul(w[2], x[2]), y[2]))
}

/// By how much a direction is to be shortened.
#[inline(always)]
fn over<T: Real, K: Machine<T>>(k: K, x: [K::V; 3], stiff: K::V, there: K::M) -> [K::V; 3] {
    let far = k.most(k.sqrt(k.squares(x)), k.splat(T::of(1e-9)));
    let by = k.div(k.sub(far, k.splat(T::of(1.0))), k.mul(far, stiff));
    scaled(k, x, k.choose(there, by, k.splat(T::of(0.0))))
}

#[inline(always)]
fn triangle<T: Real, K: Machine<T>>(
    k: K,
    [a, b, c]: [Corner<K::V>; 3],
    q: [K::V; 4],
    det: K::V,
    (soft, span): ([K::V; 3], K::V),
) -> [Corner<K::V>; 3] {
    let (zero, two) = (k.splat(T::of(0.0)), k.splat(T::of(2.0)));
    let size = k.mul(two, k.most(det, k.sub(zero, det)));
    let there = k.above(size, zero);
    let [sx, sy, sz] = soft;
    let soft = [k.div(k.mul(sx, size), span), k.div(k.mul(sy, size), span), k.div(k.mul(sz, size), span)];
    let (e, h) = (minus(k, b.at, a.at), minus(k, c.at, a.at));
    let weft = plus(k, scaled(k, e, q[0]), scaled(k, h, q[2]));
    let warp = plus(k, scaled(k, e, q[1]), scaled(k, h, q[3]));
    let n = [k.sub(zero, k.add(q[0], q[2])), q[0], q[2]];
    let m = [k.sub(zero, k.add(q[1], q[3])), q[1], q[3]];
    let w = [a.w, b.w, c.w];
    let (nn, nm, mm) = (sum(k, w, n, n), sum(k, w, n, m), sum(k, w, m, m));
    let u = over(k, weft, k.add(nn, soft[0]), there);
    let weft = minus(k, weft, scaled(k, u, nn));
    let warp = minus(k, warp, scaled(k, u, nm));
    let v = over(k, warp, k.add(mm, soft[1]), there);
    let warp = minus(k, warp, scaled(k, v, mm));
    let weft = minus(k, weft, scaled(k, v, nm));
    let both = k.add(k.add(k.mul(weft[0], warp[0]), k.mul(weft[1], warp[1])), k.mul(weft[2], warp[2]));
    let stretched = k.add(k.mul(nn, k.squares(warp)), k.mul(k.mul(two, nm), both));
    let stiff = k.add(k.add(stretched, k.mul(mm, k.squares(weft))), soft[2]);
    let s = k.choose(there, k.div(both, stiff), zero);
    let u = plus(k, u, scaled(k, warp, s));
    let v = plus(k, v, scaled(k, weft, s));
    [moved(k, a, u, v, n[0], m[0], there), moved(k, b, u, v, n[1], m[1], there), moved(k, c, u, v, n[2], m[2], there)]
}

/// Where there is no triangle the factors are 0, but the numbers that they multiply may be NaN.
#[inline(always)]
fn moved<T: Real, K: Machine<T>>(
    k: K,
    corner: Corner<K::V>,
    u: [K::V; 3],
    v: [K::V; 3],
    n: K::V,
    m: K::V,
    there: K::M,
) -> Corner<K::V> {
    let Corner { at, w } = corner;
    let to = minus(k, at, scaled(k, plus(k, scaled(k, u, n), scaled(k, v, m)), w));
    Corner { at: [k.choose(there, to[0], at[0]), k.choose(there, to[1], at[1]), k.choose(there, to[2], at[2])], w }
}
