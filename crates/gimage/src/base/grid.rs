//! The geometry image of one piece in memory, before it is written.
//!
//! Gu, Gortler and Hoppe, "Geometry Images", 2002: a grid of surface points, two triangles a quad split by the shorter
//! diagonal. Here the two sides of a cut are linked by rings of duplicates, so that welding needs no tolerance.

use gimage_bundle::DisjointSets;

use crate::base::mesh::NONE;
use crate::base::topology::Topology;
use crate::base::vec3::distance;

/// The image of one piece.
///
/// The parameterisation maps the surface counter-clockwise to (i right, j down) taken as ordinary x and y axes, so the
/// triangles below have the winding of the source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Texel (i, j) at `j * width + i` \[m\].
    pub positions: Vec<[f64; 3]>,
    /// The index of the next duplicate of the same surface point in its ring, or [`NONE`].
    pub links: Vec<u32>,
    /// Whether the particle is pinned.
    pub pinned: Vec<bool>,
}

impl Grid {
    /// A grid without seams or pins.
    pub fn new(width: usize, height: usize, positions: Vec<[f64; 3]>) -> Self {
        let n = positions.len();
        Self { width, height, positions, links: vec![NONE; n], pinned: vec![false; n] }
    }

    /// Whether every array has one entry per texel.
    pub fn is_sized(&self) -> bool {
        let n = self.positions.len();
        self.width.checked_mul(self.height) == Some(n) && self.links.len() == n && self.pinned.len() == n
    }

    /// The position as it will be read back: rounded to f32.
    pub fn stored(&self, k: u32) -> [f64; 3] {
        self.positions[k as usize].map(|x| f64::from(x as f32))
    }

    /// The next duplicate of texel `k`, if it has a valid one.
    fn link(&self, k: usize) -> Option<u32> {
        self.links.get(k).copied().filter(|&l| (l as usize) < self.positions.len() && l as usize != k)
    }

    /// The rings of duplicates, each from its smallest member along its links, in the order of that member.
    pub fn rings(&self) -> impl Iterator<Item = Vec<u32>> + '_ {
        let mut seen = vec![false; self.positions.len()];
        (0..self.positions.len()).filter_map(move |start| {
            if seen[start] {
                return None;
            }
            let (mut ring, mut k) = (Vec::new(), Some(start as u32));
            while let Some(x) = k.filter(|&x| !seen[x as usize]) {
                seen[x as usize] = true;
                ring.push(x);
                k = self.link(x as usize);
            }
            (ring.len() > 1).then_some(ring)
        })
    }

    /// Whether following the links from any texel that has one leads back to it.
    pub fn rings_are_closed(&self) -> bool {
        let mut incoming = vec![0u32; self.positions.len()];
        for k in 0..self.positions.len() {
            match self.link(k) {
                Some(l) => incoming[l as usize] += 1,
                None if self.links.get(k).is_none_or(|&l| l == NONE) => {}
                None => return false,
            }
        }
        // Out-degree and in-degree one everywhere make a permutation, whose cycles are the rings.
        (0..self.positions.len()).all(|k| incoming[k] == u32::from(self.link(k).is_some()))
    }

    /// For each texel the smallest index among its duplicates: itself for an ordinary one.
    pub fn representative(&self) -> Vec<u32> {
        let mut sets = DisjointSets::new(self.positions.len());
        for k in 0..self.positions.len() {
            if let Some(l) = self.link(k) {
                sets.union(k as u32, l);
            }
        }
        sets.into_representatives()
    }

    /// Two triangles per quad, split along its shorter diagonal, measured on the stored positions; a tie goes to the one from
    /// (i, j) to (i+1, j+1). Quads row by row.
    pub fn triangulate(&self) -> Vec<[u32; 3]> {
        if !self.is_sized() || self.width < 2 || self.height < 2 {
            return Vec::new();
        }
        let w = self.width as u32;
        let mut out = Vec::with_capacity(2 * (self.width - 1) * (self.height - 1));
        for j in 0..self.height as u32 - 1 {
            for i in 0..w - 1 {
                let a = j * w + i;
                let (b, c, d) = (a + 1, a + w + 1, a + w);
                out.extend(split(a, b, c, d, |k| self.stored(k)));
            }
        }
        out
    }

    /// The surface with duplicates merged: stored positions and triangles. Triangles that collapse are left out, and so
    /// are vertices that no triangle uses.
    pub fn welded(&self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        welded(&[self], &[])
    }

    /// The topology of the welded surface.
    pub fn check(&self) -> Topology {
        Topology::of(&self.welded().1)
    }
}

