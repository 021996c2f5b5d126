//! A binary tree of boxes around triangles, which finds the pairs whose boxes meet.

use super::mesh::{Mesh, list};
use crate::error::Result;

/// Triangles per leaf, at most.
const LEAF: usize = 4;

/// The low and the high corner of a box.
type Bounds = [[f32; 3]; 2];

struct Node {
    bounds: Bounds,
    /// Its triangles: a range of `order`.
    start: u32,
    end: u32,
    /// The second child; the first follows its parent. 0 for a leaf.
    second: u32,
}

/// A tree whose halves are equal, split along the longest side of the box around their centres.
pub struct Tree {
    nodes: Vec<Node>,
    /// Triangles, leaf by leaf.
    order: Vec<u32>,
    /// Their boxes.
    bounds: Vec<Bounds>,
    /// The nodes that are leaves.
    leaves: Vec<u32>,
}

impl Tree {
    /// Builds it, O(n log n). Errors if its lists do not fit in memory.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let count = mesh.len();
        let mut boxes = list(count, "boxes of triangles")?;
        boxes.extend((0..count as u32).map(|k| mesh.bounds(k)));
        let mut order = list(count, "triangles in the order of the tree")?;
        order.extend(0..count as u32);
        // Halves of more than LEAF triangles have more than LEAF / 2.
        let leaves = 2 * count / LEAF + 1;
        let mut tree = Tree {
            nodes: list(2 * leaves, "nodes of the tree")?,
            order,
            bounds: list(count, "boxes of triangles")?,
            leaves: list(leaves, "leaves of the tree")?,
        };
        if count > 0 {
            tree.split(&boxes, 0, count);
        }
        tree.bounds.extend(tree.order.iter().map(|k| boxes[*k as usize]));
        Ok(tree)
    }

    /// Adds the node of a range of `order`, and those below. Their depth is at most 32.
    fn split(&mut self, boxes: &[Bounds], start: usize, end: usize) {
        let range = &mut self.order[start..end];
        let around = |list: &[u32]| {
            let boxes = list.iter().map(|k| boxes[*k as usize]);
            boxes.reduce(|[low, high], b| {
                [[0, 1, 2].map(|c| low[c].min(b[0][c])), [0, 1, 2].map(|c| high[c].max(b[1][c]))]
            })
        };
        let bounds = around(range).unwrap_or_default();
        let at = self.nodes.len();
        self.nodes.push(Node { bounds, start: start as u32, end: end as u32, second: 0 });
        if end - start <= LEAF {
            self.leaves.push(at as u32);
            return;
        }
        let centre = |k: u32, c: usize| {
            let [low, high] = boxes[k as usize];
            0.5 * low[c] + 0.5 * high[c]
        };
        let spread = |c: usize| {
            let centres = || range.iter().map(|k| centre(*k, c));
            centres().fold(f32::NEG_INFINITY, f32::max) - centres().fold(f32::INFINITY, f32::min)
        };
        let spreads = [0, 1, 2].map(spread);
        let axis = (0..3).fold(0, |best, c| if spreads[c] > spreads[best] { c } else { best });
        let half = (end - start) / 2;
        // Ties are broken by index, so that the tree is one and the same.
        range.select_nth_unstable_by(half, |a, b| centre(*a, axis).total_cmp(&centre(*b, axis)).then(a.cmp(b)));
        self.split(boxes, start, start + half);
        self.nodes[at].second = self.nodes.len() as u32;
        self.split(boxes, start + half, end);
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.leaves.len()
    }

    /// Calls `each` with the pairs of triangles whose boxes meet, the first of them in a leaf, the second in it or after it: each pair of the tree
    /// comes once from all leaves.
    pub fn pairs(&self, leaf: usize, mut each: impl FnMut(u32, u32)) {
        let from = &self.nodes[self.leaves[leaf] as usize];
        let mut stack = vec![0_u32];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            if node.end <= from.start || !meet(&node.bounds, &from.bounds) {
                continue;
            }
            if node.second > 0 {
                stack.extend([at + 1, node.second]);
                continue;
            }
            for i in from.start..from.end {
                for j in node.start.max(i + 1)..node.end {
                    if meet(&self.bounds[i as usize], &self.bounds[j as usize]) {
                        each(self.order[i as usize], self.order[j as usize]);
                    }
                }
            }
        }
    }
}

/// Whether two boxes share a point.
fn meet(a: &Bounds, b: &Bounds) -> bool {
    (0..3).all(|c| a[0][c] <= b[1][c] && b[0][c] <= a[1][c])
}
