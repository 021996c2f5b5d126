//! Coarser grids of a cloth, as both backends read them.

pub mod boxes;
pub mod joint;
pub mod links;
pub mod pins;
pub mod safe;
pub mod ties;

use crate::cloth::{Cloth, Grid};
use crate::number::real::Real;

/// A level of one grid.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelGrid<T> {
    /// Nodes in a row.
    pub width: u32,
    /// Rows of nodes.
    pub height: u32,
    /// Longest distances \[m\] to the nodes right, down, down-right and up-right; 0 means no limit.
    pub limits: Vec<[T; 4]>,
    /// 1 / the mass \[1/kg\] of what a node moves; 0 on levels that do not see all pins ([`pins::levels`]), which stay where they are.
    pub inverse_mass: Vec<f32>,
    /// Which of the nodes around it each particle of the grid below follows, as [`links::links`]; empty where that is all.
    pub links: Vec<u8>,
}

impl<T> LevelGrid<T> {
    /// As a grid on its own.
    pub fn grid(&self) -> Grid {
        Grid { name: String::new(), first: 0, width: self.width, height: self.height }
    }
}

/// Share of a displacement that carries no velocity on. With all of it, cloth would fall on behind its limits; with much
/// less, limits would throw it back. Closed cloth, such as a tube, needs more of it: with 0.9 it takes up what limits and
/// springs do against one another, and trembles ever more.
pub fn carried(seams: bool) -> f64 {
    if seams { 0.95 } else { 0.9 }
}

/// The nodes between which column (or row) `k` of `size` lies; twice the same where it is on one.
pub fn span(k: usize, size: usize) -> (usize, usize) {
    if k.is_multiple_of(2) {
        (k / 2, k / 2)
    } else if k + 1 == size {
        (size / 2, size / 2)
    } else {
        (k / 2, k / 2 + 1)
    }
}

/// The nodes around column `i` and row `j`: upper left, upper right, lower left, lower right.
pub fn around(i: usize, j: usize, width: usize, height: usize) -> [(usize, usize); 4] {
    let ((left, right), (above, below)) = (span(i, width), span(j, height));
    [(left, above), (right, above), (left, below), (right, below)]
}

/// The column (or row), of `size`, in which node `n` lies; a node past the last lies there too.
pub fn column(n: usize, size: usize) -> usize {
    (2 * n).min(size - 1)
}

/// Nodes for columns (or rows).
pub fn nodes(size: u32) -> u32 {
    size / 2 + 1
}

/// Most nodes of a level that one workgroup limits: those of its grids together where seams tie them.
pub const MOST_OF_ONE: u32 = 1024;
/// Columns and rows of nodes that a tile of a larger level owns.
pub const NODE_TILE: usize = 22;

/// The finest level, from 1 on, that one workgroup limits, and all coarser ones.
pub fn finest_of_one(cloth: &Cloth) -> u32 {
    let mut sizes: Vec<[u32; 2]> = cloth.grids().iter().map(|g| [g.width, g.height]).collect();
    for level in 1.. {
        // A grid of two nodes on the longer side has no level above.
        sizes.retain(|size| size.iter().any(|n| *n > 2));
        sizes.iter_mut().flatten().for_each(|n| *n = nodes(*n));
        let counts = sizes.iter().map(|[w, h]| w * h);
        if (if cloth.ring_count() > 0 { counts.sum() } else { counts.max().unwrap_or(0) }) <= MOST_OF_ONE {
            return level;
        }
    }
    1
}

/// The levels of a grid that was never cut, finest first, down to two nodes on the longer side; `mass` as [`masses`].
pub fn levels(cloth: &Cloth, index: usize, mass: &[f64]) -> Vec<LevelGrid<f32>> {
    let grid = &cloth.grids()[index];
    let limits = (0..grid.texels()).map(|k| [0, 1, 2, 3].map(|d| cloth.spring(index, k, d)));
    let mass = mass[grid.range()].to_vec();
    let mut levels = Below { width: grid.width, height: grid.height, limits: limits.collect(), mass }.levels(false);
    let blind = levels.iter_mut().skip(cloth.levels_with_pins as usize);
    blind.for_each(|level| level.inverse_mass.fill(0.0));
    levels
}

