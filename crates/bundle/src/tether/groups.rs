//! Connected sets of pinned particles.

use super::SpringGrid;
use crate::disjoint::DisjointSets;
use crate::particle::Particle;
use crate::rings::find_rings;

/// The group of every particle, counted from 0 in the order of their lowest indices, `u32::MAX` where it is not pinned;
/// and how many there are.
pub(super) fn pin_groups(grids: &[SpringGrid<'_>], particles: &[Particle]) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(particles.len());
    let pinned = |k: usize| particles.get(k).is_some_and(|p| p.is_pinned());
    let mut first = 0;
    for grid in grids {
        let (w, h) = (grid.width as usize, grid.height as usize);
        for k in 0..w * h {
            if !pinned(first + k) {
                continue;
            }
            let (i, j) = (k % w, k / w);
            // Right, down-left, down, down-right: each pair of neighbours once.
            let ends = [(i + 1 < w, k + 1), (i > 0 && j + 1 < h, (k + w).saturating_sub(1))];
            let below = [(j + 1 < h, k + w), (i + 1 < w && j + 1 < h, k + w + 1)];
            for (_, end) in ends.into_iter().chain(below).filter(|&(inside, end)| inside && pinned(first + end)) {
                sets.union((first + k) as u32, (first + end) as u32);
            }
        }
        first += w * h;
    }
    for ring in find_rings(particles).0.iter() {
        for pair in ring.windows(2).filter(|pair| pair.iter().all(|&k| pinned(k as usize))) {
            sets.union(pair[0], pair[1]);
        }
    }
    let mut groups = vec![u32::MAX; particles.len()];
    let mut count = 0;
    for k in 0..particles.len() {
        if !pinned(k) {
            continue;
        }
        // Roots are the lowest members, so a root has its number before any other member asks for it.
        let root = sets.find(k as u32) as usize;
        if root == k {
            groups[k] = count;
            count += 1;
        } else {
            groups[k] = groups[root];
        }
    }
    (groups, count as usize)
}
