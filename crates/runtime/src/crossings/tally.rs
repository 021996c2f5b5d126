//! Counts of crossing pairs and the deepest of them, which do not depend on how the pairs are shared out among threads.

use super::depth::depth;
use super::exact::{Meeting, meet};
use super::mesh::Mesh;
use super::tree::Tree;
use super::{Crossing, Drawn};

/// Leaves that one thread takes at a time.
const CHUNK: usize = 256;

/// Two triangles that cross, by number, the lower first.
#[derive(Clone, Copy)]
pub struct Pair {
    triangles: [u32; 2],
    depth: f64,
}

impl Pair {
    /// The pair by places.
    pub fn crossing(&self, mesh: &Mesh, cloths: &[Drawn]) -> Crossing {
        let [first, second] = self.triangles.map(|t| mesh.place(t, cloths));
        Crossing { first, second, depth: self.depth }
    }
}

/// Counts.
#[derive(Default)]
pub struct Tally {
    /// Crossing pairs of one cloth.
    pub within: u64,
    /// Crossing pairs of two cloths.
    pub between: u64,
    /// Pairs that touch.
    pub touching: u64,
    /// Pairs with all corners in common.
    pub double: u64,
    /// The largest depth \[m\].
    pub deepest: f64,
    /// The deepest pairs.
    pub worst: Vec<Pair>,
}

impl Tally {
    /// Counts all pairs, and lists at most `worst` of them.
    pub fn of(mesh: &Mesh, tree: &Tree, worst: usize) -> Self {
        let count = |chunk: usize| {
            let leaves = chunk * CHUNK..tree.leaves().min((chunk + 1) * CHUNK);
            let mut tally = Tally::default();
            leaves.for_each(|leaf| tree.pairs(leaf, |a, b| tally.take(mesh, [a.min(b), a.max(b)], worst)));
            tally.cut(worst);
            tally
        };
        let chunks = tree.leaves().div_ceil(CHUNK);
        #[cfg(feature = "threads")]
        let tallies: Vec<Tally> = {
            use rayon::prelude::*;
            (0..chunks).into_par_iter().map(count).collect()
        };
        #[cfg(not(feature = "threads"))]
        let tallies: Vec<Tally> = (0..chunks).map(count).collect();
        let mut sum = Tally::default();
        for tally in tallies {
            sum.within += tally.within;
            sum.between += tally.between;
            sum.touching += tally.touching;
            sum.double += tally.double;
            sum.deepest = sum.deepest.max(tally.deepest);
            sum.worst.extend(tally.worst);
            sum.cut(worst);
        }
        sum
    }

    fn take(&mut self, mesh: &Mesh, triangles: [u32; 2], worst: usize) {
        let [a, b] = triangles.map(|t| mesh.facet(t));
        match meet(&a, &b) {
            Meeting::Apart => return,
            Meeting::Touching => {
                self.touching += 1;
                return;
            }
            Meeting::Double => {
                self.double += 1;
                return;
            }
            Meeting::Crossing => {}
        }
        let [one, other] = triangles.map(|t| mesh.cloth(t));
        *(if one == other { &mut self.within } else { &mut self.between }) += 1;
        let depth = depth(&a.corners, &b.corners);
        self.deepest = self.deepest.max(depth);
        self.worst.push(Pair { triangles, depth });
        if self.worst.len() >= worst.saturating_mul(2).max(1024) {
            self.cut(worst);
        }
    }

    /// Keeps the deepest pairs, by falling depth; pairs of one depth in the order of their triangles.
    fn cut(&mut self, worst: usize) {
        self.worst.sort_unstable_by(|a, b| b.depth.total_cmp(&a.depth).then(a.triangles.cmp(&b.triangles)));
        self.worst.truncate(worst);
    }
}