/// Mass \[kg\] that each particle adds to nodes: 0 if it does not exist, its share of a seam point, else its own.
pub fn masses(cloth: &Cloth) -> Vec<f64> {
    let there = |k: usize| cloth.particles()[k].exists();
    let of = |k: usize| if there(k) { f64::from(cloth.mass(k)) } else { 0.0 };
    let mut all: Vec<f64> = (0..cloth.len()).map(of).collect();
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        ring.iter().for_each(|k| all[*k as usize] /= ring.len() as f64);
    }
    all
}

/// Columns and rows of the levels of a grid, finest first.
pub fn sizes(grid: &Grid) -> impl Iterator<Item = [u32; 2]> + use<> {
    let below = |[w, h]: [u32; 2]| (w.max(h) > 2).then(|| [nodes(w), nodes(h)]);
    std::iter::successors(below([grid.width, grid.height]), move |size| below(*size))
}

/// Most levels of a grid.
pub fn most(cloth: &Cloth) -> u32 {
    cloth.grids().iter().map(|grid| sizes(grid).count() as u32).max().unwrap_or(0)
}

/// Rows of the table of levels (one a grid and one a level), and nodes of all levels.
pub fn rows(cloth: &Cloth) -> (usize, usize) {
    let count = |(rows, count), [w, h]: [u32; 2]| (rows + 1, count + w as usize * h as usize);
    cloth.grids().iter().flat_map(sizes).fold((cloth.grids().len(), 0), count)
}

/// Bytes that a cloth has in lists of coarser grids that shaders only read, at most: its own, and those that its instances share.
pub fn listed(cloth: &Cloth) -> [usize; 2] {
    let (rows, nodes) = rows(cloth);
    // No level has more ties than there are seam rings.
    let ties = if cloth.ring_count() > 0 { most(cloth) as usize * (1 + cloth.ring_count()) } else { 0 };
    [16 * rows, 16 * (nodes + ties)]
}

/// A grid that a coarser one is made of.
pub struct Below<T> {
    pub width: u32,
    pub height: u32,
    /// Rest lengths, or limits \[m\]; 0 is none.
    pub limits: Vec<[T; 4]>,
    pub mass: Vec<f64>,
}

impl<T: Real> Below<T> {
    /// Its levels, finest first. `cut`: particles follow only the nodes that springs still lead to.
    pub fn levels(mut self, cut: bool) -> Vec<LevelGrid<T>> {
        let mut out = Vec::new();
        while self.width.max(self.height) > 2 {
            let links = if cut { links::links(&self) } else { Vec::new() };
            self = self.coarser(&links);
            let inverse = |m: &f64| if *m > 0.0 { (1.0 / m) as f32 } else { 0.0 };
            let (limits, inverse_mass) = (self.limits.clone(), self.mass.iter().map(inverse).collect());
            out.push(LevelGrid { width: self.width, height: self.height, limits, inverse_mass, links });
        }
        out
    }

    fn limit(&self, i: usize, j: usize, d: usize) -> T {
        let (w, h) = (self.width as usize, self.height as usize);
        let inside = match d {
            0 => i + 1 < w && j < h,
            1 => i < w && j + 1 < h,
            2 => i + 1 < w && j + 1 < h,
            _ => i + 1 < w && j > 0 && j < h,
        };
        if inside { self.limits[j * w + i][d] } else { T::of(0.0) }
    }

    /// Along two springs, one after the other; 0 if either is not there.
    fn path(&self, a: [usize; 3], b: [usize; 3]) -> T {
        let limit = |[i, j, d]: [usize; 3]| self.limit(i, j, d);
        let (a, b, zero) = (limit(a), limit(b), T::of(0.0));
        if a > zero && b > zero { a + b } else { zero }
    }

    /// Every other column and row, and the last ones.
    fn coarser(&self, links: &[u8]) -> Self {
        let (w, h) = (self.width as usize, self.height as usize);
        let (width, height) = (nodes(self.width), nodes(self.height));
        let mut limits = Vec::with_capacity((width * height) as usize);
        for (j, i) in (0..height as usize).flat_map(|j| (0..width as usize).map(move |i| (j, i))) {
            let (x, y) = (column(i, w), column(j, h));
            // One or two springs to the next node.
            let (right, down) = (column(i + 1, w) - x, column(j + 1, h) - y);
            let up = y - if j > 0 { column(j - 1, h) } else { y };
            limits.push([
                self.along(x, y, right, 0),
                self.along(x, y, down, 1),
                self.across(x, y, right, down, true),
                self.across(x, y, right, up, false),
            ]);
        }
        let mut mass = vec![0.0; limits.len()];
        for (k, m) in self.mass.iter().enumerate() {
            let follows = links.get(k).copied().unwrap_or(links::ALL);
            let share = m / f64::from(follows.count_ones().max(1));
            for (n, (x, y)) in around(k % w, k / w, w, h).into_iter().enumerate() {
                mass[y * width as usize + x] += if follows >> n & 1 == 1 { share } else { 0.0 };
            }
        }
        Below { width, height, limits, mass }
    }

