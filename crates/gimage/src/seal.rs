//! Makes sure that welding the image gives back the surface's own topology.
//!
//! Where the cut ends, the texels on both sides of its last one are duplicates, and if the shorter diagonals of two
//! neighbouring quads both lead from them to the same inner texel, welding puts four triangles on that edge. Such an
//! inner texel, or its neighbour on the other diagonal, is sampled a fraction of a texel off its place, on the surface
//! still, until the diagonals part.

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

/// A texel to sample elsewhere: away from the border, or towards another texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Move {
    texel: usize,
    towards: Option<usize>,
}

/// What would part the diagonals that meet on an over-full welded edge: its inner ends further in, so that they are
/// longer, and the inner ends of the quads' other diagonals towards their border ends, so that those are shorter.
fn moves(grid: &Grid) -> Vec<Move> {
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
    let inner = |x: usize| {
        let (i, j) = (x % grid.width, x / grid.width);
        i > 0 && j > 0 && i + 1 < grid.width && j + 1 < grid.height
    };
    let mut out = Vec::new();
    for run in sorted_edges(&welded).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|r| r.len() > 2) {
        let ends = [run[0].0, run[0].1];
        out.extend(ends.iter().filter(|&&x| inner(x as usize)).map(|&x| Move { texel: x as usize, towards: None }));
        for x in run {
            // Two triangles a quad, quads row by row.
            let quad = kept[x.2 as usize / 3] / 2;
            let a = quad / (grid.width - 1) * grid.width + quad % (grid.width - 1);
            let corners = [a, a + 1, a + grid.width + 1, a + grid.width];
            for k in 0..2 {
                let (p, q) = (corners[k], corners[k + 2]);
                let on_edge = |x: usize| ends.contains(&representative[x]);
                if on_edge(p) || on_edge(q) {
                    continue;
                }
                match (inner(p), inner(q)) {
                    (true, false) => out.push(Move { texel: p, towards: Some(q) }),
                    (false, true) => out.push(Move { texel: q, towards: Some(p) }),
                    _ => {}
                }
            }
        }
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
        let by = REACH * step as f64 / STEPS as f64;
        for m in moves(grid) {
            let at = |k: usize| [(k % grid.width) as f64, (k / grid.width) as f64];
            let (i, j) = (m.texel % grid.width, m.texel / grid.width);
            let direction = match m.towards {
                Some(k) => [at(k)[0] - at(m.texel)[0], at(k)[1] - at(m.texel)[1]],
                None => {
                    let inward = |x: usize, n: usize| f64::from(u8::from(x == 1)) - f64::from(u8::from(x + 2 == n));
                    [inward(i, grid.width), inward(j, grid.height)]
                }
            };
            let q = [i as f64 + by * direction[0], j as f64 + by * direction[1]];
            let locator = locator.get_or_insert_with(|| Locator::new(disk, uv, grid.width - 1, grid.height - 1));
            if let Some(s) = locator.at(q) {
                grid.positions[m.texel] = s.position(disk);
                samples[m.texel] = s;
                moved.insert(m.texel);
            }
        }
    }
    (moved.len(), expected.met(&grid.check()))
}
