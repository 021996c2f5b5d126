//! Makes sure that welding the image gives back the surface's own topology.
//!
//! Where the cut ends, the texels on both sides of its last one are duplicates, and if the shorter diagonals of two
//! neighbouring quads both lead from them to the same inner texel, welding puts four triangles on that edge. Such an
//! inner texel, or its neighbour on the other diagonal, is sampled a fraction of a texel off its place, on the surface
//! still, until the diagonals part.

use crate::base::grid::{Grid, representatives};
use crate::base::halfedge::sorted_edges;
use crate::base::locate::Locator;
use crate::base::topology::Topology;
use crate::stage::cut::disk::Disk;
use crate::stage::sample::resample::Sample;

/// Topology that the image of a surface must weld to.
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

/// The image of a part of a surface, or of the whole.
pub(crate) struct Sheet<'a> {
    pub grid: &'a mut Grid,
    pub samples: &'a mut [Sample],
    pub disk: &'a Disk,
    /// The map, in texels.
    pub uv: &'a [[f64; 2]],
}

/// A texel to sample elsewhere: away from the border, or towards another texel of its sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Move {
    sheet: usize,
    texel: usize,
    towards: Option<usize>,
}

/// Triangles of all sheets with duplicates merged, and the quad (sheet, texel) that each is half of.
struct Welded {
    representative: Vec<u32>,
    /// Where the texels of each sheet begin among those of all.
    first: Vec<usize>,
    triangles: Vec<[u32; 3]>,
    quads: Vec<(usize, usize)>,
}

impl Welded {
    fn new(sheets: &[Sheet<'_>], rings: &[Vec<(u32, u32)>]) -> Self {
        let grids: Vec<&Grid> = sheets.iter().map(|s| &*s.grid).collect();
        let (first, representative) = representatives(&grids, rings);
        let (mut triangles, mut quads) = (Vec::new(), Vec::new());
        for (p, grid) in grids.iter().enumerate() {
            for (k, t) in grid.triangulate().into_iter().enumerate() {
                let w = t.map(|x| representative[first[p] + x as usize]);
                if w[0] != w[1] && w[1] != w[2] && w[2] != w[0] {
                    triangles.push(w);
                    // Two triangles a quad, quads row by row.
                    let quad = k / 2;
                    quads.push((p, quad / (grid.width - 1) * grid.width + quad % (grid.width - 1)));
                }
            }
        }
        Self { representative, first, triangles, quads }
    }

    /// Moves that would part the diagonals that meet on an over-full welded edge: its inner ends further in, so that
    /// they are longer, and the inner ends of the quads' other diagonals towards their border ends, so that those are
    /// shorter.
    fn moves(&self, sheets: &[Sheet<'_>]) -> Vec<Move> {
        let inner = |sheet: usize, x: usize| {
            let grid = &sheets[sheet].grid;
            let (i, j) = (x % grid.width, x / grid.width);
            i > 0 && j > 0 && i + 1 < grid.width && j + 1 < grid.height
        };
        let home = |x: u32| {
            let sheet = self.first.partition_point(|&f| f <= x as usize) - 1;
            (sheet, x as usize - self.first[sheet])
        };
        let mut out = Vec::new();
        for run in sorted_edges(&self.triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|r| r.len() > 2) {
            let ends = [run[0].0, run[0].1];
            // An inner texel has no duplicates: it is its own representative.
            let own = ends.iter().map(|&x| home(x)).filter(|&(p, x)| inner(p, x));
            out.extend(own.map(|(sheet, texel)| Move { sheet, texel, towards: None }));
            for x in run {
                let (sheet, a) = self.quads[x.2 as usize / 3];
                let width = sheets[sheet].grid.width;
                let corners = [a, a + 1, a + width + 1, a + width];
                for k in 0..2 {
                    let (p, q) = (corners[k], corners[k + 2]);
                    let on_edge = |x: usize| ends.contains(&self.representative[self.first[sheet] + x]);
                    if on_edge(p) || on_edge(q) {
                        continue;
                    }
                    match (inner(sheet, p), inner(sheet, q)) {
                        (true, false) => out.push(Move { sheet, texel: p, towards: Some(q) }),
                        (false, true) => out.push(Move { sheet, texel: q, towards: Some(p) }),
                        _ => {}
                    }
                }
            }
        }
        out.sort_unstable();
        out.dedup();
        out
    }
}

/// Moves the samples of texels that keep the images of a surface's parts from welding to the expected surface. `rings` are
/// the duplicates of several sheets as (sheet, texel). Returns how many texels of each sheet moved, and whether the images
/// now weld as expected.
pub(crate) fn seal(sheets: &mut [Sheet<'_>], rings: &[Vec<(u32, u32)>], expected: Expected) -> (Vec<usize>, bool) {
    let mut moved = vec![std::collections::BTreeSet::new(); sheets.len()];
    let count = |moved: &[std::collections::BTreeSet<usize>]| moved.iter().map(|m| m.len()).collect();
    let mut locators: Vec<Option<Locator<'_>>> = sheets.iter().map(|_| None).collect();
    for step in 1..=STEPS {
        let welded = Welded::new(sheets, rings);
        if expected.met(&Topology::of(&welded.triangles)) {
            return (count(&moved), true);
        }
        let by = REACH * step as f64 / STEPS as f64;
        for m in welded.moves(sheets) {
            let Sheet { grid, samples, disk, uv } = &mut sheets[m.sheet];
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
            let locator =
                locators[m.sheet].get_or_insert_with(|| Locator::new(disk, uv, grid.width - 1, grid.height - 1));
            if let Some(s) = locator.at(q) {
                grid.positions[m.texel] = s.position(disk);
                samples[m.texel] = s;
                moved[m.sheet].insert(m.texel);
            }
        }
    }
    let closed = expected.met(&Topology::of(&Welded::new(sheets, rings).triangles));
    (count(&moved), closed)
}
