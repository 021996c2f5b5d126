//! Sparse Cholesky with one symbolic analysis for many numeric factorisations. The only module that names faer.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

/// The factor of a symmetric positive definite matrix given by its lower triangle.
pub(crate) struct Cholesky {
    pattern: SymbolicSparseColMat<u32>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    scratch: MemBuffer,
}

impl Cholesky {
    /// Analyses an n x n pattern: lower triangle by columns, rows ascending, every diagonal entry present.
    /// `order`, if given, lists the unknowns in the order of their elimination; otherwise approximate minimum degree.
    /// `None` if memory runs out.
    pub(crate) fn new(n: usize, col_ptr: Vec<u32>, row_idx: Vec<u32>, order: Option<&[u32]>) -> Option<Self> {
        let pattern = SymbolicSparseColMat::new_checked(n, n, col_ptr, None, row_idx);
        let params = CholeskySymbolicParams::default();
        let symbolic = match order {
            None => factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Amd, params),
            Some(forward) => {
                let mut inverse = vec![0u32; n];
                for (k, &v) in forward.iter().enumerate() {
                    inverse[v as usize] = k as u32;
                }
                let perm = faer::perm::PermRef::new_checked(forward, &inverse, n);
                factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Custom(perm), params)
            }
        }
        .ok()?;
        let scratch = StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(2, Par::Seq),
        ]);
        let scratch = MemBuffer::try_new(scratch).ok()?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val()).ok()?;
        factor.resize(symbolic.len_val(), 0.0);
        Some(Self { pattern, symbolic, factor, scratch })
    }

    /// The order of elimination the analysis chose.
    pub(crate) fn order(&self) -> Vec<u32> {
        match self.symbolic.perm() {
            Some(p) => p.arrays().0.to_vec(),
            None => (0..self.pattern.nrows() as u32).collect(),
        }
    }

    /// Factorises the matrix with these values, laid out as the pattern. `false` if it is not positive definite.
    pub(crate) fn factorize(&mut self, values: &[f64]) -> bool {
        let pattern: SymbolicSparseColMatRef<'_, u32> = self.pattern.as_ref();
        let matrix = SparseColMatRef::new(pattern, values);
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Default::default(),
            )
            .is_ok()
    }

    /// Solves in place for one or two right-hand sides, stored one after the other.
    pub(crate) fn solve(&mut self, rhs: &mut [f64]) {
        let n = self.pattern.nrows();
        let columns = rhs.len() / n.max(1);
        let rhs = MatMut::from_column_major_slice_mut(rhs, n, columns);
        LltRef::<'_, u32, f64>::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            rhs,
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_chain_in_any_order() {
        // Second differences with Dirichlet ends: the solution of A x = b for x = 0..n is known.
        let n = 50usize;
        let (mut ptr, mut row, mut val) = (vec![0u32], Vec::new(), Vec::new());
        for j in 0..n {
            row.push(j as u32);
            val.push(2.0);
            if j + 1 < n {
                row.push(j as u32 + 1);
                val.push(-1.0);
            }
            ptr.push(row.len() as u32);
        }
        let reversed: Vec<u32> = (0..n as u32).rev().collect();
        for order in [None, Some(reversed.as_slice())] {
            let mut c = Cholesky::new(n, ptr.clone(), row.clone(), order).unwrap();
            assert!(c.factorize(&val));
            let mut b = vec![0.0; 2 * n];
            b[n - 1] = 1.0 + n as f64;
            b[n - 1] -= 1.0;
            b[n - 1] += 1.0;
            b[2 * n - 1] = 2.0 * (1.0 + n as f64);
            c.solve(&mut b);
            for i in 0..n {
                assert!((b[i] - (i + 1) as f64 * 1.0).abs() < 1e-9, "{} {}", i, b[i]);
                assert!((b[n + i] - 2.0 * (i + 1) as f64).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut c = Cholesky::new(2, vec![0, 2, 3], vec![0, 1, 1], None).unwrap();
        assert!(!c.factorize(&[1.0, 2.0, 1.0]));
    }
}
