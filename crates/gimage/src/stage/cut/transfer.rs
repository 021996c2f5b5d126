//! A cut of a coarse stand-in -> a cut of the surface it stands for, of the same homotopy class.
//!
//! Every coarse vertex owns a connected patch of the surface (the vertices collapsed into it). A coarse edge becomes the
//! cheapest crossing between its two patches, joined to the middle of each by that patch's shortest-path tree. Trees do
//! not meet twice, so no new cycle appears and the result cuts to a disk where the coarse cut did.

use std::collections::BTreeMap;

use crate::base::decimate::Coarse;
use crate::base::graph::{NONE, Wave};
use crate::stage::cut::{Cut, Cutter, prune};

/// Carries `cut` of `coarse` (whose surface `small` was made from) over to `fine`. `terminals` are fine vertices whose
/// dead ends are meant. O(n log n).
pub(crate) fn transfer(fine: &Cutter<'_>, small: &Cutter<'_>, coarse: &Coarse, cut: &Cut, terminals: &[u32]) -> Cut {
    let graph = &fine.graph;
    let n = graph.vertices();
    let mut rim = vec![false; n];
    fine.loops().iter().flatten().for_each(|&v| rim[v as usize] = true);
    // Shortest-path trees inside the patches; a path that ends on the boundary may end anywhere on its stretch of it.
    let mut wave = Wave::new(n);
    coarse.vertex.iter().for_each(|&v| wave.source(v));
    (0..n as u32).filter(|&v| rim[v as usize]).for_each(|v| wave.source(v));
    let within_patch = |v: u32| {
        let same = move |w: u32| coarse.patch[w as usize] == coarse.patch[v as usize];
        let around = graph.neighbours(v).iter().filter(move |x| same(x.0));
        around.map(|&(w, e)| (w, e, graph.length[e as usize]))
    };
    wave.next(within_patch, |_| false);
    let Wave { distance, via, .. } = wave;
    let mut wanted: BTreeMap<[u32; 2], Option<(f64, u32)>> = BTreeMap::new();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::decimate::decimate;
    use crate::base::shapes;
    use crate::base::surface::Surface;
    use crate::stage::cut::disk;
    use proptest::prelude::*;

    fn check(s: &Surface, target: usize, many: usize, seed: u64) {
        let fine = Cutter::new(s).unwrap();
        let coarse = decimate(&s.positions, &s.triangles, &shapes::rim(s), &vec![false; s.positions.len()], target);
        let small =
            shapes::surface(coarse.vertex.iter().map(|&v| s.positions[v as usize]).collect(), coarse.triangles.clone());
        let cutter = Cutter::new(&small).unwrap();
        let mut draw = shapes::random(seed);
        let picks: Vec<u32> = (0..many).map(|_| draw(coarse.vertex.len()) as u32).collect();
        let cut = cutter.cut(&cutter.graph.length, &picks);
        let terminals: Vec<u32> = picks.iter().map(|&v| coarse.vertex[v as usize]).collect();
        let carried = transfer(&fine, &cutter, &coarse, &cut, &terminals);
        let disk = disk::open(&fine, &carried).unwrap();
        let mut on = vec![false; s.positions.len()];
        disk.boundary.iter().for_each(|&v| on[disk.origin[v as usize] as usize] = true);
        assert!(terminals.iter().all(|&t| on[t as usize]));
    }

    #[test]
    fn carried_cuts_open_every_shape() {
        for (_, s) in shapes::all() {
            for target in [0, s.triangles.len() / 3, s.triangles.len()] {
                check(&s, target, 0, 1);
                check(&s, target, 4, 2);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn carried_cuts_open_random_blobs(seed in any::<u64>(), holes in 0usize..20, target in 0usize..300, many in 0usize..5) {
            check(&shapes::blob(seed, 80, holes), target, many, seed);
        }
    }
}
