//! Keeps layers of cloth apart: particles that are not neighbours on the surface push each other away.

use crate::math::{V3, add, norm, scale, sub};
use crate::sew::Spring;

/// The neighbours on the surface that each particle ignores.
pub struct Layers {
    near: Vec<Vec<usize>>,
}

impl Layers {
    /// Takes the edges of the surface.
    pub fn new(edges: &[Spring], particles: usize) -> Self {
        let mut next = vec![Vec::new(); particles];
        for [a, b] in edges.iter().map(|s| s.ends) {
            next[a].push(b);
            next[b].push(a);
        }
        let two_steps = |i: usize| {
            let mut list: Vec<usize> = next[i].iter().flat_map(|&j| next[j].iter().copied().chain([j])).collect();
            list.sort_unstable();
            list.dedup();
            list
        };
        Self { near: (0..particles).map(two_steps).collect() }
    }

    /// Moves particles of different layers to at least `gap` apart.
    pub fn part(&self, x: &mut [V3], weight: &[f64], gap: f64) {
        let cell = |p: V3| p.map(|c| (c / gap).floor() as i32);
        let mut grid: Vec<([i32; 3], usize)> = x.iter().enumerate().map(|(i, &p)| (cell(p), i)).collect();
        grid.sort_unstable();
        for i in 0..x.len() {
            let c = cell(x[i]);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let from = grid.partition_point(|e| e.0 < [c[0] + dx, c[1] + dy, c[2] - 1]);
                let last = [c[0] + dx, c[1] + dy, c[2] + 1];
                for j in grid[from..].iter().take_while(|e| e.0 <= last).map(|e| e.1).filter(|&j| j > i) {
                    self.push(x, weight, gap, i, j);
                }
            }
        }
    }

    fn push(&self, x: &mut [V3], weight: &[f64], gap: f64, i: usize, j: usize) {
        let d = sub(x[j], x[i]);
        let (now, w) = (norm(d), weight[i] + weight[j]);
        if now >= gap || now < 1e-9 || w == 0.0 || self.near[i].binary_search(&j).is_ok() {
            return;
        }
        let by = scale(d, 0.5 * (gap - now) / (now * w));
        x[i] = sub(x[i], scale(by, weight[i]));
        x[j] = add(x[j], scale(by, weight[j]));
    }
}
