//! Normal equations on a grid of texels, and their solution by conjugate gradients.
//!
//! Every texel is coupled to its eight neighbours only, so the matrix is a 3 x 3 stencil a texel. It is a mass matrix
//! with a little stiffness: diagonally scaled conjugate gradients take some tens of steps whatever the size, where a
//! sparse factor of a large image would not fit in memory.

use rayon::prelude::*;

/// Texels per parallel chunk: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// A stencil and a right-hand side for each texel of an image.
pub(crate) struct Normal {
    /// Texels a row.
    columns: usize,
    /// Texels of a part.
    part: usize,
    stencil: Vec<[f64; 9]>,
    rhs: Vec<[f64; 3]>,
    /// For each part, the row past its own.
    past: (Vec<[f64; 9]>, Vec<[f64; 3]>),
    work: Work,
}

/// Buffers of the solve, kept from one to the next.
#[derive(Default)]
struct Work {
    unknown: Vec<bool>,
    scale: Vec<f64>,
    residual: Vec<[f64; 3]>,
    direction: Vec<[f64; 3]>,
    product: Vec<[f64; 3]>,
    solution: Vec<[f64; 3]>,
}

impl Normal {
    /// Zero equations for `rows` rows, of which a part has `part`.
    pub(crate) fn new(columns: usize, rows: usize, part: usize) -> Self {
        let (n, past) = (columns * rows, columns * rows.div_ceil(part));
        Self {
            columns,
            part: columns * part,
            stencil: vec![[0.0; 9]; n],
            rhs: vec![[0.0; 3]; n],
            past: (vec![[0.0; 9]; past], vec![[0.0; 3]; past]),
            work: Work::default(),
        }
    }

    /// Zero equations again.
    pub(crate) fn clear(&mut self) {
        self.stencil.fill([0.0; 9]);
        self.rhs.fill([0.0; 3]);
        self.past.0.fill([0.0; 9]);
        self.past.1.fill([0.0; 3]);
    }

