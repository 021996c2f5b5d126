//! How far a garment stretches.

use gimage_runtime::{Cloth, Rest};

/// Largest mean, 99th percentile and largest extension of the structural springs over the frames, and the lowest height
/// \[m\] that the topmost particle had.
#[derive(Clone, Copy, Debug)]
pub struct Worst {
    extension: [f64; 3],
    top: f64,
}

impl Default for Worst {
    fn default() -> Self {
        Worst { extension: [0.0; 3], top: f64::INFINITY }
    }
}

impl Worst {
    /// Takes in a frame.
    pub fn take(&mut self, cloth: &Cloth, now: &[[f64; 4]]) {
        let mut all = Vec::new();
        for (g, grid) in cloth.grids().iter().enumerate() {
            let width = grid.width as usize;
            for (local, k) in grid.range().enumerate() {
                let inside = [local % width + 1 < width, local + width < grid.texels()];
                for (d, other) in [(0, k + 1), (1, k + width)] {
                    let rest = match cloth.rest() {
                        Rest::None => 0.0,
                        Rest::Constant(r) => r[g][d],
                        Rest::Image(r) => r[k][d],
                    };
                    if inside[d] && rest > 0.0 {
                        let far = (0..3).map(|c| (now[k][c] - now[other][c]).powi(2)).sum::<f64>().sqrt();
                        all.push((far / f64::from(rest) - 1.0).max(0.0));
                    }
                }
            }
        }
        all.sort_by(f64::total_cmp);
        let count = all.len().max(1);
        let at = |share: f64| all.get(((count - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
        let figures = [all.iter().sum::<f64>() / count as f64, at(0.99), at(1.0)];
        self.extension = [0, 1, 2].map(|k| self.extension[k].max(figures[k]));
        let real = now.iter().filter(|p| p[3] >= 0.0);
        self.top = self.top.min(real.map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max));
    }

    /// Its columns of the table.
    pub fn columns(&self) -> String {
        let [mean, p99, max] = self.extension;
        format!("{mean:.5},{p99:.5},{max:.5},{:.4}", self.top)
    }
}
