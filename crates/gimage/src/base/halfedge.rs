//! Neighbours in a triangle mesh, as one array of twins.
//!
//! Half-edge `h = 3 t + c` runs from corner `c` of triangle `t` to corner `(c + 1) % 3`. A surface here is
//! edge-manifold (at most two triangles an edge) but need not be orientable: twins may run the same way.

use std::collections::HashMap;

/// No twin: the half-edge lies on the boundary.
pub const BOUNDARY: u32 = u32::MAX;

/// An edge with more than two triangles, as its two vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NonManifoldEdge(pub [u32; 2]);

/// The vertex half-edge `h` starts at.
#[inline]
pub fn origin(triangles: &[[u32; 3]], h: u32) -> u32 {
    triangles[h as usize / 3][h as usize % 3]
}

/// The vertex half-edge `h` ends at.
#[inline]
pub fn target(triangles: &[[u32; 3]], h: u32) -> u32 {
    origin(triangles, next(h))
}

/// The next half-edge of the same triangle.
#[inline]
pub fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The previous half-edge of the same triangle.
#[inline]
pub fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// The undirected edge of half-edge `h`, smaller vertex first.
#[inline]
pub fn edge(triangles: &[[u32; 3]], h: u32) -> [u32; 2] {
    let (a, b) = (origin(triangles, h), target(triangles, h));
    if a < b { [a, b] } else { [b, a] }
}

/// One more than the largest vertex, if the vertices are numbered densely enough to be counted with an array.
fn dense(triangles: &[[u32; 3]]) -> Option<usize> {
    let most = triangles.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    (most <= 64 * triangles.len() + 64).then_some(most)
}

/// The vertices that triangles use, numbered in their order.
pub(crate) struct Used {
    /// How many.
    pub count: usize,
    /// The number of each vertex, or the vertices in order.
    number: Result<Vec<u32>, Vec<u32>>,
}

impl Used {
    pub(crate) fn new(triangles: &[[u32; 3]]) -> Self {
        if let Some(most) = dense(triangles) {
            let mut number = vec![0u32; most];
            triangles.iter().flatten().for_each(|&v| number[v as usize] = 1);
            let mut count = 0;
            for n in &mut number {
                (*n, count) = (count, count + *n);
            }
            return Self { count: count as usize, number: Ok(number) };
        }
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        Self { count: used.len(), number: Err(used) }
    }

    /// The number of a vertex in use.
    pub(crate) fn number(&self, v: u32) -> u32 {
        match &self.number {
            Ok(number) => number[v as usize],
            Err(used) => used.partition_point(|&x| x < v) as u32,
        }
    }
}

/// All half-edges as (smaller vertex, larger vertex, half-edge), sorted: the half-edges of one edge stand together.
pub fn sorted_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32, u32)> {
    let halves = 0..3 * triangles.len() as u32;
    let Some(vertices) = dense(triangles) else {
        let mut all: Vec<_> = halves.map(|h| (edge(triangles, h), h)).map(|([a, b], h)| (a, b, h)).collect();
        all.sort_unstable();
        return all;
    };
    // Dealt out by the smaller vertex, of which few half-edges have the same; O(n) for a mesh of bounded valence.
    let mut next = vec![0u32; vertices + 1];
    halves.clone().for_each(|h| next[edge(triangles, h)[0] as usize + 1] += 1);
    (0..vertices).for_each(|v| next[v + 1] += next[v]);
    let mut all = vec![(0, 0, 0); 3 * triangles.len()];
    for h in halves {
        let [a, b] = edge(triangles, h);
        all[next[a as usize] as usize] = (a, b, h);
        next[a as usize] += 1;
    }
    // Half-edges came in order: only the larger vertices are out of it.
    all.chunk_by_mut(|x, y| x.0 == y.0).for_each(|run| run.sort_unstable());
    all
}

/// For each half-edge the other half-edge on its edge, or [`BOUNDARY`]. O(n log n).
pub fn twins(triangles: &[[u32; 3]]) -> Result<Vec<u32>, NonManifoldEdge> {
    let mut twin = vec![BOUNDARY; 3 * triangles.len()];
    for run in sorted_edges(triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match run {
            [_] => {}
            [x, y] => {
                twin[x.2 as usize] = y.2;
                twin[y.2 as usize] = x.2;
            }
            _ => return Err(NonManifoldEdge([run[0].0, run[0].1])),
        }
    }
    Ok(twin)
}

/// Vertices in use - edges + triangles.
pub fn euler(triangles: &[[u32; 3]]) -> i64 {
    let edges = sorted_edges(triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).count();
    Used::new(triangles).count as i64 - edges as i64 + triangles.len() as i64
}

