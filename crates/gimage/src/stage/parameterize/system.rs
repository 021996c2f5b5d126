//! The linear systems over the free vertices of a planar map: one Laplacian, one Newton system, one ordering for both.

use super::blocks::{Factor, Pattern};
use super::distortion::RestShapes;
use super::newton::Local;
use super::sparse::Cholesky;
use crate::base::halfedge::sorted_edges;

/// Most products of a factor that is made block by block.
const SMALL: u64 = 1_500_000;

/// How the Laplacian is factorised.
enum Laplacian {
    Small(Box<Pattern>, Box<Factor<f64>>),
    Large(Box<Cholesky>),
}

/// How the Newton system is factorised; the small one shares the Laplacian's pattern.
enum Newton {
    Small(Box<Factor<[f64; 4]>>),
    Large(Box<Cholesky>),
}

/// Unknown of a fixed vertex.
const FIXED: u32 = u32::MAX;

/// Sparsity, orderings and factors for a mesh whose fixed vertices are known.
pub(crate) struct System {
    triangles: Vec<[u32; 3]>,
    /// Unknown of each vertex, or [`FIXED`].
    unknown: Vec<u32>,
    count: usize,
    /// Undirected edges, smaller vertex first, sorted.
    pub(crate) edges: Vec<[u32; 2]>,
    /// Mean-value weights of the edges, once they are known, and the factor of their Laplacian if it is small.
    pub(super) weights: Option<Vec<f64>>,
    /// The triangles at rest, once they are known.
    pub(super) rest: Option<RestShapes>,
    plain: Option<Box<Factor<f64>>>,
    /// Vertex-graph pattern, lower triangle by columns with the diagonal first.
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    laplacian: Option<Laplacian>,
    newton: Option<Newton>,
    /// For each triangle and corner pair (0,1), (1,2), (2,0): the place of its block in `row_idx`, or [`FIXED`].
    pair_at: Vec<[u32; 3]>,
}

impl System {
    /// O(n log n). `fixed` has an entry for each vertex.
    pub(crate) fn new(triangles: &[[u32; 3]], fixed: &[bool]) -> Self {
        let mut unknown = vec![FIXED; fixed.len()];
        let mut count = 0u32;
        let mut used = vec![false; fixed.len()];
        triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        for v in 0..fixed.len() {
            if !fixed[v] && used[v] {
                unknown[v] = count;
                count += 1;
            }
        }
        let mut edges: Vec<[u32; 2]> = sorted_edges(triangles).iter().map(|e| [e.0, e.1]).collect();
        edges.dedup();
        let n = count as usize;
        // Unknowns ascend with vertices, so sorted edges give sorted columns.
        let mut col_ptr = vec![0u32; n + 1];
        (1..=n).for_each(|j| col_ptr[j] = 1);
        for &[a, b] in &edges {
            if unknown[a as usize] != FIXED && unknown[b as usize] != FIXED {
                col_ptr[unknown[a as usize] as usize + 1] += 1;
            }
        }
        (0..n).for_each(|j| col_ptr[j + 1] += col_ptr[j]);
        let mut row_idx = Vec::with_capacity(col_ptr[n] as usize);
        let mut at = 0;
        for v in 0..fixed.len() as u32 {
            let inside = unknown[v as usize] != FIXED;
            if inside {
                row_idx.push(unknown[v as usize]);
            }
            while at < edges.len() && edges[at][0] == v {
                let b = unknown[edges[at][1] as usize];
                if inside && b != FIXED {
                    row_idx.push(b);
                }
                at += 1;
            }
        }
        let find = |a: u32, b: u32| {
            let (a, b) = (unknown[a as usize], unknown[b as usize]);
            if a == FIXED || b == FIXED {
                return FIXED;
            }
            let (j, i) = (a.min(b) as usize, a.max(b));
            let column = &row_idx[col_ptr[j] as usize..col_ptr[j + 1] as usize];
            column.binary_search(&i).map_or(FIXED, |k| col_ptr[j] + k as u32)
        };
        let pair_at = triangles.iter().map(|t| [find(t[0], t[1]), find(t[1], t[2]), find(t[2], t[0])]).collect();
        Self {
            triangles: triangles.to_vec(),
            unknown,
            count: n,
            edges,
            weights: None,
            rest: None,
            plain: None,
            col_ptr,
            row_idx,
            laplacian: None,
            newton: None,
            pair_at,
        }
    }

    /// How many vertices are free.
    pub(crate) fn unknowns(&self) -> usize {
        self.count
    }

