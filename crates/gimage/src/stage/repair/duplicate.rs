//! Drops triangles on the same three vertices as another, in either winding: copies, and the back faces of sheets that
//! were doubled to be seen from both sides. The first of them stays.

use std::collections::HashSet;

use super::work::Work;

/// Counts and examples of the dropped triangles.
#[derive(Default)]
pub(super) struct Duplicates {
    pub same: usize,
    pub reversed: usize,
    pub examples: Vec<String>,
    /// Triangles that stayed and had a reversed copy, by their index in the input: a sheet folded flat onto itself, or
    /// one doubled to be seen from both sides.
    pub doubled: HashSet<u32>,
}

/// Drops duplicates; adds to the tally. O(n log n).
pub(super) fn drop_duplicates(work: &mut Work, tally: &mut Duplicates) {
    let mut faces: Vec<([u32; 3], u32)> = (0..work.len() as u32)
        .map(|t| {
            let mut v = work.mesh.triangles[t as usize];
            v.sort_unstable();
            (v, t)
        })
        .collect();
    faces.sort_unstable();
    let mut keep = vec![true; work.len()];
    for run in faces.chunk_by(|x, y| x.0 == y.0).filter(|run| run.len() > 1) {
        let first = run[0].1 as usize;
        for &(_, t) in &run[1..] {
            keep[t as usize] = false;
            let even = even_order(&work.mesh.triangles[first]) == even_order(&work.mesh.triangles[t as usize]);
            if !even {
                tally.doubled.insert(work.source[first]);
            }
            *if even { &mut tally.same } else { &mut tally.reversed } += 1;
            if tally.examples.len() < 4 {
                tally.examples.push(format!("{} on {}", work.triangle_words(t as usize), work.triangle_words(first)));
            }
        }
    }
    work.retain(&keep);
}

/// Whether a rotation of the vertices is ascending.
fn even_order(t: &[u32; 3]) -> bool {
    let swaps = usize::from(t[0] > t[1]) + usize::from(t[1] > t[2]) + usize::from(t[0] > t[2]);
    swaps.is_multiple_of(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;

    #[test]
    fn the_first_stays() {
        let triangles = vec![[0, 1, 2], [1, 3, 2], [2, 0, 1], [2, 1, 0]];
        let mut w = Work::new(Mesh { positions: vec![[0.0; 3]; 4], triangles, ..Default::default() });
        let mut tally = Duplicates::default();
        drop_duplicates(&mut w, &mut tally);
        assert_eq!(w.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!((tally.same, tally.reversed), (1, 1));
        assert_eq!(tally.examples, ["triangle 2 on triangle 0", "triangle 3 on triangle 0"]);
    }
}
