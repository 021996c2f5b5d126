//! A tree of boxes over the triangles of a surface, made at rest; boxes are fitted to other poses as they are needed.

use super::NONE;
use crate::number::real::{Real, V3};

/// Triangles in a leaf, at most.
const LEAF: usize = 4;

/// The nodes in preorder: the first child of a node follows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Its triangles in the order.
    first: u32,
    count: u32,
    /// The second child; [`NONE`] of a leaf.
    second: u32,
}

/// A box: its low and its high corner \[m\].
pub(crate) type Bound<T> = [V3<T>; 2];

impl Tree {
    /// Halves the triangles along the longest side of the box around their middles, again and again.
    pub fn new(rest: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let middle = |t: &[u32; 3]| -> V3<f64> {
            [0, 1, 2].map(|c| t.iter().map(|v| f64::from(rest[*v as usize][c])).sum::<f64>() / 3.0)
        };
        let middles: Vec<V3<f64>> = triangles.iter().map(middle).collect();
        let mut tree = Tree { nodes: Vec::new(), order: (0..triangles.len() as u32).collect() };
        tree.divide(&middles, 0, triangles.len());
        tree
    }

    fn divide(&mut self, middles: &[V3<f64>], first: usize, count: usize) {
        let node = self.nodes.len();
        self.nodes.push(Node { first: first as u32, count: count as u32, second: NONE });
        if count <= LEAF {
            return;
        }
        let own = &mut self.order[first..first + count];
        let around = |own: &[u32], c: usize| {
            let x = || own.iter().map(|t| middles[*t as usize][c]);
            x().fold(f64::NEG_INFINITY, f64::max) - x().fold(f64::INFINITY, f64::min)
        };
        let axis = (0..3).max_by(|a, b| around(own, *a).total_cmp(&around(own, *b))).unwrap_or(0);
        let key = |t: &u32| middles[*t as usize][axis];
        own.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let half = count / 2;
        self.divide(middles, first, half);
        self.nodes[node].second = self.nodes.len() as u32;
        self.divide(middles, first + half, count - half);
    }

    /// The largest parts of the tree with at most `most` triangles: the part of each triangle, and of each part the triangle nearest to its middle.
    pub fn patches(&self, rest: &[[f32; 3]], triangles: &[[u32; 3]], most: usize) -> (Vec<u32>, Vec<u32>) {
        let (mut of, mut middles) = (vec![0; triangles.len()], Vec::new());
        let mut end = 0;
        for node in &self.nodes {
            if (node.first as usize) < end || node.count as usize > most {
                continue;
            }
            end = (node.first + node.count) as usize;
            let own = &self.order[node.first as usize..end];
            own.iter().for_each(|t| of[*t as usize] = middles.len() as u32);
            let middle = |t: u32| -> V3<f64> {
                [0, 1, 2]
                    .map(|c| triangles[t as usize].iter().map(|v| f64::from(rest[*v as usize][c])).sum::<f64>() / 3.0)
            };
            let center = [0, 1, 2].map(|c| own.iter().map(|t| middle(*t)[c]).sum::<f64>() / own.len() as f64);
            let far = |t: &u32| (0..3).map(|c| (middle(*t)[c] - center[c]).powi(2)).sum::<f64>();
            middles.extend(own.iter().min_by(|a, b| far(a).total_cmp(&far(b))));
        }
        (of, middles)
    }

    /// The boxes of all nodes where `corners` has the corners of each triangle.
    pub fn fit<T: Real>(&self, corners: impl Fn(u32) -> [V3<T>; 3], bounds: &mut Vec<Bound<T>>) {
        let none = [[T::of(f64::from(f32::MAX)); 3], [T::of(f64::from(-f32::MAX)); 3]];
        bounds.clear();
        bounds.resize(self.nodes.len(), none);
        for n in (0..self.nodes.len()).rev() {
            let Node { first, count, second } = self.nodes[n];
            let mut own = none;
            let mut take = |low: V3<T>, high: V3<T>| {
                for c in 0..3 {
                    own[0][c] = own[0][c].min(low[c]);
                    own[1][c] = own[1][c].max(high[c]);
                }
            };
            if second == NONE {
                let leaf = &self.order[first as usize..(first + count) as usize];
                leaf.iter().flat_map(|t| corners(*t)).for_each(|p| take(p, p));
            } else {
                [n + 1, second as usize].iter().for_each(|child| take(bounds[*child][0], bounds[*child][1]));
            }
            bounds[n] = own;
        }
    }

    /// Calls `visit` for the triangles of all leaves in boxes that `meets` holds for; the boxes must be of the same pose.
    pub fn visit<T: Real>(&self, bounds: &[Bound<T>], meets: impl Fn(&Bound<T>) -> bool, mut visit: impl FnMut(u32)) {
        let mut stack = vec![0u32];
        while let Some(n) = stack.pop() {
            let Node { first, count, second } = self.nodes[n as usize];
            if !meets(&bounds[n as usize]) {
                continue;
            }
            if second == NONE {
                self.order[first as usize..(first + count) as usize].iter().for_each(|t| visit(*t));
            } else {
                stack.extend([second, n + 1]);
            }
        }
    }

    /// The triangle with the least `distance2`, the first of those in the order of the search; the boxes must be of the same pose.
    pub fn nearest<T: Real>(&self, bounds: &[Bound<T>], p: V3<T>, mut distance2: impl FnMut(u32) -> T) -> (u32, T) {
        let mut best = (NONE, T::of(f64::from(f32::MAX)));
        let (mut stack, mut depth) = ([(0u32, T::of(0.0)); 64], 1);
        stack[0] = (0, apart(&bounds[0], p));
        while depth > 0 {
            depth -= 1;
            let (n, far) = stack[depth];
            if far >= best.1 {
                continue;
            }
            let Node { first, count, second } = self.nodes[n as usize];
            if second == NONE {
                for t in &self.order[first as usize..(first + count) as usize] {
                    let d = distance2(*t);
                    if d < best.1 {
                        best = (*t, d);
                    }
                }
                continue;
            }
            let children = [n + 1, second].map(|child| (child, apart(&bounds[child as usize], p)));
            let [near, far] = if children[0].1 <= children[1].1 { children } else { [children[1], children[0]] };
            (stack[depth], stack[depth + 1]) = (far, near);
            depth += 2;
        }
        best
    }
}

/// The squared distance of a point from a box.
pub(crate) fn apart<T: Real>([low, high]: &Bound<T>, p: V3<T>) -> T {
    let d: V3<T> = [0, 1, 2].map(|c| (low[c] - p[c]).max(p[c] - high[c]).max(T::of(0.0)));
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}