    fn laplacian(&mut self) -> Option<&mut Laplacian> {
        if self.laplacian.is_none() {
            let large = Cholesky::new(self.count, self.col_ptr.clone(), self.row_idx.clone(), None)?;
            self.laplacian = Some(match Pattern::new(&self.col_ptr, &self.row_idx, &large.order(), SMALL) {
                Some(pattern) => {
                    let factor = Factor::new(&pattern);
                    Laplacian::Small(Box::new(pattern), Box::new(factor))
                }
                None => Laplacian::Large(Box::new(large)),
            });
        }
        self.laplacian.as_mut()
    }

    /// The entries of a weighted Laplacian, in the order of the pattern.
    fn weighted(&self, weights: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.row_idx.len()];
        let mut next: Vec<u32> = self.col_ptr.iter().map(|at| at + 1).collect();
        for (&[a, b], &w) in self.edges.iter().zip(weights) {
            let (i, j) = (self.unknown[a as usize], self.unknown[b as usize]);
            for x in [i, j] {
                if x != FIXED {
                    values[self.col_ptr[x as usize] as usize] += w;
                }
            }
            if i != FIXED && j != FIXED {
                // Edges are sorted and unknowns ascend: this is the next entry of column i.
                values[next[i as usize] as usize] = -w;
                next[i as usize] += 1;
            }
        }
        values
    }

    /// Places every free vertex at the weighted mean of its neighbours: `weights` (all positive) in the order of
    /// [`System::edges`]; `plain` if they are [`System::weights`], whose factor is made once. `false` if the factorisation
    /// fails.
    pub(crate) fn solve_weighted(&mut self, weights: &[f64], plain: bool, uv: &mut [[f64; 2]]) -> bool {
        let n = self.count;
        if n == 0 {
            return true;
        }
        let mut rhs = vec![[0.0; 2]; n];
        for (&[a, b], &w) in self.edges.iter().zip(weights) {
            let (i, j) = (self.unknown[a as usize], self.unknown[b as usize]);
            let (x, other) = if j == FIXED { (i, b) } else { (j, a) };
            if x != FIXED && (i == FIXED || j == FIXED) {
                rhs[x as usize][0] += w * uv[other as usize][0];
                rhs[x as usize][1] += w * uv[other as usize][1];
            }
        }
        let mut kept = if plain { self.plain.take() } else { None };
        let values = if kept.is_none() { self.weighted(weights) } else { Vec::new() };
        match self.laplacian() {
            Some(Laplacian::Small(pattern, factor)) => {
                let made = kept.is_some();
                let factor = if plain { kept.get_or_insert_with(|| Box::new(Factor::new(pattern))) } else { factor };
                if !made && !factor.factorize(pattern, &values) {
                    return false;
                }
                factor.solve(pattern, &mut rhs);
            }
            Some(Laplacian::Large(c)) => {
                if !c.factorize(&values) {
                    return false;
                }
                let mut columns: Vec<f64> = (0..2).flat_map(|c| rhs.iter().map(move |r| r[c])).collect();
                c.solve(&mut columns);
                rhs.iter_mut().enumerate().for_each(|(k, r)| *r = [columns[k], columns[n + k]]);
            }
            None => return false,
        }
        if plain {
            self.plain = kept;
        }
        for (v, &x) in self.unknown.iter().enumerate() {
            if x != FIXED {
                uv[v] = rhs[x as usize];
            }
        }
        uv.iter().flatten().all(|x| x.is_finite())
    }

    /// Solves H d = -g from the energies of the triangles. Returns the direction for every vertex and g . d.
    pub(super) fn newton_direction(&mut self, locals: impl Iterator<Item = Local>) -> Option<(Vec<[f64; 2]>, f64)> {
        let n = self.count;
        // One 2 x 2 block for each entry of the vertex pattern.
        let mut blocks = vec![[0.0; 4]; self.row_idx.len()];
        let mut gradient = vec![[0.0; 2]; n];
        let add = |to: &mut [f64; 4], x: &[f64; 4]| (0..4).for_each(|k| to[k] += x[k]);
        for ((t, pairs), local) in self.triangles.iter().zip(&self.pair_at).zip(locals) {
            let x = t.map(|v| self.unknown[v as usize]);
            for (a, &x) in x.iter().enumerate() {
                if x != FIXED {
                    let j = x as usize;
                    (0..2).for_each(|c| gradient[j][c] += local.gradient[a][c]);
                    add(&mut blocks[self.col_ptr[j] as usize], &local.own[a]);
                }
            }
            for k in 0..3 {
                if pairs[k] != FIXED {
                    // Rows of the larger unknown, columns of the smaller.
                    let (a, b, at) = [(0, 1, 0), (1, 2, 2), (0, 2, 1)][k];
                    let [p, q, r, s] = local.pair[at];
                    let block = if x[a] < x[b] { [p, r, q, s] } else { [p, q, r, s] };
                    add(&mut blocks[pairs[k] as usize], &block);
                }
            }
        }
        let at = |j: usize| self.col_ptr[j] as usize;
        let diagonal: f64 = (0..n).map(|j| blocks[at(j)][0] + blocks[at(j)][3]).sum::<f64>() / (2 * n) as f64;
        let (mut done, mut shift) = (0.0, 1e-10 * diagonal);
        if self.newton.is_none() {
            self.newton = Some(self.analyse_newton()?);
        }
        for _ in 0..4 {
            for j in 0..n {
                let block = &mut blocks[self.col_ptr[j] as usize];
                block[0] += shift - done;
                block[3] += shift - done;
            }
            let mut d: Vec<[f64; 2]> = gradient.iter().map(|g| [-g[0], -g[1]]).collect();
            let solved = match (self.newton.as_mut()?, self.laplacian.as_ref()?) {
                (Newton::Small(factor), Laplacian::Small(pattern, _)) => {
                    let fine = factor.factorize(pattern, &blocks);
                    if fine {
                        factor.solve(pattern, &mut d);
                    }
                    fine
                }
                (Newton::Large(c), _) => {
                    let fine = c.factorize(&scalars(&self.col_ptr, &blocks));
                    if fine {
                        c.solve(d.as_flattened_mut());
                    }
                    fine
                }
                _ => return None,
            };
            if !solved {
                (done, shift) = (shift, 1e3 * shift);
                continue;
            }
            if d.iter().flatten().any(|x| !x.is_finite()) {
                return None;
            }
            let slope: f64 = d.iter().zip(&gradient).map(|(d, g)| d[0] * g[0] + d[1] * g[1]).sum();
            let direction = self.unknown.iter().map(|&x| if x == FIXED { [0.0; 2] } else { d[x as usize] }).collect();
            return (slope < 0.0).then_some((direction, slope));
        }
        None
    }

    /// The pattern of the Newton system: every entry of the vertex pattern is a 2 x 2 block, ordered as the Laplacian.
    fn analyse_newton(&mut self) -> Option<Newton> {
        let n = self.count;
        let order: Vec<u32> = match self.laplacian()? {
            Laplacian::Small(pattern, _) => return Some(Newton::Small(Box::new(Factor::new(pattern)))),
            Laplacian::Large(c) => c.order().iter().flat_map(|&v| [2 * v, 2 * v + 1]).collect(),
        };
        let mut col_ptr = vec![0u32];
        let mut row_idx = Vec::with_capacity(4 * self.row_idx.len() - n);
        for j in 0..n {
            let column = &self.row_idx[self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize];
            for odd in 0..2u32 {
                for (k, &i) in column.iter().enumerate() {
                    if !(odd == 1 && k == 0) {
                        row_idx.push(2 * i);
                    }
                    row_idx.push(2 * i + 1);
                }
                col_ptr.push(row_idx.len() as u32);
            }
        }
        Cholesky::new(2 * n, col_ptr, row_idx, Some(&order)).map(|c| Newton::Large(Box::new(c)))
    }
}

