//! How texture coordinates run along the rows and columns of a cloth, which tangents follow.

use super::Cloth;

/// A step of texture coordinates is longer than this many usual ones only across a seam of the texture.
const JUMP: f32 = 4.0;

impl Cloth {
    /// For each particle the shares of the steps along its row and its column that lead along u, and the side to which v
    /// grows: 1 or -1, so that cross(normal, tangent) times it leads along v. Where texture coordinates tell nothing, u runs along the row.
    pub(crate) fn charts(&self) -> Vec<[f32; 4]> {
        let uv = self.uv();
        let mut all = vec![[1.0, 0.0, 1.0, 0.0]; self.len()];
        for g in self.grids() {
            let (first, w, h) = (g.first as usize, g.width as usize, g.height as usize);
            let jump = JUMP * usual(&uv[g.range()], w, 1).max(usual(&uv[g.range()], w, w));
            let step = |a: usize, b: usize| {
                let d = [0, 1].map(|c| uv[b][c] - uv[a][c]);
                let there = self.particles()[a].exists() && self.particles()[b].exists();
                (there && d[0].abs().max(d[1].abs()) <= jump).then_some(d)
            };
            for k in g.range().filter(|k| self.particles()[*k].exists()) {
                let (i, j) = ((k - first) % w, (k - first) / w);
                let row = mean([(i > 0).then(|| step(k - 1, k)), (i + 1 < w).then(|| step(k, k + 1))]);
                let column = mean([(j > 0).then(|| step(k - w, k)), (j + 1 < h).then(|| step(k, k + w))]);
                let det = row[0] * column[1] - row[1] * column[0];
                let (a, b) = (column[1] * det.signum(), -row[1] * det.signum());
                let size = a.hypot(b);
                if det != 0.0 && size > 0.0 {
                    all[k] = [a / size, b / size, det.signum(), 0.0];
                }
            }
        }
        all
    }
}

/// The mean of those steps that are there; 0 where there are none.
fn mean(steps: [Option<Option<[f32; 2]>>; 2]) -> [f32; 2] {
    let there: Vec<_> = steps.into_iter().flatten().flatten().collect();
    [0, 1].map(|c| there.iter().map(|d| d[c]).sum::<f32>() / there.len().max(1) as f32)
}

/// The median step along rows (`by` 1) or columns (`by` the width).
fn usual(uv: &[[f32; 2]], width: usize, by: usize) -> f32 {
    let inner = (0..uv.len() - by).filter(|k| by > 1 || k % width + 1 < width);
    let far = |k: usize| [0, 1].map(|c| (uv[k + by][c] - uv[k][c]).abs());
    let mut steps: Vec<_> = inner.map(far).map(|[u, v]| u.max(v)).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