    /// Parts of the rows, in order, each of which takes the terms of the quads that begin in it.
    pub(crate) fn parts(&mut self) -> impl IndexedParallelIterator<Item = Part<'_>> {
        let (columns, part) = (self.columns, self.part);
        let own = self.stencil.par_chunks_mut(part).zip(self.rhs.par_chunks_mut(part));
        let past = self.past.0.par_chunks_mut(columns).zip(self.past.1.par_chunks_mut(columns));
        own.zip(past).enumerate().map(move |(k, ((stencil, rhs), past))| Part {
            columns,
            first: k * part,
            stencil: [stencil, past.0],
            rhs: [rhs, past.1],
        })
    }

    /// Adds the row past each part's own rows to the first row of the next part.
    pub(crate) fn join(&mut self) {
        for (k, (stencil, rhs)) in self.past.0.iter().zip(&self.past.1).enumerate() {
            let at = (k / self.columns + 1) * self.part + k % self.columns;
            if at < self.stencil.len() {
                (0..9).for_each(|s| self.stencil[at][s] += stencil[s]);
                (0..3).for_each(|c| self.rhs[at][c] += rhs[c]);
            }
        }
    }

    /// Holds some texels to `places`, by a share of their own weight.
    pub(crate) fn hold(&mut self, which: &[bool], places: &[[f64; 3]], share: f64) {
        for ((s, rhs), (_, p)) in
            self.stencil.iter_mut().zip(&mut self.rhs).zip(which.iter().zip(places)).filter(|x| *x.1.0)
        {
            let weight = share * s[4];
            s[4] += weight;
            (0..3).for_each(|c| rhs[c] += weight * p[c]);
        }
    }

    /// Solves for all texels, from and towards `x`: a trace of weight on the start holds texels that
    /// almost no surface falls on. Members of a ring are one unknown and must be equal in `x`. `near` is the residual to
    /// reach as a share of the one at the start, in the norm of the diagonal. `false` (and `x` untouched) if it breaks
    /// down.
    pub(crate) fn solve(&mut self, x: &mut [[f64; 3]], rings: &[Vec<u32>], near: f64) -> bool {
        let (columns, n) = (self.columns, self.stencil.len());
        let rows = n / columns;
        let hold = 1e-4 * self.stencil.iter().map(|s| s[4]).sum::<f64>() / n as f64;
        let Work { unknown, scale, residual, direction, product, solution } = &mut self.work;
        let matrix = Matrix { columns, rows, stencil: &self.stencil, hold };
        // Only the first of a ring counts in sums over unknowns.
        unknown.clear();
        unknown.resize(n, true);
        rings.iter().flat_map(|r| &r[1..]).for_each(|&k| unknown[k as usize] = false);
        // A ring's equation is the sum of its members'.
        let gather = |v: &mut [[f64; 3]]| {
            for ring in rings {
                let mut sum = [0.0; 3];
                ring.iter().for_each(|&k| (0..3).for_each(|c| sum[c] += v[k as usize][c]));
                ring.iter().for_each(|&k| v[k as usize] = sum);
            }
        };
        product.clear();
        product.extend(self.stencil.iter().map(|s| [s[4] + hold, 0.0, 0.0]));
        gather(product);
        scale.clear();
        scale.extend(product.iter().map(|w| 1.0 / w[0].max(1e-300)));
        residual.resize(n, [0.0; 3]);
        residual.par_iter_mut().zip(&self.rhs).enumerate().with_min_len(least(n)).for_each(|(k, (r, b))| {
            let ax = matrix.row(x, k);
            *r = [0, 1, 2].map(|c| b[c] + hold * x[k][c] - ax[c]);
        });
        gather(residual);
        solution.clear();
        solution.resize(n, [0.0; 3]);
        let scaled = |r: &[f64; 3], s: f64| r.map(|v| v * s);
        direction.clear();
        direction.extend(residual.iter().zip(&*scale).map(|(r, &s)| scaled(r, s)));
        let power = |r: &[[f64; 3]], k: usize| {
            if unknown[k] { [0, 1, 2].map(|c| r[k][c] * r[k][c] * scale[k]) } else { [0.0; 3] }
        };
        let mut rho = sums(n, |k| power(residual, k));
        let target = rho.map(|r| r * near * near);
        for _ in 0..MOST_STEPS {
            if (0..3).all(|c| rho[c] <= target[c]) {
                break;
            }
            product.par_chunks_mut(CHUNK).enumerate().with_min_len(least(n) / CHUNK + 1).for_each(|(chunk, out)| {
                let (first, places) = (chunk * CHUNK, &direction[..]);
                pulp::Arch::new().dispatch(Rows { matrix: &matrix, places, first, out });
            });
            gather(product);
            let curvature =
                sums(n, |k| if unknown[k] { [0, 1, 2].map(|c| direction[k][c] * product[k][c]) } else { [0.0; 3] });
            let step = [0, 1, 2].map(|c| if curvature[c] > 0.0 { rho[c] / curvature[c] } else { 0.0 });
            let moves = direction.par_iter().zip(&*product);
            solution.par_iter_mut().zip(&mut *residual).zip(moves).with_min_len(least(n)).for_each(
                |((s, r), (d, p))| {
                    for c in 0..3 {
                        s[c] += step[c] * d[c];
                        r[c] -= step[c] * p[c];
                    }
                },
            );
            let next = sums(n, |k| power(residual, k));
            let turn = [0, 1, 2].map(|c| if rho[c] > 0.0 { next[c] / rho[c] } else { 0.0 });
            let left = residual.par_iter().zip(&*scale);
            direction.par_iter_mut().zip(left).with_min_len(least(n)).for_each(|(d, (r, &s))| {
                let z = scaled(r, s);
                (0..3).for_each(|c| d[c] = z[c] + turn[c] * d[c]);
            });
            rho = next;
        }
        if solution.iter().flatten().any(|v| !v.is_finite()) {
            return false;
        }
        x.iter_mut().zip(&*solution).for_each(|(x, s)| (0..3).for_each(|c| x[c] += s[c]));
        true
    }
}

