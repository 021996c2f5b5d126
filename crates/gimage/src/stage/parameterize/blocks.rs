//! Sparse Cholesky of small systems, block by block: a left-looking factorisation for patterns of up to some thousand
//! columns, which the searches factorise hundreds of times. Larger ones gain from the dense kernels of `sparse`.

/// An entry of the matrix: a number, or a 2 x 2 block (row by row as given). Right-hand sides are two numbers a row either way: two
/// systems for numbers, the two coordinates of one for blocks.
pub(super) trait Entry: Copy {
    const ZERO: Self;
    /// An entry as the second factor of many products.
    type Second;
    fn as_second(self) -> Self::Second;
    /// self - a b^T
    fn minus_product(self, a: Self, b: &Self::Second) -> Self;
    /// Lower factor of a diagonal entry, `None` if it is not positive definite.
    fn factor(self) -> Option<Self>;
    /// self l^-T for a factor l.
    fn over(self, l: Self) -> Self;
    /// v - self x
    fn minus_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2];
    /// v - self^T x
    fn minus_transposed_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2];
    /// self^-1 v of a factor
    fn forward(self, v: [f64; 2]) -> [f64; 2];
    /// self^-T v of a factor
    fn backward(self, v: [f64; 2]) -> [f64; 2];
    fn transposed(self) -> Self;
}

impl Entry for f64 {
    const ZERO: Self = 0.0;
    type Second = f64;
    #[inline(always)]
    fn as_second(self) -> f64 {
        self
    }
    #[inline(always)]
    fn minus_product(self, a: Self, b: &f64) -> Self {
        self - a * b
    }
    #[inline(always)]
    fn factor(self) -> Option<Self> {
        (self > 0.0).then(|| self.sqrt())
    }
    #[inline(always)]
    fn over(self, l: Self) -> Self {
        self / l
    }
    #[inline]
    fn minus_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [v[0] - self * x[0], v[1] - self * x[1]]
    }
    #[inline]
    fn minus_transposed_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        self.minus_times(x, v)
    }
    #[inline]
    fn forward(self, v: [f64; 2]) -> [f64; 2] {
        [v[0] / self, v[1] / self]
    }
    #[inline]
    fn backward(self, v: [f64; 2]) -> [f64; 2] {
        self.forward(v)
    }
    #[inline(always)]
    fn transposed(self) -> Self {
        self
    }
}

/// In a factor blocks stand column by column: two columns of a product are then one wide operation.
impl Entry for [f64; 4] {
    const ZERO: Self = [0.0; 4];
    /// Factors of the two columns of the other factor.
    type Second = [[f64; 4]; 2];
    #[inline(always)]
    fn as_second(self) -> Self::Second {
        [[self[0], self[0], self[1], self[1]], [self[2], self[2], self[3], self[3]]]
    }
    #[inline(always)]
    fn minus_product(self, a: Self, [p, q]: &Self::Second) -> Self {
        let (x, y) = ([a[0], a[1], a[0], a[1]], [a[2], a[3], a[2], a[3]]);
        let mut out = self;
        for k in 0..4 {
            out[k] -= x[k] * p[k] + y[k] * q[k];
        }
        out
    }
    #[inline(always)]
    fn factor(self) -> Option<Self> {
        let l00 = f64::factor(self[0])?;
        let l10 = self[1] / l00;
        Some([l00, l10, 0.0, f64::factor(self[3] - l10 * l10)?])
    }
    #[inline(always)]
    fn over(self, l: Self) -> Self {
        let (x, y) = (self[0] / l[0], self[1] / l[0]);
        [x, y, (self[2] - x * l[1]) / l[3], (self[3] - y * l[1]) / l[3]]
    }
    #[inline]
    fn minus_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [v[0] - (self[0] * x[0] + self[2] * x[1]), v[1] - (self[1] * x[0] + self[3] * x[1])]
    }
    #[inline]
    fn minus_transposed_times(self, x: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [v[0] - (self[0] * x[0] + self[1] * x[1]), v[1] - (self[2] * x[0] + self[3] * x[1])]
    }
    #[inline]
    fn forward(self, v: [f64; 2]) -> [f64; 2] {
        let x = v[0] / self[0];
        [x, (v[1] - self[1] * x) / self[3]]
    }
    #[inline]
    fn backward(self, v: [f64; 2]) -> [f64; 2] {
        let y = v[1] / self[3];
        [(v[0] - self[1] * y) / self[0], y]
    }
    #[inline(always)]
    fn transposed(self) -> Self {
        [self[0], self[2], self[1], self[3]]
    }
}

