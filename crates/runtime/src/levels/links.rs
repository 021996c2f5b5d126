//! Which nodes a particle still follows after a cut.
//!
//! A displacement is not to be carried across a cut. A particle follows a node beside it while springs that are left lead
//! there, at most three and all of the cells at the straight way between them. The spring itself is not asked for alone: a
//! cut takes the springs on its edges too, where the cloth still holds. All remaining nodes count alike, so that
//! what moves as a whole goes on doing so, and nodes have the mass of what follows them, so that momentum stays.

use super::{Below, around, column};
use crate::number::real::Real;

/// All four.
pub const ALL: u8 = 15;

/// For every particle (or node) of a grid, which of the four nodes [`around`] it on the next level it follows: a bit each.
pub fn links<T: Real>(grid: &Below<T>) -> Vec<u8> {
    let (w, h) = (grid.width as usize, grid.height as usize);
    let of = |k: usize| {
        let (i, j) = (k % w, k / w);
        let follows = |(x, y): (usize, usize)| {
            let by = |node: usize, at: usize, size: usize| column(node, size) as i32 - at as i32;
            reaches(grid, (i as i32, j as i32), (by(x, i, w), by(y, j, h)))
        };
        let nodes = around(i, j, w, h).into_iter().enumerate();
        nodes.fold(0, |bits, (n, node)| bits | u8::from(follows(node)) << n)
    };
    (0..w * h).map(of).collect()
}

/// Whether springs lead from a place to a neighbour.
fn reaches<T: Real>(grid: &Below<T>, (x, y): (i32, i32), (dx, dy): (i32, i32)) -> bool {
    let joined = |x: i32, y: i32, dx: i32, dy: i32| joined(grid, (x, y), (dx, dy));
    if (dx == 0 && dy == 0) || joined(x, y, dx, dy) {
        return true;
    }
    if dx != 0 && dy != 0 {
        return (joined(x, y, dx, 0) && joined(x + dx, y, 0, dy)) || (joined(x, y, 0, dy) && joined(x, y + dy, dx, 0));
    }
    // By way of the cells on either side.
    [1, -1].into_iter().any(|s| {
        let (px, py) = (s * dy, s * dx);
        let (here, there) = (joined(x, y, px, py), joined(x + dx, y + dy, px, py));
        (here && joined(x + px, y + py, dx - px, dy - py))
            || (there && joined(x, y, dx + px, dy + py))
            || (here && there && joined(x + px, y + py, dx, dy))
    })
}

/// Whether there is a spring from a place by one step.
fn joined<T: Real>(grid: &Below<T>, (x, y): (i32, i32), (dx, dy): (i32, i32)) -> bool {
    // Springs are stored at their left end, those down at their upper one.
    let back = dx < 0 || (dx == 0 && dy < 0);
    let (x, y, dx, dy) = if back { (x + dx, y + dy, -dx, -dy) } else { (x, y, dx, dy) };
    let direction = match (dx, dy) {
        (1, 0) => 0,
        (0, _) => 1,
        (_, 1) => 2,
        _ => 3,
    };
    x >= 0 && y >= 0 && grid.limit(x as usize, y as usize, direction) > T::of(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square whose springs from row 3 to row 4 are cut, and those along both.
    fn grid(n: u32, cut: bool) -> Below<f64> {
        let gone = |j: u32| if cut { [j == 3 || j == 4, j == 3, j == 3, j == 4] } else { [false; 4] };
        let limits = (0..n * n).map(|k| gone(k / n).map(|gone| if gone { 0.0 } else { 1.0 })).collect();
        Below { width: n, height: n, limits, mass: vec![1.0; (n * n) as usize] }
    }

    #[test]
    fn whole_cloth_follows_all_nodes() {
        for n in [2, 3, 8, 9, 12] {
            assert!(links(&grid(n, false)).iter().all(|l| *l == ALL), "{n}");
            let (cut, plain) = (grid(n, false).levels(true), grid(n, false).levels(false));
            let same = |(a, b): (&super::super::LevelGrid<f64>, &super::super::LevelGrid<f64>)| {
                a.limits == b.limits && a.inverse_mass == b.inverse_mass
            };
            assert!(cut.iter().zip(&plain).all(same), "{n}");
        }
    }

    #[test]
    fn nothing_follows_a_node_across_a_cut() {
        let grid = grid(9, true);
        // Row 3 lies between nodes in rows 2 and 4, and follows the upper ones; row 4 has nodes of its own.
        let links = links(&grid);
        for i in 0..9 {
            assert_eq!((links[3 * 9 + i], links[4 * 9 + i], links[5 * 9 + i]), (3, ALL, ALL), "{i}");
        }
        let levels = grid.levels(true);
        for (n, level) in levels.iter().enumerate() {
            let mass: f64 = level.inverse_mass.iter().map(|w| 1.0 / f64::from(*w)).sum();
            assert!((mass - 81.0).abs() < 1e-4, "level {n}: {mass}");
            let rows = level.height as usize - 1;
            for (k, limits) in level.limits.iter().enumerate() {
                let (i, j) = (k % level.width as usize, k / level.width as usize);
                // The nodes below the cut are those from row 4 of the grid on.
                let edge = 4usize.div_ceil(2 << n);
                let crosses = [false, j + 1 == edge, j + 1 == edge, j == edge && i < level.width as usize - 1];
                assert!((0..4).all(|d| !crosses[d] || limits[d] == 0.0), "level {n}, node {k}: {limits:?}");
                assert!(j >= rows || j + 1 == edge || limits[1] > 0.0, "level {n}, node {k}: {limits:?}");
            }
        }
    }
}
