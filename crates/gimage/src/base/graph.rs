//! The edges of a surface as a weighted graph, and shortest paths on it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::base::halfedge::{BOUNDARY, sorted_edges};
use crate::base::vec3::distance;

/// Edges, their half-edges and the neighbours of each vertex.
#[derive(Clone, Debug)]
pub(crate) struct EdgeGraph {
    /// Both ends of each edge, smaller first; sorted.
    pub ends: Vec<[u32; 2]>,
    /// The one or two half-edges of each edge.
    pub halves: Vec<[u32; 2]>,
    /// Length of each edge \[m\].
    pub length: Vec<f64>,
    /// Edge of each half-edge.
    pub of_half: Vec<u32>,
    first: Vec<u32>,
    around: Vec<(u32, u32)>,
}

impl EdgeGraph {
    /// Builds the graph of an edge-manifold mesh. O(n log n).
    pub(crate) fn new(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut of_half = vec![0u32; 3 * triangles.len()];
        let sorted = sorted_edges(triangles);
        let edges = || sorted.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
        let many = edges().count();
        let (mut ends, mut halves) = (Vec::with_capacity(many), Vec::with_capacity(many));
        for run in edges() {
            run.iter().for_each(|x| of_half[x.2 as usize] = ends.len() as u32);
            ends.push([run[0].0, run[0].1]);
            halves.push([run[0].2, run.get(1).map_or(BOUNDARY, |x| x.2)]);
        }
        drop(sorted);
        let length = ends.iter().map(|e| distance(positions[e[0] as usize], positions[e[1] as usize])).collect();
        let mut first = vec![0u32; positions.len() + 1];
        ends.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        (0..positions.len()).for_each(|v| first[v + 1] += first[v]);
        let mut next = first.clone();
        let mut around = vec![(0, 0); 2 * ends.len()];
        for (e, &[a, b]) in ends.iter().enumerate() {
            for (x, y) in [(a, b), (b, a)] {
                around[next[x as usize] as usize] = (y, e as u32);
                next[x as usize] += 1;
            }
        }
        Self { ends, halves, length, of_half, first, around }
    }

    /// Neighbours of `v` as (vertex, edge).
    pub(crate) fn neighbours(&self, v: u32) -> &[(u32, u32)] {
        &self.around[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    /// Whether edge `e` has one triangle only.
    pub(crate) fn is_boundary(&self, e: usize) -> bool {
        self.halves[e][1] == BOUNDARY
    }

    /// Number of vertices.
    pub(crate) fn vertices(&self) -> usize {
        self.first.len() - 1
    }
}

/// No vertex, no edge.
pub(crate) const NONE: u32 = u32::MAX;

/// A wave of shortest paths over any graph (Dijkstra): it can be stopped, given more sources and continued, and keeps
/// what it has found. Ties go to the smaller vertex, so the paths depend on the graph alone.
pub(crate) struct Wave {
    /// Cost of the cheapest path to each vertex, infinite where the wave has not been.
    pub distance: Vec<f64>,
    /// (previous vertex, edge) on that path, [`NONE`] at the sources.
    pub via: Vec<(u32, u32)>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl Wave {
    /// A wave over `vertices` vertices without a source.
    pub(crate) fn new(vertices: usize) -> Self {
        Self { distance: vec![f64::INFINITY; vertices], via: vec![(NONE, NONE); vertices], heap: BinaryHeap::new() }
    }

    /// Makes `v` a source.
    pub(crate) fn source(&mut self, v: u32) {
        self.via[v as usize] = (NONE, NONE);
        if self.distance[v as usize] > 0.0 {
            self.distance[v as usize] = 0.0;
            self.heap.push(Reverse((0, v)));
        }
    }

    /// Spreads to the nearest vertex for which `target` holds and returns it; over everything in reach if there is none.
    /// `neighbours` are the (vertex, edge, cost) around a vertex; a cost is not negative. O(n log n).
    pub(crate) fn next<N: Iterator<Item = (u32, u32, f64)>>(
        &mut self,
        neighbours: impl Fn(u32) -> N,
        target: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        while let Some(Reverse((bits, v))) = self.heap.pop() {
            // Bits of non-negative floats sort as the floats do.
            let d = f64::from_bits(bits);
            if d > self.distance[v as usize] {
                continue;
            }
            if target(v) {
                // Its neighbours have not been reached from it yet.
                self.heap.push(Reverse((bits, v)));
                return Some(v);
            }
            for (w, e, cost) in neighbours(v) {
                let new = d + cost;
                if new < self.distance[w as usize] {
                    self.distance[w as usize] = new;
                    self.via[w as usize] = (v, e);
                    self.heap.push(Reverse((new.to_bits(), w)));
                }
            }
        }
        None
    }

    /// The path back from `v` to its source, as (vertex, edge that leads back), the source last with [`NONE`].
    pub(crate) fn back(&self, mut v: u32) -> Vec<(u32, u32)> {
        let mut out = Vec::new();
        loop {
            let (p, e) = self.via[v as usize];
            out.push((v, e));
            if p == NONE {
                return out;
            }
            v = p;
        }
    }

    /// The reached vertex farthest from the sources.
    pub(crate) fn farthest(&self) -> Option<u32> {
        let mut best: Option<(f64, u32)> = None;
        for (v, &d) in self.distance.iter().enumerate() {
            if d.is_finite() && best.is_none_or(|b| d > b.0) {
                best = Some((d, v as u32));
            }
        }
        best.map(|b| b.1)
    }
}

/// A wave along the edges of a surface, each at its own cost.
pub(crate) struct Paths<'a> {
    graph: &'a EdgeGraph,
    cost: &'a [f64],
    /// The paths found so far.
    pub wave: Wave,
}

impl<'a> Paths<'a> {
    /// Paths from `sources` that have not spread yet; one cost per edge.
    pub(crate) fn new(graph: &'a EdgeGraph, cost: &'a [f64], sources: impl IntoIterator<Item = u32>) -> Self {
        let mut wave = Wave::new(graph.vertices());
        sources.into_iter().for_each(|s| wave.source(s));
        Self { graph, cost, wave }
    }

    /// The nearest vertex for which `target` holds.
    pub(crate) fn next(&mut self, target: impl Fn(u32) -> bool) -> Option<u32> {
        let (graph, cost) = (self.graph, self.cost);
        self.wave.next(|v| graph.neighbours(v).iter().map(|&(w, e)| (w, e, cost[e as usize])), target)
    }

    /// Paths to everything in reach of `sources`.
    pub(crate) fn all(graph: &'a EdgeGraph, cost: &'a [f64], sources: impl IntoIterator<Item = u32>) -> Wave {
        let mut paths = Paths::new(graph, cost, sources);
        paths.next(|_| false);
        paths.wave
    }
}
