//! Which coarser grids of a cloth have its pins.

use std::collections::BTreeMap;

use super::sizes;
use crate::cloth::{Cloth, of_pins};

/// Cells along a side of a grid that carries cloth: with 4, sheets of 64 and 128 columns hung from two points away from their corners stretch
/// less at p99 than with twice the substeps and no pyramid; with 8, more.
const MOST_CELLS: f64 = 4.0;

/// How many coarser grids, from the finest on, have a node at a pin of every group of pins, in each grid of the cloth that the group
/// reaches; `u32::MAX` without pins. Coarser ones would pull a group as if it was free. Takes time linear in the particles.
pub fn levels(cloth: &Cloth) -> u32 {
    let (group, count) = of_pins(cloth);
    if count == 0 {
        return u32::MAX;
    }
    let mut best: BTreeMap<(usize, u32), u32> = BTreeMap::new();
    for (index, grid) in cloth.grids().iter().enumerate() {
        let all = sizes(grid).count() as u32;
        for (k, group) in group[grid.range()].iter().enumerate().filter(|(_, g)| **g != u32::MAX) {
            let (i, j) = (k as u32 % grid.width, k as u32 / grid.width);
            let has = on_levels(i, grid.width).min(on_levels(j, grid.height)).min(all);
            // A grid without as many levels has no node there to go wrong.
            let has = if has == all { u32::MAX } else { has };
            best.entry((index, *group)).and_modify(|most| *most = has.max(*most)).or_insert(has);
        }
    }
    best.into_values().min().unwrap_or(u32::MAX)
}

/// Whether the coarsest of them carries the weight of cloth with `n` particles along a side, in place of further substeps: grids of more than
/// a few cells leave it to the springs.
pub fn carry(cloth: &Cloth, n: f64) -> bool {
    n <= MOST_CELLS * 2f64.powi(levels(cloth).min(32) as i32)
}

/// How many levels have a node in column (or row) `k` of `size`: those whose step divides it; the last one is on all.
fn on_levels(k: u32, size: u32) -> u32 {
    if k == 0 || k + 1 == size { u32::MAX } else { k.trailing_zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Flat;

    fn seen(n: u32, pins: &[[u32; 2]]) -> u32 {
        let mut cloth = Flat::square("flat", n).cloth().unwrap();
        pins.iter().for_each(|[i, j]| cloth.set_pinned((j * n + i) as usize, true).unwrap());
        levels(&cloth)
    }

    #[test]
    fn levels_end_where_a_group_of_pins_lies_between_their_nodes() {
        assert_eq!(seen(17, &[]), u32::MAX);
        // Corners are nodes of all levels, and so is a row.
        assert_eq!(seen(16, &[[0, 0], [15, 0], [15, 15]]), u32::MAX);
        assert_eq!(seen(16, &std::array::from_fn::<_, 16, _>(|i| [i as u32, 0])), u32::MAX);
        assert_eq!([[4, 0], [12, 8], [6, 6], [5, 4], [8, 8]].map(|pin| seen(33, &[pin])), [2, 2, 1, 0, 3]);
        // A group that has an even column is seen, each group counts, and pins of one column are a group.
        assert_eq!(seen(33, &[[5, 4], [6, 4]]), 1);
        assert_eq!(seen(33, &[[8, 8], [16, 9]]), 0);
        assert_eq!(seen(33, &[[16, 7], [16, 8]]), 3);
    }
}