/// Some rows of the equations, and the row past them.
pub(crate) struct Part<'a> {
    /// Texels a row.
    pub columns: usize,
    first: usize,
    stencil: [&'a mut [[f64; 9]]; 2],
    rhs: [&'a mut [[f64; 3]]; 2],
}

impl Part<'_> {
    /// Where texel `a` is.
    #[inline(always)]
    fn place(&self, a: usize) -> (usize, usize) {
        let (k, own) = (a - self.first, self.stencil[0].len());
        if k < own { (0, k) } else { (1, k - own) }
    }

    /// Adds a 3 x 3 block for three texels of one quad, `place` their steps right and down in it.
    #[inline(always)]
    pub(crate) fn add_three(&mut self, texels: [usize; 3], place: [[usize; 2]; 3], block: &[[f64; 3]; 3]) {
        for a in 0..3 {
            let (past, k) = self.place(texels[a]);
            let row = &mut self.stencil[past][k];
            for b in 0..3 {
                let at = (place[b][1] + 1 - place[a][1]) * 3 + place[b][0] + 1 - place[a][0];
                row[at] += block[a][b];
            }
        }
    }

    /// Adds to the right-hand side of texel `a`.
    #[inline(always)]
    pub(crate) fn add_rhs(&mut self, a: usize, x: [f64; 3]) {
        let (past, k) = self.place(a);
        let rhs = &mut self.rhs[past][k];
        (0..3).for_each(|c| rhs[c] += x[c]);
    }
}

/// The left-hand side.
struct Matrix<'a> {
    columns: usize,
    rows: usize,
    stencil: &'a [[f64; 9]],
    hold: f64,
}

impl Matrix<'_> {
    /// (A + hold) p at texel k.
    #[inline(always)]
    fn row(&self, p: &[[f64; 3]], k: usize) -> [f64; 3] {
        let (columns, rows) = (self.columns, self.rows);
        let mut sum = p[k].map(|p| self.hold * p);
        let (i, j) = (k % columns, k / columns);
        if i > 0 && i + 1 < columns && j > 0 && j + 1 < rows {
            for (a, from) in self.stencil[k].chunks_exact(3).zip([k - columns - 1, k - 1, k + columns - 1]) {
                let q = &p[from..from + 3];
                for t in 0..3 {
                    for c in 0..3 {
                        sum[c] += a[t] * q[t][c];
                    }
                }
            }
            return sum;
        }
        for (s, &a) in self.stencil[k].iter().enumerate() {
            if a != 0.0 && i + s % 3 >= 1 && i + s % 3 <= columns && j + s / 3 >= 1 && j + s / 3 <= rows {
                let q = p[k + (s / 3) * columns + s % 3 - columns - 1];
                (0..3).for_each(|c| sum[c] += a * q[c]);
            }
        }
        sum
    }
}

/// Products of some rows in the widest vectors at hand. They are the same in all: nothing is fused.
struct Rows<'a> {
    matrix: &'a Matrix<'a>,
    places: &'a [[f64; 3]],
    first: usize,
    out: &'a mut [[f64; 3]],
}

impl pulp::NullaryFnOnce for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (k, out) in self.out.iter_mut().enumerate() {
            *out = self.matrix.row(self.places, self.first + k);
        }
    }
}

/// Most conjugate-gradient steps; 1e-5 of the residual takes 15 to 70.
const MOST_STEPS: usize = 1000;

/// Texels that one task takes at least, of `n`: to wake another thread for fewer costs more than it does.
fn least(n: usize) -> usize {
    if n <= 8 * CHUNK { n.max(1) } else { CHUNK }
}