/// Set in a place whose entry is to be transposed.
const TURNED: u32 = 1 << 31;
const NONE: u32 = u32::MAX;

/// The pattern of a factor: made once, used for numbers and blocks alike.
pub(super) struct Pattern {
    /// Step at which each unknown is eliminated.
    step: Vec<u32>,
    /// Columns of the factor, the diagonal first, rows ascending.
    col_ptr: Vec<u32>,
    rows: Vec<u32>,
    /// Where each entry of the matrix goes, with [`TURNED`].
    place: Vec<u32>,
}

impl Pattern {
    /// Analyses a lower triangle by columns, rows ascending, the diagonal first; `order` lists the unknowns as they are
    /// to be eliminated. `None` if the factor would take more than `most` products.
    pub(super) fn new(col_ptr: &[u32], row_idx: &[u32], order: &[u32], most: u64) -> Option<Self> {
        let n = order.len();
        let mut step = vec![0u32; n];
        order.iter().enumerate().for_each(|(k, &v)| step[v as usize] = k as u32);
        let mut below: Vec<Vec<u32>> = vec![Vec::new(); n];
        for j in 0..n {
            for &i in &row_idx[col_ptr[j] as usize + 1..col_ptr[j + 1] as usize] {
                let (a, b) = (step[i as usize], step[j]);
                below[a.min(b) as usize].push(a.max(b));
            }
        }
        // A column has its own rows and those of its children in the elimination tree.
        let (mut ptr, mut rows) = (vec![0u32], Vec::new());
        let mut child = vec![NONE; n];
        let mut sibling = vec![NONE; n];
        let mut mark = vec![NONE; n];
        let mut products = 0u64;
        for k in 0..n as u32 {
            let from = rows.len();
            rows.push(k);
            mark[k as usize] = k;
            let add = |i: u32, rows: &mut Vec<u32>, mark: &mut [u32]| {
                if mark[i as usize] != k {
                    mark[i as usize] = k;
                    rows.push(i);
                }
            };
            below[k as usize].iter().for_each(|&i| add(i, &mut rows, &mut mark));
            let mut c = child[k as usize];
            while c != NONE {
                for t in ptr[c as usize] as usize + 1..ptr[c as usize + 1] as usize {
                    add(rows[t], &mut rows, &mut mark);
                }
                c = sibling[c as usize];
            }
            rows[from..].sort_unstable();
            if let Some(&parent) = rows.get(from + 1) {
                sibling[k as usize] = child[parent as usize];
                child[parent as usize] = k;
            }
            ptr.push(rows.len() as u32);
            let many = (rows.len() - from) as u64;
            products += many * many / 2;
            if products > most {
                return None;
            }
        }
        let mut place = vec![0; row_idx.len()];
        for j in 0..n {
            for t in col_ptr[j] as usize..col_ptr[j + 1] as usize {
                let (a, b) = (step[row_idx[t] as usize], step[j]);
                let column = ptr[a.min(b) as usize];
                let at = rows[column as usize..ptr[a.min(b) as usize + 1] as usize].binary_search(&a.max(b)).ok()?;
                place[t] = (column + at as u32) | if a < b { TURNED } else { 0 };
            }
        }
        Some(Self { step, col_ptr: ptr, rows, place })
    }

    /// Entries of the factor.
    fn size(&self) -> usize {
        self.rows.len()
    }
}

