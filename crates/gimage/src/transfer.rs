//! A cut of a coarse stand-in -> a cut of the surface it stands for, of the same homotopy class.
//!
//! Every coarse vertex owns a connected patch of the surface (the vertices collapsed into it). A coarse edge becomes the
//! cheapest crossing between its two patches, joined to the middle of each by that patch's shortest-path tree. Trees do
//! not meet twice, so no new cycle appears and the result cuts to a disk where the coarse cut did.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use crate::cut::{Cut, Cutter, prune};
use crate::decimate::Coarse;
use crate::graph::NONE;

/// Carries `cut` of `coarse` (whose surface `small` was made from) over to `fine`. `terminals` are fine vertices whose
/// dead ends are meant. O(n log n).
pub(crate) fn transfer(fine: &Cutter<'_>, small: &Cutter<'_>, coarse: &Coarse, cut: &Cut, terminals: &[u32]) -> Cut {
    let graph = &fine.graph;
    let n = graph.vertices();
    let mut rim = vec![false; n];
    fine.loops().iter().flatten().for_each(|&v| rim[v as usize] = true);
    // Shortest-path trees inside the patches; a path that ends on the boundary may end anywhere on its stretch of it.
    let mut distance = vec![f64::INFINITY; n];
    let mut via = vec![(NONE, NONE); n];
    let mut heap = BinaryHeap::new();
    for (k, &v) in coarse.vertex.iter().enumerate() {
        let _ = k;
        distance[v as usize] = 0.0;
        heap.push(Reverse((0u64, v)));
    }
    for v in (0..n as u32).filter(|&v| rim[v as usize]) {
        distance[v as usize] = 0.0;
        heap.push(Reverse((0u64, v)));
    }
    while let Some(Reverse((bits, v))) = heap.pop() {
        let d = f64::from_bits(bits);
        if d > distance[v as usize] {
            continue;
        }
        for &(w, e) in graph.neighbours(v) {
            let new = d + graph.length[e as usize];
            if coarse.patch[w as usize] == coarse.patch[v as usize] && new < distance[w as usize] {
                distance[w as usize] = new;
                via[w as usize] = (v, e);
                heap.push(Reverse((new.to_bits(), w)));
            }
        }
    }
    let mut wanted: HashMap<[u32; 2], Option<(f64, u32)>> = HashMap::new();
    for (e, _) in cut.edges.iter().enumerate().filter(|(_, c)| **c) {
        wanted.insert(small.graph.ends[e], None);
    }
    for (e, ends) in graph.ends.iter().enumerate() {
        if graph.is_boundary(e) {
            continue;
        }
        let [a, b] = ends.map(|v| coarse.patch[v as usize]);
        if let Some(best) = wanted.get_mut(&[a.min(b), a.max(b)]) {
            let cost = distance[ends[0] as usize] + graph.length[e] + distance[ends[1] as usize];
            if best.is_none_or(|x| cost < x.0) {
                *best = Some((cost, e as u32));
            }
        }
    }
    let mut edges = vec![false; graph.ends.len()];
    for (_, e) in wanted.values().flatten() {
        edges[*e as usize] = true;
        for mut v in graph.ends[*e as usize] {
            while via[v as usize].0 != NONE {
                let (p, edge) = via[v as usize];
                edges[edge as usize] |= !graph.is_boundary(edge as usize);
                v = p;
            }
        }
    }
    let mut keep = vec![false; n];
    terminals.iter().for_each(|&v| keep[v as usize] = true);
    if fine.loops().is_empty() && fine.handles() == 0 {
        // The two ends of a closed surface's first path are ends of the coarse cut.
        let mut degree = vec![0u32; small.graph.vertices()];
        for (e, _) in cut.edges.iter().enumerate().filter(|(_, c)| **c) {
            small.graph.ends[e].iter().for_each(|&v| degree[v as usize] += 1);
        }
        degree.iter().enumerate().filter(|(_, d)| **d == 1).for_each(|(v, _)| keep[coarse.vertex[v] as usize] = true);
    }
    prune(graph, &mut edges, &keep);
    Cut { edges }
}