/// Sums of three terms over all texels, chunk by chunk in order.
fn sums(n: usize, term: impl Fn(usize) -> [f64; 3] + Sync) -> [f64; 3] {
    let chunks: Vec<[f64; 3]> = (0..n.div_ceil(CHUNK))
        .into_par_iter()
        .with_min_len(least(n) / CHUNK + 1)
        .map(|chunk| {
            let mut sum = [0.0; 3];
            for k in chunk * CHUNK..((chunk + 1) * CHUNK).min(n) {
                let t = term(k);
                (0..3).for_each(|c| sum[c] += t[c]);
            }
            sum
        })
        .collect();
    chunks.into_iter().fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const W: usize = 5;
    const H: usize = 4;

    /// Adds to the coefficient of texel `b` (a neighbour or itself) in the equation of texel `a`.
    fn add(normal: &mut Normal, a: usize, b: usize, x: f64) {
        let at = (b / W + 1 - a / W) * 3 + b % W + 1 - a % W;
        normal.stencil[a][at] += x;
    }

    #[test]
    fn parts_add_up_whatever_their_size() {
        let made = |rows: usize| {
            let mut normal = Normal::new(W, H, rows);
            for _ in 0..2 {
                normal.clear();
                normal.parts().for_each(|mut part| {
                    let quads = part.first / W..(part.first / W + rows).min(H - 1);
                    for at in quads.flat_map(|j| (0..W - 1).map(move |i| j * W + i)) {
                        let place = [[0, 0], [1, 0], [0, 1]];
                        let x = at as f64;
                        part.add_three([at, at + 1, at + W], place, &[[x, 1.0, 2.0], [1.0, 3.0, x], [2.0, x, 4.0]]);
                        part.add_rhs(at + W, [x, 1.0, -x]);
                    }
                });
                normal.join();
            }
            (normal.stencil, normal.rhs)
        };
        let whole = made(H);
        assert!(whole.1[(H - 1) * W][1] == 1.0 && whole.0[W + 1][4] == 3.0 + 6.0 + 4.0, "{whole:?}");
        (1..H).for_each(|rows| assert_eq!(made(rows), whole, "{rows}"));
    }

    /// Gaussian elimination with row pivots.
    fn dense(mut a: Vec<Vec<f64>>, mut b: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        let n = b.len();
        for k in 0..n {
            let pivot = (k..n).max_by(|&x, &y| a[x][k].abs().total_cmp(&a[y][k].abs())).unwrap();
            a.swap(k, pivot);
            b.swap(k, pivot);
            for r in (0..n).filter(|&r| r != k).collect::<Vec<_>>() {
                let f = a[r][k] / a[k][k];
                (k..n).for_each(|c| a[r][c] -= f * a[k][c]);
                (0..3).for_each(|c| b[r][c] -= f * b[k][c]);
            }
        }
        (0..n).map(|k| b[k].map(|v| v / a[k][k])).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn gradients_agree_with_elimination(
            x in prop::collection::vec(-1.0f64..1.0, 7 * (W - 1) * (H - 1) * 3),
            start in prop::collection::vec(-1.0f64..1.0, 3 * W * H),
            ringed in any::<bool>(),
        ) {
            // Each fragment lies in one quad and adds b b^T, so the sum is symmetric and positive.
            let n = W * H;
            let (mut normal, mut a, mut rhs) = (Normal::new(W, H, 2), vec![vec![0.0; n]; n], vec![[0.0; 3]; n]);
            for (k, f) in x.chunks(7).enumerate() {
                let q = k / 3;
                let at = q / (W - 1) * W + q % (W - 1);
                let corners = [at, at + 1, at + W, at + W + 1];
                for r in 0..4 {
                    for s in 0..4 {
                        add(&mut normal, corners[r], corners[s], f[r] * f[s]);
                        a[corners[r]][corners[s]] += f[r] * f[s];
                    }
                    let b = [f[r] * f[4], f[r] * f[5], f[r] * f[6]];
                    (0..3).for_each(|c| {
                        normal.rhs[corners[r]][c] += b[c];
                        rhs[corners[r]][c] += b[c];
                    });
                }
            }
            let rings: Vec<Vec<u32>> = if ringed { vec![vec![0, 4, 15, 19], vec![5, 9]] } else { Vec::new() };
            let mut of: Vec<usize> = (0..n).collect();
            rings.iter().for_each(|r| r.iter().for_each(|&k| of[k as usize] = r[0] as usize));
            let mut p: Vec<[f64; 3]> = (0..n).map(|k| [0, 1, 2].map(|c| start[3 * of[k] + c])).collect();
            let hold = 1e-4 * (0..n).map(|k| a[k][k]).sum::<f64>() / n as f64;
            // Rings merge by the sums of their rows and columns; what they leave is the identity.
            let (mut m, mut b) = (vec![vec![0.0; n]; n], vec![[0.0; 3]; n]);
            for k in 0..n {
                (0..n).for_each(|c| m[of[k]][of[c]] += a[k][c]);
                m[of[k]][of[k]] += hold;
                (0..3).for_each(|c| b[of[k]][c] += rhs[k][c] + hold * p[k][c]);
            }
            (0..n).filter(|&k| of[k] != k).for_each(|k| m[k][k] = 1.0);
            let expected = dense(m, b);
            prop_assert!(normal.solve(&mut p, &rings, 1e-10));
            for k in 0..n {
                for c in 0..3 {
                    let e = expected[of[k]][c];
                    prop_assert!((p[k][c] - e).abs() < 1e-5 * (1.0 + e.abs()), "{} {}", p[k][c], e);
                }
            }
        }
    }
}