/// Where the texels of each grid begin among those of all, and for each texel of all the first of its duplicates. `rings`
/// join texels of several grids as (grid, texel).
pub(crate) fn representatives(grids: &[&Grid], rings: &[Vec<(u32, u32)>]) -> (Vec<usize>, Vec<u32>) {
    let mut first = Vec::with_capacity(grids.len());
    let mut total = 0;
    for grid in grids {
        first.push(total);
        total += grid.positions.len();
    }
    let mut sets = DisjointSets::new(total);
    for (grid, &first) in grids.iter().zip(&first) {
        for k in 0..grid.positions.len() {
            if let Some(l) = grid.link(k) {
                sets.union((first + k) as u32, first as u32 + l);
            }
        }
    }
    for ring in rings {
        let index = |(p, at): (u32, u32)| first[p as usize] as u32 + at;
        for x in ring.windows(2) {
            sets.union(index(x[0]), index(x[1]));
        }
    }
    (first, sets.into_representatives())
}

/// The surface of several grids with duplicates merged: stored positions and triangles, grid after grid. Triangles that
/// collapse are left out, and so are vertices that no triangle uses.
pub(crate) fn welded(grids: &[&Grid], rings: &[Vec<(u32, u32)>]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (first, representative) = representatives(grids, rings);
    let mut index = vec![NONE; representative.len()];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (grid, &offset) in grids.iter().zip(&first) {
        for t in grid.triangulate() {
            let t = t.map(|k| representative[offset + k as usize]);
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            triangles.push(t.map(|k| {
                let slot = &mut index[k as usize];
                if *slot == NONE {
                    *slot = positions.len() as u32;
                    let home = first.partition_point(|&f| f <= k as usize) - 1;
                    positions.push(grids[home].stored(k - first[home] as u32));
                }
                *slot
            }));
        }
    }
    (positions, triangles)
}

