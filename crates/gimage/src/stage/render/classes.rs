//! Vertices at one place, and the surface that each of them belongs to.
//!
//! Vertices with the same bits of position are one class and get one binding: no crack opens where the source has several vertices for
//! their texture coordinates. The class of a vertex that a piece kept belongs to that piece; others (the inner sheet of a shell, what
//! a repair removed) take the nearest along the edges of the source.

use std::collections::VecDeque;

use super::trace::Trace;
use crate::base::mesh::NONE;

/// The classes of the vertices that are cloth.
pub(super) struct Classes {
    /// For each vertex its class, or [`NONE`] if it is not cloth.
    pub of: Vec<u32>,
    /// For each class its position \[m\].
    pub positions: Vec<[f64; 3]>,
    /// For each class its owner, or [`NONE`].
    pub owner: Vec<u32>,
}

/// The bits of a position; the two zeros are one.
fn bits(p: [f64; 3]) -> [u64; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

impl Classes {
    /// Finds the classes. O(n log n).
    pub fn new(trace: &Trace) -> Self {
        let cloth = |v: &u32| trace.is_cloth[*v as usize];
        let mut order: Vec<u32> = (0..trace.positions.len() as u32).filter(cloth).collect();
        let key = |v: u32| (bits(trace.positions[v as usize]), v);
        order.sort_unstable_by_key(|&v| key(v));
        let mut of = vec![NONE; trace.positions.len()];
        let mut positions = Vec::new();
        for run in order.chunk_by(|&a, &b| key(a).0 == key(b).0) {
            run.iter().for_each(|&v| of[v as usize] = positions.len() as u32);
            positions.push(trace.positions[run[0] as usize]);
        }
        let owner = vec![NONE; positions.len()];
        Classes { of, positions, owner }
    }

    /// Gives the class of a vertex an owner; the least one counts.
    pub fn claim(&mut self, vertex: u32, owner: u32) {
        if let Some(&class) = self.of.get(vertex as usize)
            && let Some(slot) = self.owner.get_mut(class as usize)
        {
            *slot = owner.min(*slot);
        }
    }

    /// Gives classes without an owner that of the nearest one along edges. Classes that no edge joins to an owner keep none. O(n).
    pub fn spread(&mut self, triangles: &[[u32; 3]]) {
        let class = |v: u32| self.of[v as usize];
        let joined: Vec<[u32; 3]> =
            triangles.iter().map(|t| t.map(class)).filter(|t| t.iter().all(|&c| c != NONE)).collect();
        let mut first = vec![0usize; self.positions.len() + 1];
        joined.iter().flatten().for_each(|&c| first[c as usize + 1] += 1);
        (1..first.len()).for_each(|k| first[k] += first[k - 1]);
        let (mut next, mut around) = (first.clone(), vec![0u32; 3 * joined.len()]);
        for (k, t) in joined.iter().enumerate() {
            for &c in t {
                around[next[c as usize]] = k as u32;
                next[c as usize] += 1;
            }
        }
        let mut queue: VecDeque<u32> =
            (0..self.owner.len() as u32).filter(|&c| self.owner[c as usize] != NONE).collect();
        while let Some(c) = queue.pop_front() {
            let owner = self.owner[c as usize];
            for &t in &around[first[c as usize]..first[c as usize + 1]] {
                for other in joined[t as usize] {
                    if self.owner[other as usize] == NONE {
                        self.owner[other as usize] = owner;
                        queue.push_back(other);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_owner_spreads_along_edges_and_not_through_the_air() {
        // A strip of which the last vertex doubles one of another strip, and a vertex that is not cloth.
        let positions: Vec<[f64; 3]> = [0., 1., 2., 3., 3., -0., 9., 0.5].map(|x| [x, 0.0, 0.0]).to_vec();
        let trace = Trace {
            is_cloth: (0..8).map(|v| v != 7).collect(),
            triangles: vec![[0, 1, 2], [1, 2, 3], [6, 6, 6]],
            positions,
            ..Trace::default()
        };
        let mut classes = Classes::new(&trace);
        assert_eq!((classes.of[3], classes.of[0], classes.of[7]), (classes.of[4], classes.of[5], NONE));
        classes.claim(5, 4);
        classes.claim(0, 9);
        classes.claim(7, 1);
        classes.spread(&trace.triangles);
        let owner = |v: usize| classes.owner[classes.of[v] as usize];
        assert_eq!([owner(0), owner(1), owner(4), owner(6)], [4, 4, 4, NONE]);
    }
}
