//! Tells the two sheets of a shell apart: neighbours across a flat edge lie on one sheet, facing triangles on two.

use crate::base::halfedge::sorted_edges;
use crate::base::vec3::dot;

use super::zone::Zone;

/// The sheets of a zone.
pub(super) struct Sides {
    /// For each triangle a triangle that stands for its group: everything that is connected or faces each other.
    pub group: Vec<u32>,
    /// For each triangle whether it lies on the sheet of `group`, or on the other one.
    pub is_other: Vec<bool>,
    /// Edges between two triangles, as (triangle, triangle, smaller vertex, larger vertex).
    pub edges: Vec<Edge>,
    /// Edges of one triangle.
    pub border: Vec<Border>,
}

/// An edge between two triangles of a zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub triangles: [u32; 2],
    pub vertices: [u32; 2],
}

/// An edge of one triangle of a zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    pub triangle: u32,
    pub vertices: [u32; 2],
}

/// Sets of triangles with the sheet that each lies on.
struct Signed {
    up: Vec<u32>,
    /// Whether it lies on another sheet than `up`.
    flip: Vec<bool>,
}

impl Signed {
    fn find(&mut self, x: u32) -> (u32, bool) {
        let (mut root, mut flip) = (x, false);
        while self.up[root as usize] != root {
            flip ^= self.flip[root as usize];
            root = self.up[root as usize];
        }
        // All on the way then lead to the root at once.
        let (mut at, mut rest) = (x, flip);
        while self.up[at as usize] != root && at != root {
            let (next, turn) = (self.up[at as usize], self.flip[at as usize]);
            (self.up[at as usize], self.flip[at as usize]) = (root, rest);
            rest ^= turn;
            at = next;
        }
        (root, flip)
    }

    fn union(&mut self, a: u32, b: u32, is_other: bool) {
        let ((a, x), (b, y)) = (self.find(a), self.find(b));
        if a != b {
            let (low, high) = (a.min(b), a.max(b));
            self.up[high as usize] = low;
            self.flip[high as usize] = x ^ y ^ is_other;
        }
    }
}

/// Puts the ties of triangles that may be rims after all others: of those that no sheet faces, and narrow ones.
const LAST: f64 = 2.0;

/// Labels all triangles. The surest ties come first: of neighbours those whose edge is flattest, of facing triangles those that
/// are most parallel, so that a label never runs over a rim before both sheets are labelled. Sheets may have sharper creases than rims
/// have edges, so triangles that may be rims come last. O(n log n).
pub(super) fn sides(zone: &Zone) -> Sides {
    let n = zone.triangles.len();
    let cosine = |a: u32, b: u32| dot(zone.normal[a as usize], zone.normal[b as usize]);
    let (mut edges, mut border) = (Vec::new(), Vec::new());
    for run in sorted_edges(&zone.triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let vertices = [run[0].0, run[0].1];
        match run {
            [a] => border.push(Border { triangle: a.2 / 3, vertices }),
            [a, b] => edges.push(Edge { triangles: [a.2 / 3, b.2 / 3], vertices }),
            _ => {}
        }
    }
    let mut ties: Vec<(f64, [u32; 2], bool)> = Vec::with_capacity(edges.len() + zone.pairs.len());
    let is_rim = |t: u32| zone.is_narrow[t as usize] || !zone.gap[t as usize].is_finite();
    let last = |[a, b]: [u32; 2]| if is_rim(a) || is_rim(b) { LAST } else { 0.0 };
    let pairs = zone.pairs.iter().map(|p| [p.triangle, p.other]);
    ties.extend(edges.iter().map(|e| e.triangles).map(|[a, b]| (1.0 - cosine(a, b) + last([a, b]), [a, b], false)));
    ties.extend(pairs.map(|[a, b]| (1.0 + cosine(a, b) + last([a, b]), [a, b], true)));
    ties.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut sets = Signed { up: (0..n as u32).collect(), flip: vec![false; n] };
    ties.iter().for_each(|&(_, [a, b], is_other)| sets.union(a, b, is_other));
    let (group, is_other) = (0..n as u32).map(|t| sets.find(t)).unzip();
    Sides { group, is_other, edges, border }
}