/// Blocks as numbers, in the order of `analyse_newton`: column 2 j holds both rows of its blocks, column 2 j + 1 likewise
/// but for the upper row of the first.
fn scalars(col_ptr: &[u32], blocks: &[[f64; 4]]) -> Vec<f64> {
    let mut out = Vec::with_capacity(4 * blocks.len());
    for range in col_ptr.windows(2) {
        let column = &blocks[range[0] as usize..range[1] as usize];
        out.extend(column.iter().flat_map(|b| [b[0], b[2]]));
        out.extend(column.iter().flat_map(|b| [b[1], b[3]]).skip(1));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_weights_put_each_free_vertex_at_the_mean_of_its_neighbours() {
        let s = crate::base::shapes::rectangle(6, 5, 1.0, 1.0);
        let rim = crate::base::shapes::rim(&s);
        let mut system = System::new(&s.triangles, &rim);
        // A boundary of no special shape: the mean must not follow from symmetry.
        let mut uv: Vec<[f64; 2]> = s.positions.iter().map(|p| [p[0].exp() + p[1] * p[1], p[1] - p[0].sin()]).collect();
        assert!(system.solve_weighted(&vec![1.0; system.edges.len()], false, &mut uv));
        for v in (0..uv.len()).filter(|&v| !rim[v]) {
            let beside: Vec<usize> =
                system.edges.iter().filter(|e| e.contains(&(v as u32))).map(|e| (e[0] + e[1]) as usize - v).collect();
            for (c, here) in uv[v].iter().enumerate() {
                let mean = beside.iter().map(|&x| uv[x][c]).sum::<f64>() / beside.len() as f64;
                assert!((here - mean).abs() < 1e-12);
            }
        }
    }
}