/// The two triangles of quad a = (i, j), b = (i+1, j), c = (i+1, j+1), d = (i, j+1).
pub(crate) fn split(a: u32, b: u32, c: u32, d: u32, at: impl Fn(u32) -> [f64; 3]) -> [[u32; 3]; 2] {
    if distance(at(a), at(c)) <= distance(at(b), at(d)) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

#[cfg(test)]
pub(crate) mod samples {
    use super::*;
    use std::f64::consts::TAU;

    /// A grid of `f(u, v)` for u, v in 0..=1.
    pub(crate) fn grid(w: usize, h: usize, f: impl Fn(f64, f64) -> [f64; 3]) -> Grid {
        let at = |k: usize, n: usize| k as f64 / (n - 1) as f64;
        let positions = (0..w * h).map(|k| f(at(k % w, w), at(k / w, h))).collect();
        Grid::new(w, h, positions)
    }

    /// Links each group of texels to a ring; all take the position of the first.
    pub(crate) fn link(g: &mut Grid, groups: impl IntoIterator<Item = Vec<usize>>) {
        for ring in groups {
            for (n, &k) in ring.iter().enumerate() {
                g.links[k] = ring[(n + 1) % ring.len()] as u32;
                g.positions[k] = g.positions[ring[0]];
            }
        }
    }

    pub(crate) fn cylinder(w: usize, h: usize, radius: f64, height: f64) -> Grid {
        let mut g = grid(w, h, |u, v| [radius * (TAU * u).cos(), height * v, radius * (TAU * u).sin()]);
        link(&mut g, (0..h).map(|j| vec![j * w, j * w + w - 1]));
        g
    }

    pub(crate) fn torus(n: usize, m: usize) -> Grid {
        let mut g = grid(n, m, |u, v| {
            let r = 1.0 + 0.4 * (TAU * v).cos();
            [r * (TAU * u).cos(), 0.4 * (TAU * v).sin(), r * (TAU * u).sin()]
        });
        let corners = vec![0, n - 1, n * m - 1, n * (m - 1)];
        let sides = (1..m - 1).map(|j| vec![j * n, j * n + n - 1]);
        let rows = (1..n - 1).map(|i| vec![i, (m - 1) * n + i]);
        link(&mut g, std::iter::once(corners).chain(sides).chain(rows));
        g
    }

    /// A sphere cut along a path: the border of the image folds about the middles of the left and right sides, texel
    /// (i, 0) onto (i, h-1) and (0, j) onto (0, h-1-j). `h` odd.
    pub(crate) fn sphere(w: usize, h: usize) -> Grid {
        // An envelope: a flattened disk folded over is puffed up to a ball.
        let mut g = grid(w, h, |u, v| {
            let (lat, lon) = ((u - 0.5) * 3.0, TAU * v);
            [lat.sin(), lat.cos() * lon.cos(), lat.cos() * lon.sin()]
        });
        let rows = (0..w).map(|i| vec![i, (h - 1) * w + i]);
        let sides = [0, w - 1].into_iter().flat_map(|i| (1..h / 2).map(move |j| vec![j * w + i, (h - 1 - j) * w + i]));
        link(&mut g, rows.chain(sides).collect::<Vec<_>>());
        g
    }
}

#[cfg(test)]
mod tests {
    use super::samples::*;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn seams_give_the_surface_its_own_topology() {
        for (name, g, euler, loops) in [
            ("flat", grid(5, 4, |u, v| [u, v, 0.0]), 1, 1),
            ("cylinder", cylinder(9, 5, 1.0, 2.0), 0, 2),
            ("torus", torus(9, 7), 0, 0),
            ("sphere", sphere(9, 11), 2, 0),
        ] {
            let t = g.check();
            assert_eq!((t.euler, t.boundary_loops, t.components), (euler, loops, 1), "{name}");
            assert!(t.is_oriented_manifold(), "{name}: {t:?}");
            assert!(g.rings_are_closed(), "{name}");
        }
    }

    #[test]
    fn the_corners_of_a_torus_are_one_ring_of_four() {
        let g = torus(5, 4);
        let rings: Vec<_> = g.rings().collect();
        assert_eq!(rings[0], vec![0, 4, 19, 15]);
        assert_eq!(rings.len(), 1 + 3 + 2);
        assert!(g.representative()[19] == 0 && g.representative()[7] == 7);
    }

    #[test]
    fn a_tie_takes_the_main_diagonal_and_winding_is_kept() {
        let g = grid(2, 2, |u, v| [u, v, 0.0]);
        assert_eq!(g.triangulate(), vec![[0, 1, 2 + 1], [0, 3, 2]]);
        let skew = grid(2, 2, |u, v| [u + v, v, 0.0]);
        assert_eq!(skew.triangulate(), vec![[0, 1, 2], [1, 3, 2]]);
    }

    #[test]
    fn broken_links_are_reported_not_followed_for_ever() {
        let mut g = grid(3, 2, |u, v| [u, v, 0.0]);
        g.links = vec![1, 2, 1, NONE, NONE, 77];
        assert!(!g.rings_are_closed());
        assert_eq!(g.rings().collect::<Vec<_>>(), vec![vec![0, 1, 2]]);
        g.positions.pop();
        assert!(g.triangulate().is_empty());
        assert_eq!(Grid::default().check(), Topology::default());
    }

    proptest! {
        #[test]
        fn any_links_are_survived(links in prop::collection::vec(0u32..40, 30), x in prop::collection::vec(-1e300..1e300, 30)) {
            let mut g = Grid::new(6, 5, x.into_iter().map(|x| [x, 0.5, -x]).collect());
            g.links = links;
            let covered: usize = g.rings().map(|r| r.len()).sum();
            prop_assert!(covered <= 30);
            let _ = (g.rings_are_closed(), g.check());
        }
    }
}
