//! Makes sure that welding the image gives back the surface's own topology.
//!
//! Where the cut ends, the texels on both sides of its last one are duplicates, and if the shorter diagonals of two
//! neighbouring quads both lead from them to the same inner texel, welding puts four triangles on that edge. Such an
//! inner texel is sampled a fraction of a texel further in, on the surface still, until the diagonals part.

use crate::disk::Disk;
use crate::grid::Grid;
use crate::halfedge::sorted_edges;
use crate::locate::Locator;
use crate::resample::Sample;
use crate::topology::Topology;

/// What the image of a surface must weld to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Expected {
    /// Vertices - edges + triangles.
    pub euler: i64,
    /// Boundary loops.
    pub loops: usize,
}

impl Expected {
    /// Whether a welded image is that surface.
    pub(crate) fn met(&self, t: &Topology) -> bool {
        t.euler == self.euler
            && t.boundary_loops == self.loops
            && t.components == 1
            && t.non_manifold_edges == 0
            && t.singular_vertices == 0
    }
}

/// How far in a texel may be moved, in texels, and in how many steps.
const REACH: f64 = 0.75;
const STEPS: usize = 5;

/// Texels that lie inside the image and on an over-full welded edge, or next to one whose ends both lie on the border.
fn culprits(grid: &Grid) -> Vec<usize> {
    let representative = grid.representative();
    let triangles = grid.triangulate();
    let mut kept: Vec<usize> = Vec::new();
    let mut welded = Vec::new();
    for (k, t) in triangles.iter().enumerate() {
        let w = t.map(|x| representative[x as usize]);
        if w[0] != w[1] && w[1] != w[2] && w[2] != w[0] {
            kept.push(k);
            welded.push(w);
        }
    }
    let mut out = Vec::new();
    for run in sorted_edges(&welded).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|r| r.len() > 2) {
        let ends = [run[0].0, run[0].1];
        let inner = |x: u32| {
            let (i, j) = (x as usize % grid.width, x as usize / grid.width);
            i > 0 && j > 0 && i + 1 < grid.width && j + 1 < grid.height
        };
        let mut found: Vec<usize> = ends.into_iter().filter(|&x| inner(x)).map(|x| x as usize).collect();
        if found.is_empty() {
            let corners = run.iter().flat_map(|x| triangles[kept[x.2 as usize / 3]]);
            found = corners.filter(|&x| inner(x)).map(|x| x as usize).collect();
        }
        out.extend(found);
    }
    out.sort_unstable();
    out.dedup();
    out
}

/// Moves the samples of texels that keep the image from welding to the expected surface. Returns how many texels moved
/// and whether the image now welds as expected.
pub(crate) fn seal(
    grid: &mut Grid,
    samples: &mut [Sample],
    disk: &Disk,
    uv: &[[f64; 2]],
    expected: Expected,
) -> (usize, bool) {
    let mut moved = std::collections::BTreeSet::new();
    let mut locator = None;
    for step in 1..=STEPS {
        if expected.met(&grid.check()) {
            return (moved.len(), true);
        }
        for k in culprits(grid) {
            let (i, j) = (k % grid.width, k / grid.width);
            let inward = |x: usize, n: usize| f64::from(u8::from(x == 1)) - f64::from(u8::from(x + 2 == n));
            let d = [inward(i, grid.width), inward(j, grid.height)];
            let by = REACH * step as f64 / STEPS as f64;
            let q = [i as f64 + by * d[0], j as f64 + by * d[1]];
            let locator = locator.get_or_insert_with(|| Locator::new(disk, uv, grid.width - 1, grid.height - 1));
            if let Some(s) = locator.at(q) {
                grid.positions[k] = s.position(disk);
                samples[k] = s;
                moved.insert(k);
            }
        }
    }
    (moved.len(), expected.met(&grid.check()))
}