    fn along(&self, x: usize, y: usize, steps: usize, d: usize) -> T {
        match steps {
            0 => T::of(0.0),
            1 => self.limit(x, y, d),
            _ => self.path([x, y, d], if d == 0 { [x + 1, y, d] } else { [x, y + 1, d] }),
        }
    }

    /// Down-right or up-right over `right` columns and `rows` rows.
    fn across(&self, x: usize, y: usize, right: usize, rows: usize, down: bool) -> T {
        let d = if down { 2 } else { 3 };
        let next = |y: usize| if down { y + 1 } else { y.saturating_sub(1) };
        // A spring down is stored at its upper end.
        let fall = |x: usize, y: usize| [x, if down { y } else { y.saturating_sub(1) }, 1];
        let zero = T::of(0.0);
        let shorter = |a: T, b: T| if a > zero && b > zero { a.min(b) } else { a.max(b) };
        match (right, rows) {
            (0, _) | (_, 0) => zero,
            (1, 1) => self.limit(x, y, d),
            (2, 1) => shorter(self.path([x, y, d], [x + 1, next(y), 0]), self.path([x, y, 0], [x + 1, y, d])),
            (1, 2) => shorter(self.path([x, y, d], fall(x + 1, next(y))), self.path(fall(x, y), [x, next(y), d])),
            _ => self.path([x, y, d], [x + 1, next(y), d]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Flat;

    #[test]
    fn nodes_lie_on_even_columns_and_the_last() {
        assert_eq!([2, 3, 4, 5, 6].map(nodes), [2, 2, 3, 3, 4]);
        assert_eq!((0..4).map(|k| span(k, 4)).collect::<Vec<_>>(), [(0, 0), (0, 1), (1, 1), (2, 2)]);
        assert_eq!((0..5).map(|k| span(k, 5)).collect::<Vec<_>>(), [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2)]);
        assert_eq!((0..2).map(|k| span(k, 2)).collect::<Vec<_>>(), [(0, 0), (1, 1)]);
    }

    #[test]
    fn limits_of_a_flat_square_are_distances_or_more() {
        for n in [5, 8, 11] {
            let cloth = Flat::square("flat", n).cloth().unwrap();
            let h = 1.0 / (n as f32 - 1.0);
            let (mut step, mut before) = (1.0, n);
            for level in levels(&cloth, 0, &masses(&cloth)) {
                step *= 2.0;
                assert_eq!((level.width, level.height), (nodes(before), nodes(before)));
                let of = |i: u32, j: u32| level.limits[(j * level.width + i) as usize];
                let d = of(0, 0);
                if before > 3 {
                    assert!((d[0] - step * h).abs() < 1e-6 && (d[2] - step * h * 2f32.sqrt()).abs() < 1e-6, "{d:?}");
                }
                let at = |i: u32| ((i as f32 * step) * h).min(1.0);
                for (j, i) in (0..level.height).flat_map(|j| (0..level.width).map(move |i| (j, i))) {
                    let far = |di: u32, j2: u32| (at(i + di) - at(i)).hypot(at(j2) - at(j));
                    let right = i + 1 < level.width;
                    let up = j.wrapping_sub(1);
                    let straight = [
                        if right { far(1, j) } else { 0.0 },
                        if j + 1 < level.height { far(0, j + 1) } else { 0.0 },
                        if right && j + 1 < level.height { far(1, j + 1) } else { 0.0 },
                        if right && j > 0 { far(1, up) } else { 0.0 },
                    ];
                    for (limit, straight) in of(i, j).into_iter().zip(straight) {
                        assert!((straight == 0.0) == (limit == 0.0) && limit >= straight - 1e-6, "{limit} {straight}");
                        assert!(limit < 1.4 * straight + 1e-6, "{limit} {straight}");
                    }
                }
                let mass: f32 = level.inverse_mass.iter().map(|w| 1.0 / w).sum();
                assert!((mass - 0.2).abs() < 1e-5, "{mass}");
                before = level.width;
            }
            assert_eq!(before, 2);
        }
    }
}
