//! Grids that nothing holds.

use gimage_bundle::DisjointSets;

use super::Cloth;

impl Cloth {
    /// The grids that hang together with no pinned or limited particle, by seams or stitches, while other grids do: they fall out of
    /// the garment. Empty for cloth without pins.
    pub fn loose_grids(&self) -> Vec<usize> {
        let group = self.joined_grids();
        let limited = |k: usize| self.limits.as_ref().is_some_and(|limits| limits[k] >= 0.0);
        let holds = |k: usize| self.particles()[k].is_pinned() || (self.particles()[k].exists() && limited(k));
        let mut held = vec![false; group.len()];
        for (grid, group) in self.grids().iter().zip(&group) {
            held[*group as usize] |= grid.range().any(holds);
        }
        let any = held.contains(&true);
        (0..group.len()).filter(|g| any && !held[group[*g] as usize]).collect()
    }

    /// For every grid the lowest one that seams and stitches join with it.
    pub(crate) fn joined_grids(&self) -> Vec<u32> {
        let grid_of = |k: u32| self.grids().partition_point(|g| g.first <= k) as u32 - 1;
        let mut sets = DisjointSets::new(self.grids().len());
        let (starts, members) = self.rings();
        for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
            ring.iter().for_each(|k| _ = sets.union(grid_of(*k), grid_of(ring[0])));
        }
        for thread in self.sewing().into_iter().flat_map(|s| &s.threads) {
            sets.union(grid_of(thread.ends[0]), grid_of(thread.ends[4]));
        }
        sets.into_representatives()
    }
}
