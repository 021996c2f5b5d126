//! The features of two cells: pairs that may meet get half-spaces.
//!
//! Boxes around features where they are leave out most pairs. They are f32, as positions are.

use super::closest;
use super::planes::{Planes, Points};
use super::surface::Surface;
use crate::cpu::rows::Threads;
use crate::number::real::{V3, cross, dot, sub};

/// Most edges, and vertices, of a cell.
const MAX_FEATURES: usize = 8;
/// Room for rounding of positions to f32, as a share of a distance that is above the least gap.
const WIDER: f64 = 1.02;
/// Lists of pairs for each thread.
const LISTS: usize = 4;

/// Two cells whose features may meet if they are not farther apart than `near` \[m\].
#[derive(Clone, Copy)]
pub struct Compared {
    pub cells: [usize; 2],
    pub near: f64,
    /// A direction in which they are likely to be apart: from one to the other.
    pub axis: V3<f64>,
}

/// Bounds \[m\].
#[derive(Clone, Copy)]
struct Extent {
    low: V3<f32>,
    high: V3<f32>,
}

impl Extent {
    /// Around points of a list, and `wide` more.
    #[inline(always)]
    fn of(at: &[V3<f64>], points: &[u32], wide: f32) -> Self {
        let (mut low, mut high) = ([f32::MAX; 3], [-f32::MAX; 3]);
        for point in points {
            let p = &at[*point as usize];
            for c in 0..3 {
                (low[c], high[c]) = (low[c].min(p[c] as f32), high[c].max(p[c] as f32));
            }
        }
        for c in 0..3 {
            (low[c], high[c]) = (low[c] - wide, high[c] + wide);
        }
        Extent { low, high }
    }

    /// Around both.
    #[inline(always)]
    fn with(mut self, other: &Self) -> Self {
        for c in 0..3 {
            (self.low[c], self.high[c]) = (self.low[c].min(other.low[c]), self.high[c].max(other.high[c]));
        }
        self
    }

    /// Whether both share a point.
    #[inline(always)]
    fn meets(&self, other: &Self) -> bool {
        let x = (self.low[0] <= other.high[0]) & (other.low[0] <= self.high[0]);
        let y = (self.low[1] <= other.high[1]) & (other.low[1] <= self.high[1]);
        x & y & (self.low[2] <= other.high[2]) & (other.low[2] <= self.high[2])
    }
}

/// Whether two cells are apart in the direction of their axis or of the normal of one: no feature of one is nearer than `near` to one of the
/// other.
fn is_parted(surface: &Surface, points: &Points, pair: &Compared) -> bool {
    let [a, b] = pair.cells.map(|cell| surface.triangles(cell));
    let parts = |axis: V3<f64>| {
        let along = |k: &u32| dot(axis, points.at[*k as usize]);
        let ends = |list: &[[u32; 3]]| {
            let list = list.as_flattened().iter().map(along);
            list.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let ([low_a, high_a], [low_b, high_b]) = (ends(a), ends(b));
        // Comparisons with NaN are false.
        let (gap, near) = ((low_b - high_a).max(low_a - high_b), WIDER * pair.near);
        gap > 0.0 && gap * gap > near * near * dot(axis, axis)
    };
    let normal = |list: &[[u32; 3]]| {
        list.first()
            .map(|triangle| triangle.map(|k| points.at[k as usize]))
            .map(|[p, q, r]| cross(sub(q, p), sub(r, p)))
    };
    parts(pair.axis) || normal(a).is_some_and(parts) || normal(b).is_some_and(parts)
}

/// Finds the pairs of features of two cells, or of a cell with itself.
pub fn compare(surface: &Surface, planes: &mut Planes, points: &Points, pair: &Compared) {
    let ([a, b], near2) = (pair.cells, pair.near * pair.near);
    if is_parted(surface, points, pair) {
        return;
    }
    let wide = (WIDER * pair.near) as f32;
    let at = |k: u32| points.at[k as usize];
    for (one, other) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
        for triangle in surface.triangles(other) {
            let extent = Extent::of(points.at, triangle, wide);
            for vertex in surface.vertices(one).iter().filter(|vertex| !triangle.contains(vertex)) {
                let near = extent.meets(&Extent::of(points.at, &[*vertex], 0.0));
                if near && points.concerns(&[*vertex], triangle) {
                    let way = closest::to_triangle(at(*vertex), triangle.map(at));
                    if dot(way, way) < near2 {
                        planes.separate(points, (&[*vertex], triangle), way);
                    }
                }
            }
        }
    }
    let none = Extent { low: [f32::MAX; 3], high: [-f32::MAX; 3] };
    let (mut extents, mut all) = ([none; MAX_FEATURES], none);
    let others = surface.edges(b);
    for (extent, edge) in extents.iter_mut().zip(others) {
        *extent = Extent::of(points.at, edge, 0.0);
        all = all.with(extent);
    }
    for (n, edge) in surface.edges(a).iter().enumerate() {
        let extent = Extent::of(points.at, edge, wide);
        if !extent.meets(&all) {
            continue;
        }
        let first = if a == b { n + 1 } else { 0 };
        for (other, beside) in others.iter().zip(&extents).skip(first) {
            let apart = !other.contains(&edge[0]) && !other.contains(&edge[1]);
            if apart && extent.meets(beside) && points.concerns(edge, other) {
                let way = closest::to_edge(edge.map(at), other.map(at));
                if dot(way, way) < near2 {
                    planes.separate(points, (edge, other), way);
                }
            }
        }
    }
}

/// Shares some pairs among threads; half-spaces are found in the order of one thread.
pub fn share(threads: &Threads, pairs: &[Compared], planes: &mut Planes, each: impl Fn(&mut Planes, &Compared) + Sync) {
    let size = pairs.len().div_ceil(LISTS * threads.count()).max(1);
    let mut lists: Vec<_> = pairs.chunks(size).map(|pairs| (pairs, Planes::default())).collect();
    threads.each(&mut lists, usize::MAX, |(pairs, planes)| pairs.iter().for_each(|pair| each(planes, pair)));
    lists.iter_mut().for_each(|(_, found)| planes.append(found));
}