/// The boundary loops, each as its vertices in order, starting at the smallest vertex of each loop; loops in the order of
/// that vertex. In an oriented mesh they run along the half-edges. Every boundary vertex must have exactly two boundary
/// edges (no bow ties), else `None`.
pub fn boundary_loops(triangles: &[[u32; 3]], twin: &[u32]) -> Option<Vec<Vec<u32>>> {
    let mut ends: HashMap<u32, Vec<(u32, bool)>> = HashMap::new();
    for h in (0..twin.len() as u32).filter(|&h| twin[h as usize] == BOUNDARY) {
        ends.entry(origin(triangles, h)).or_default().push((target(triangles, h), true));
        ends.entry(target(triangles, h)).or_default().push((origin(triangles, h), false));
    }
    if ends.values().any(|e| e.len() != 2) {
        return None;
    }
    let mut starts: Vec<u32> = ends.keys().copied().collect();
    starts.sort_unstable();
    let mut seen: HashMap<u32, bool> = HashMap::with_capacity(starts.len());
    let mut loops = Vec::new();
    for s in starts {
        if seen.contains_key(&s) {
            continue;
        }
        let e = &ends[&s];
        let first = e.iter().find(|x| x.1).unwrap_or(&e[0]).0;
        let (mut prev, mut v, mut ring) = (s, first, vec![s]);
        seen.insert(s, true);
        while v != s {
            seen.insert(v, true);
            ring.push(v);
            let e = &ends[&v];
            // Two boundary edges between the same two vertices cannot occur in a manifold of triangles.
            let n = if e[0].0 == prev { e[1].0 } else { e[0].0 };
            (prev, v) = (v, n);
        }
        loops.push(ring);
    }
    Some(loops)
}

/// The half-edges that leave `v` in fan order around it, given one of them, in an oriented mesh; for a boundary vertex
/// the fan starts at its boundary half-edge.
pub fn fan(twin: &[u32], start: u32) -> Vec<u32> {
    let mut h = start;
    loop {
        let t = twin[h as usize];
        if t == BOUNDARY {
            break;
        }
        h = next(t);
        if h == start {
            break;
        }
    }
    let (first, mut out) = (h, Vec::with_capacity(8));
    loop {
        out.push(h);
        let t = twin[prev(h) as usize];
        if t == BOUNDARY || t == first {
            return out;
        }
        h = t;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_has_one_loop_and_one_inner_edge() {
        let t = [[0, 1, 2], [0, 2, 3]];
        let twin = twins(&t).unwrap();
        assert_eq!(twin.iter().filter(|&&x| x == BOUNDARY).count(), 4);
        assert_eq!(boundary_loops(&t, &twin).unwrap(), vec![vec![0, 1, 2, 3]]);
        assert_eq!(euler(&t), 1);
    }

    #[test]
    fn a_tetrahedron_is_closed() {
        let t = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let twin = twins(&t).unwrap();
        assert!(twin.iter().all(|&x| x != BOUNDARY));
        assert_eq!(euler(&t), 2);
        assert_eq!(fan(&twin, 0).len(), 3);
    }

    #[test]
    fn three_triangles_on_an_edge_are_refused() {
        assert_eq!(twins(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]), Err(NonManifoldEdge([0, 1])));
    }

    #[test]
    fn a_fan_starts_at_the_boundary() {
        let t = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        let twin = twins(&t).unwrap();
        for start in [0, 3, 6] {
            assert_eq!(fan(&twin, start), vec![0, 3, 6]);
        }
    }

    #[test]
    fn edges_come_in_one_order_however_vertices_are_numbered() {
        // A fan whose vertices are numbered backwards, densely and with wide gaps: the same order but for the numbers.
        let fan = |gap: u32| -> Vec<[u32; 3]> { (0..40).map(|k| [gap * (41 - k), 0, gap * (40 - k)]).collect() };
        let gap = 1000;
        assert!(dense(&fan(1)).is_some() && dense(&fan(gap)).is_none());
        let (near, far) = (sorted_edges(&fan(1)), sorted_edges(&fan(gap)));
        assert!(near.is_sorted() && near.len() == 120);
        assert_eq!(near.iter().map(|e| (gap * e.0, gap * e.1, e.2)).collect::<Vec<_>>(), far);
        let (a, b) = (Used::new(&fan(1)), Used::new(&fan(gap)));
        assert_eq!((a.count, b.count), (42, 42));
        assert!((0..42).all(|v| a.number(v) == v && b.number(gap * v) == v));
    }
}