/// A factor and what it takes to make it again.
pub(super) struct Factor<E> {
    values: Vec<E>,
    /// For each row the first column of the list that is to be applied to it, and the next in the list of each column.
    head: Vec<u32>,
    next: Vec<u32>,
    /// The entry of each column that its list stands at.
    at: Vec<u32>,
    /// Where each row is in the column at work.
    slot: Vec<u32>,
}

impl<E: Entry> Factor<E> {
    pub(super) fn new(pattern: &Pattern) -> Self {
        let n = pattern.step.len();
        Self {
            values: vec![E::ZERO; pattern.size()],
            head: vec![NONE; n],
            next: vec![NONE; n],
            at: vec![0; n],
            slot: vec![0; n],
        }
    }

    /// Factorises the matrix of these entries, laid out as the analysed pattern. `false` if it is not positive definite.
    pub(super) fn factorize(&mut self, pattern: &Pattern, entries: &[E]) -> bool {
        pulp::Arch::new().dispatch(Factorize { factor: self, pattern, entries })
    }

    #[inline(always)]
    fn factorize_wide(&mut self, pattern: &Pattern, entries: &[E]) -> bool {
        let Self { values, head, next, at, slot } = self;
        let n = head.len();
        values.fill(E::ZERO);
        head.fill(NONE);
        for (x, &p) in entries.iter().zip(&pattern.place) {
            // Row by row and transposed is column by column.
            values[(p & !TURNED) as usize] = if p & TURNED != 0 { *x } else { x.transposed() };
        }
        for j in 0..n {
            let (from, to) = (pattern.col_ptr[j] as usize, pattern.col_ptr[j + 1] as usize);
            let (done, column) = values.split_at_mut(from);
            let column = &mut column[..to - from];
            let rows = &pattern.rows[from..to];
            rows.iter().enumerate().for_each(|(t, &i)| slot[i as usize] = t as u32);
            let mut k = head[j];
            while k != NONE {
                let after = next[k as usize];
                let (first, last) = (at[k as usize] as usize, pattern.col_ptr[k as usize + 1] as usize);
                let pivot = done[first].as_second();
                for (x, &i) in done[first..last].iter().zip(&pattern.rows[first..last]) {
                    let c = &mut column[slot[i as usize] as usize];
                    *c = c.minus_product(*x, &pivot);
                }
                if first + 1 < last {
                    let row = pattern.rows[first + 1] as usize;
                    at[k as usize] = first as u32 + 1;
                    next[k as usize] = head[row];
                    head[row] = k;
                }
                k = after;
            }
            let Some(pivot) = column[0].factor() else { return false };
            column[0] = pivot;
            column[1..].iter_mut().for_each(|x| *x = x.over(pivot));
            if let Some(&row) = rows.get(1) {
                at[j] = from as u32 + 1;
                next[j] = head[row as usize];
                head[row as usize] = j as u32;
            }
        }
        true
    }

    /// Solves in place, two numbers an unknown.
    pub(super) fn solve(&self, pattern: &Pattern, rhs: &mut [[f64; 2]]) {
        let n = self.head.len();
        let mut x = vec![[0.0; 2]; n];
        rhs.iter().zip(&pattern.step).for_each(|(r, &s)| x[s as usize] = *r);
        let column = |j: usize| {
            let range = pattern.col_ptr[j] as usize..pattern.col_ptr[j + 1] as usize;
            (&pattern.rows[range.clone()], &self.values[range])
        };
        for j in 0..n {
            let (rows, values) = column(j);
            let v = values[0].forward(x[j]);
            x[j] = v;
            for (&i, l) in rows[1..].iter().zip(&values[1..]) {
                x[i as usize] = l.minus_times(v, x[i as usize]);
            }
        }
        for j in (0..n).rev() {
            let (rows, values) = column(j);
            let mut v = x[j];
            for (&i, l) in rows[1..].iter().zip(&values[1..]) {
                v = l.minus_transposed_times(x[i as usize], v);
            }
            x[j] = values[0].backward(v);
        }
        rhs.iter_mut().zip(&pattern.step).for_each(|(r, &s)| *r = x[s as usize]);
    }
}

