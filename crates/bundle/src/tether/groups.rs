//! Connected sets of marked particles.

use crate::disjoint::DisjointSets;

/// The group of every particle, counted from 0 in the order of their lowest indices, `u32::MAX` where it is not marked;
/// and the number of groups. Marked particles that are neighbours in a grid (also diagonally), or members of one of `rings`
/// beside one another, are in one group.
///
/// `sizes` are the widths and heights of the grids, whose particles follow one another. Particles past the end of `marked`
/// count as not marked.
///
/// ```
/// // A grid of 3 x 2 and one of 2 x 2; the last particle of the first is the first of the second.
/// let marked = [true, false, false, false, false, true, true, false, false, false];
/// let (groups, count) = gimage_bundle::groups([[3, 2], [2, 2]], [&[5, 6][..]], &marked);
/// assert_eq!((groups[0], groups[5], groups[6], groups[1], count), (0, 1, 1, u32::MAX, 2));
/// ```
pub fn groups<'a>(
    sizes: impl IntoIterator<Item = [u32; 2]>,
    rings: impl IntoIterator<Item = &'a [u32]>,
    marked: &[bool],
) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(marked.len());
    let is_marked = |k: usize| marked.get(k).copied().unwrap_or(false);
    let mut first = 0;
    for [w, h] in sizes.into_iter().map(|size| size.map(|side| side as usize)) {
        for k in (0..w * h).filter(|k| is_marked(first + k)) {
            let (i, j) = (k % w, k / w);
            // Right, down-left, down, down-right: each pair of neighbours once.
            let ends = [(i + 1 < w, k + 1), (i > 0 && j + 1 < h, (k + w).saturating_sub(1))];
            let below = [(j + 1 < h, k + w), (i + 1 < w && j + 1 < h, k + w + 1)];
            for (_, end) in ends.into_iter().chain(below).filter(|&(inside, end)| inside && is_marked(first + end)) {
                sets.union((first + k) as u32, (first + end) as u32);
            }
        }
        first += w * h;
    }
    for ring in rings {
        for pair in ring.windows(2).filter(|pair| pair.iter().all(|&k| is_marked(k as usize))) {
            sets.union(pair[0], pair[1]);
        }
    }
    let mut groups = vec![u32::MAX; marked.len()];
    let mut count = 0;
    for k in (0..marked.len()).filter(|&k| is_marked(k)) {
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
