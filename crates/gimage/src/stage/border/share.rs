//! Whole steps of the image's border for every path of a disk's boundary.

use super::{Border, Group};
use crate::stage::cut::disk::Disk;

/// Length that a boundary edge counts for at least, as a share of the mean edge of its path: as thin as triangles at rest
/// are taken for (`distortion::rest_shapes`), a tenth, so that the map is not asked for thinner ones.
const SHORTEST_EDGE: f64 = 1e-4;

/// A path of a disk's loop, from node to node.
#[derive(Clone, Debug)]
pub(crate) struct LoopPath {
    /// Paths of one group have equal counts.
    pub group: usize,
    /// Whether it is a cut, not a part of the surface's own boundary.
    pub cut: bool,
    /// The disk's vertices along it, both ends included.
    pub vertices: Vec<u32>,
}

impl Border {
    /// The fewest border steps that can hold this boundary: even, at least 8.
    pub(crate) fn least_steps(&self) -> u32 {
        let sum: u32 = self.groups.iter().map(|g| g.members * g.least).sum();
        sum.max(8).next_multiple_of(2)
    }

    /// The border steps that this boundary has whatever the image, if all of its counts are fixed.
    pub(crate) fn exact_steps(&self) -> Option<u32> {
        self.groups.iter().map(|g| g.fixed.map(|c| g.members * c)).sum()
    }

    /// The boundary has no node on it.
    pub(crate) fn is_free(&self) -> bool {
        self.free
    }

    /// Steps for each group, `steps` (even) in all. `None` if they cannot be shared out.
    pub(crate) fn share(&self, steps: u32) -> Option<Vec<u32>> {
        if self.free {
            return Some(vec![steps]);
        }
        // Paths with a fixed count keep it; the others share the rest by length.
        let length = |g: &Group| if g.fixed.is_some() { 0.0 } else { g.length };
        let total: f64 = self.groups.iter().map(|g| length(g) * f64::from(g.members)).sum();
        let fixed: u32 = self.groups.iter().filter_map(|g| g.fixed.map(|c| g.members * c)).sum();
        let free = f64::from(steps.checked_sub(fixed)?);
        let share = |g: &Group| g.fixed.map_or(length(g) / total.max(1e-300) * free, f64::from);
        let want: Vec<f64> = self.groups.iter().map(share).collect();
        let mut count: Vec<u32> = self.groups.iter().zip(&want).map(|(g, w)| (w.floor() as u32).max(g.least)).collect();
        let mut rest =
            i64::from(steps) - self.groups.iter().zip(&count).map(|(g, c)| i64::from(g.members * c)).sum::<i64>();
        let mut budget = 4 * steps as usize + 16;
        while rest != 0 {
            budget = budget.checked_sub(1)?;
            let mut best: Option<(f64, usize, i64)> = None;
            for (i, g) in self.groups.iter().enumerate() {
                if g.fixed.is_some() {
                    continue;
                }
                let step = rest.signum();
                let m = i64::from(g.members);
                let new = i64::from(count[i]) + step;
                // One step too many on a path of two sides is a way out of an odd rest, where no single side can give.
                if m > rest.abs().max(2) || (m == 2 && rest.abs() == 1 && best.is_some()) || new < i64::from(g.least) {
                    continue;
                }
                let penalty = if m > rest.abs() { 1e6 } else { 0.0 };
                let cost = (want[i] - new as f64).abs() - (want[i] - f64::from(count[i])).abs() + penalty;
                if best.is_none_or(|b| cost < b.0) {
                    best = Some((cost, i, step));
                }
            }
            let (_, i, step) = best?;
            count[i] = (i64::from(count[i]) + step) as u32;
            rest -= step * i64::from(self.groups[i].members);
        }
        Some(count)
    }

    /// Fixes the count of a group, or only raises its least count.
    pub(crate) fn fix(&mut self, group: usize, least: u32, count: Option<u32>) {
        let g = &mut self.groups[group];
        (g.least, g.fixed) = (count.unwrap_or(least.max(g.least)), count);
    }

    /// The paths of the loop in its order.
    pub(crate) fn paths(&self, disk: &Disk) -> Vec<LoopPath> {
        let n = disk.boundary.len();
        let path = |s: &super::Segment| LoopPath {
            group: s.group,
            cut: disk.on_cut[s.first],
            vertices: (s.first..=s.first + s.edges).map(|i| disk.boundary[i % n]).collect(),
        };
        self.segments.iter().map(path).collect()
    }

    /// For each loop vertex, its place along the border in steps from the start of the loop.
    pub(crate) fn along(&self, disk: &Disk, count: &[u32]) -> Vec<f64> {
        let n = disk.boundary.len();
        let mut along = vec![0.0; n];
        let mut base = 0.0;
        for s in &self.segments {
            let edge: Vec<f64> = (s.first..s.first + s.edges)
                .map(|i| disk.length(disk.boundary[i % n], disk.boundary[(i + 1) % n]))
                .collect();
            // Keep very short edges from falling into one point, edges too short for f64 as well.
            let mean = edge.iter().sum::<f64>() / edge.len() as f64;
            let edge = if mean > 1e-290 { edge } else { vec![1.0; s.edges] };
            let floor = SHORTEST_EDGE * edge.iter().sum::<f64>() / edge.len() as f64;
            let total: f64 = edge.iter().map(|l| l.max(floor)).sum();
            let (steps, mut done) = (f64::from(count[s.group]), 0.0);
            for (k, l) in edge.iter().enumerate() {
                along[s.first + k] = base + steps * done / total.max(1e-300);
                done += l.max(floor);
            }
            base += steps;
        }
        along
    }

    /// Steps at which the two sides of a dead end of the cut meet; an image corner there would be a folded quad.
    pub(crate) fn dead_ends(&self, count: &[u32]) -> Vec<u32> {
        let mut out = Vec::new();
        let mut base = 0;
        for (k, s) in self.segments.iter().enumerate() {
            let before = &self.segments[(k + self.segments.len() - 1) % self.segments.len()];
            if self.groups[s.group].members == 2 && before.group == s.group && before.reversed != s.reversed {
                out.push(base);
            }
            base += count[s.group];
        }
        out
    }

    /// Where in the loop, in steps, the nodes are.
    pub(crate) fn node_steps(&self, count: &[u32]) -> Vec<u32> {
        let mut base = 0;
        let mut out = Vec::with_capacity(self.segments.len());
        for s in &self.segments {
            out.push(base);
            base += count[s.group];
        }
        out
    }

    /// The shares of a boundary of four paths that are to be the four sides of a `w` x `h` rectangle, the first of them
    /// `w` long (or `h`, if `turned`). `None` where there are not four, or where mates would differ.
    pub(crate) fn four_sides(&self, w: u32, h: u32, turned: bool) -> Option<Vec<u32>> {
        if self.free || self.segments.len() != 4 {
            return None;
        }
        let mut count = vec![0; self.groups.len()];
        for (k, s) in self.segments.iter().enumerate() {
            let side = if (k % 2 == 0) != turned { w } else { h };
            if self.groups[s.group].fixed.is_some_and(|c| c != side) {
                return None;
            }
            if count[s.group] != 0 && count[s.group] != side || side < self.groups[s.group].least {
                return None;
            }
            count[s.group] = side;
        }
        Some(count)
    }
}