/// The factorisation in the widest vectors at hand. The products and sums are the same in all: nothing is fused.
struct Factorize<'a, E> {
    factor: &'a mut Factor<E>,
    pattern: &'a Pattern,
    entries: &'a [E],
}

impl<E: Entry> pulp::NullaryFnOnce for Factorize<'_, E> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        self.factor.factorize_wide(self.pattern, self.entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A pattern of n unknowns with a band and some far entries, and an order that is not its own.
    fn pattern(n: usize, far: &[(usize, usize)]) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
        let (mut ptr, mut row) = (vec![0u32], Vec::new());
        for j in 0..n {
            let mut below: Vec<u32> =
                far.iter().filter(|f| f.1 % n == j && f.0 % n > j).map(|f| (f.0 % n) as u32).collect();
            below.extend([j, j + 1].into_iter().filter(|&i| i < n).map(|i| i as u32));
            below.sort_unstable();
            below.dedup();
            row.extend(below);
            ptr.push(row.len() as u32);
        }
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by_key(|k| (k % 3, std::cmp::Reverse(*k)));
        (ptr, row, order)
    }

    proptest! {
        #[test]
        fn blocks_and_numbers_solve_what_they_factorised(
            n in 1usize..30,
            far in proptest::collection::vec((0usize..30, 0usize..30), 0..20),
            noise in proptest::collection::vec(-1.0f64..1.0, 4 * 200),
        ) {
            let (ptr, row, order) = pattern(n, &far);
            let p = Pattern::new(&ptr, &row, &order, u64::MAX).unwrap();
            // Diagonally dominant, so definite.
            let mut blocks = vec![[0.0; 4]; row.len()];
            let mut numbers = vec![0.0; row.len()];
            for j in 0..n {
                for t in ptr[j] as usize..ptr[j + 1] as usize {
                    let x: [f64; 4] = std::array::from_fn(|k| noise[(4 * t + k) % noise.len()]);
                    let diagonal = row[t] as usize == j;
                    blocks[t] = if diagonal { [90.0 + x[0], x[1], x[1], 90.0 + x[2]] } else { x };
                    numbers[t] = if diagonal { 90.0 } else { x[0] };
                }
            }
            let truth: Vec<[f64; 2]> = (0..n).map(|k| [noise[k], noise[k + 50]]).collect();
            let (mut rhs, mut rhs1) = (vec![[0.0; 2]; n], vec![[0.0; 2]; n]);
            for j in 0..n {
                for t in ptr[j] as usize..ptr[j + 1] as usize {
                    let (i, b, a) = (row[t] as usize, blocks[t], numbers[t]);
                    let mut add = |r: usize, b: [f64; 4], c: usize| {
                        rhs[r][0] += b[0] * truth[c][0] + b[1] * truth[c][1];
                        rhs[r][1] += b[2] * truth[c][0] + b[3] * truth[c][1];
                        (0..2).for_each(|k| rhs1[r][k] += a * truth[c][k]);
                    };
                    add(i, b, j);
                    if i != j {
                        add(j, b.transposed(), i);
                    }
                }
            }
            let (mut f, mut g) = (Factor::<[f64; 4]>::new(&p), Factor::<f64>::new(&p));
            for _ in 0..2 {
                prop_assert!(f.factorize(&p, &blocks) && g.factorize(&p, &numbers));
                let (mut x, mut y) = (rhs.clone(), rhs1.clone());
                f.solve(&p, &mut x);
                g.solve(&p, &mut y);
                for k in 0..2 * n {
                    prop_assert!((x[k / 2][k % 2] - truth[k / 2][k % 2]).abs() < 1e-9);
                    prop_assert!((y[k / 2][k % 2] - truth[k / 2][k % 2]).abs() < 1e-9);
                }
            }
            blocks[0][0] = -1.0;
            prop_assert!(!f.factorize(&p, &blocks));
        }
    }

    #[test]
    fn a_factor_too_large_is_refused() {
        let (ptr, row, order) = pattern(30, &[(29, 0), (28, 1)]);
        assert!(Pattern::new(&ptr, &row, &order, 10).is_none());
    }
}
