//! Stiffnesses of springs that stand for an elastic membrane.

use super::cell::{Cell, P2, cross, sub};

/// Stiffness \[N/m\] of the springs of a cell by direction. `warp` is the direction of the warp in the cell's plane, of
/// length 1; `sheet` the stiffness for strains along weft, warp, and the shear angle.
///
/// A spring of length l along the unit vector e takes up the strain E with k l^2 (e.E.e)^2 / 2. The sums of these over
/// the cell are to be the area times the energy of the sheet; as springs do not push strains apart, no stiffness is below
/// 0, and the nearest in the sheet's own norm is taken, in which a strain counts by the energy it costs.
pub fn fit(cell: &Cell, warp: P2, sheet: &[[f64; 3]; 3]) -> [f64; 4] {
    let Some(scale) = inverse_root(sheet) else { return [0.0; 4] };
    let weft = [warp[1], -warp[0]];
    // Columns: what a unit of stiffness adds, as the six entries of a symmetric matrix, the mixed ones times sqrt 2.
    let mut columns = [[0.0; 6]; 4];
    for ([a, b], _, direction) in cell.springs() {
        let d = sub(cell.at[b], cell.at[a]);
        let (x, y) = (d[0] * weft[0] + d[1] * weft[1], d[0] * warp[0] + d[1] * warp[1]);
        let square = x * x + y * y;
        let v = scaled(&scale, [x * x / square, y * y / square, x * y / square]);
        let root = 2f64.sqrt();
        let entries =
            [v[0] * v[0], v[1] * v[1], v[2] * v[2], root * v[0] * v[1], root * v[0] * v[2], root * v[1] * v[2]];
        columns[direction].iter_mut().zip(entries).for_each(|(c, e)| *c += square * e);
    }
    let area = area(cell);
    nearest(&columns, &[area, area, area, 0.0, 0.0, 0.0])
}

/// Area \[m^2\].
pub fn area(cell: &Cell) -> f64 {
    let around: Vec<P2> = cell.around().map(|k| cell.at[k]).collect();
    let next = around.iter().cycle().skip(1);
    0.5 * around.iter().zip(next).map(|(a, b)| cross(*a, *b)).sum::<f64>().abs()
}

/// The inverse of the lower triangular root L of C = L L^T.
fn inverse_root(c: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let a = c[0][0].sqrt();
    let b = c[0][1] / a;
    let d = (c[1][1] - b * b).sqrt();
    let e = c[2][2].sqrt();
    let fine = [a, d, e].iter().all(|x| *x > 0.0);
    fine.then(|| [[1.0 / a, 0.0, 0.0], [-b / (a * d), 1.0 / d, 0.0], [0.0, 0.0, 1.0 / e]])
}

fn scaled(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|r| (0..3).map(|c| m[r][c] * v[c]).sum())
}

/// Least squares with four unknowns that are at least 0: every set of unknowns that may be above 0 is tried.
fn nearest(columns: &[[f64; 6]; 4], target: &[f64; 6]) -> [f64; 4] {
    let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // With columns of length 1, so that small and large cells are judged alike.
    let size = columns.each_ref().map(|c| dot(c, c).sqrt());
    let unit: Vec<[f64; 6]> = columns.iter().zip(size).map(|(c, s)| c.map(|x| if s > 0.0 { x / s } else { 0.0 })).collect();
    let mut best = ([0.0; 4], dot(target, target));
    for set in 1..16usize {
        let chosen: Vec<usize> = (0..4).filter(|k| set >> k & 1 == 1).collect();
        if chosen.iter().any(|k| size[*k] <= 0.0) {
            continue;
        }
        let Some(x) = solve(&chosen, |a, b| dot(&unit[a], &unit[b]), |a| dot(&unit[a], target)) else { continue };
        if x.iter().any(|x| *x < 0.0) {
            continue;
        }
        let mut left = *target;
        for (x, k) in x.iter().zip(&chosen) {
            left.iter_mut().zip(&unit[*k]).for_each(|(l, u)| *l -= x * u);
        }
        let error = dot(&left, &left);
        // Of sets that are as good the first one is kept, whatever rounding says.
        if error < best.1 * (1.0 - 1e-9) {
            let mut k = [0.0; 4];
            chosen.iter().zip(&x).for_each(|(n, x)| k[*n] = x / size[*n]);
            best = (k, error);
        }
    }
    best.0
}

/// Solves the normal equations of a few columns by Gauss's elimination; none where they depend on one another.
fn solve(chosen: &[usize], matrix: impl Fn(usize, usize) -> f64, right: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
    let n = chosen.len();
    let row = |a: &usize| chosen.iter().map(|b| matrix(*a, *b)).chain([right(*a)]).collect();
    let mut m: Vec<Vec<f64>> = chosen.iter().map(row).collect();
    for k in 0..n {
        // Positive definite, so the diagonal will do as pivot.
        if m[k][k] < 1e-9 {
            return None;
        }
        for r in (0..n).filter(|r| *r != k) {
            let by = m[r][k] / m[k][k];
            (k..=n).for_each(|c| m[r][c] -= by * m[k][c]);
        }
    }
    Some((0..n).map(|k| m[k][n] / m[k][k]).collect())
}
