//! A component -> a set of edges that, cut open, leaves a topological disk.
//!
//! Boundary loops are joined by shortest edge paths, handles and cross-caps are opened with a tree-cotree
//! decomposition (Eppstein 2003; shortest loops as in Erickson, Whittlesey 2005), closed surfaces start from a path
//! between two far points, and extra terminals are reached by shortest paths (Gu, Gortler, Hoppe 2002). Orientability
//! is not needed: what is counted is homology over Z/2.

pub mod corners;
pub mod disk;
pub mod grow;
pub(crate) mod symmetry;
pub(crate) mod transfer;

use gimage_bundle::DisjointSets;

use crate::base::graph::{EdgeGraph, Paths, Wave};
use crate::base::halfedge;
use crate::base::order;
use crate::base::surface::Surface;
use crate::error::Result;
use crate::stage::border::Border;
use crate::stage::image::{ImageOptions, Maker};
use crate::stage::layout::StandIn;
use disk::Disk;

/// The surface as the cutter sees it: made once, cut many times.
pub(crate) struct Cutter<'a> {
    pub(crate) surface: &'a Surface,
    pub(crate) graph: EdgeGraph,
    /// The loops of boundary vertices, longest first.
    loops: Vec<Vec<u32>>,
    euler: i64,
    /// The length a unit of length counts for at each vertex; all ones unless set.
    pub(crate) wanted: Vec<f64>,
}

/// Edges to cut along.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cut {
    /// For each edge of the graph, whether it is cut.
    pub edges: Vec<bool>,
}

impl Cut {
    /// Summed length of the cut edges \[m\].
    pub(crate) fn length(&self, graph: &EdgeGraph) -> f64 {
        self.edges.iter().zip(&graph.length).filter(|(c, _)| **c).map(|(_, l)| l).sum::<f64>() + 0.0
    }
}

/// Size, kind and gain of a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutRecord {
    /// Length of the cut paths \[m\].
    pub length: f64,
    /// Edges cut.
    pub edges: u32,
    /// Points the cut was grown to.
    pub grown: usize,
    /// The cut follows UV seams.
    pub uv_seams: bool,
    /// Mean of ln(density / 4) of a coarse stand-in with the shortest cut, and with the cut grown.
    pub bought: Option<[f64; 2]>,
}

/// A surface cut open to a disk, and the structure of its border.
#[derive(Clone, Debug)]
pub struct OpenSurface {
    /// The disk.
    pub disk: Disk,
    /// The paths of its boundary.
    pub border: Border,
    /// Size, kind and gain of the cut.
    pub cut: CutRecord,
    /// The stand-in of the disk that layouts are searched on, once there is one.
    pub(crate) stand_in: StandIn,
}

/// Boundary loops and Euler number that an image of a surface must weld back to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loops {
    /// For each vertex the boundary loop it lies on, longest first, or [`disk::NONE`].
    pub rim: Vec<u32>,
    /// Lengths of the loops \[m\], longest first.
    pub lengths: Vec<f64>,
    /// Vertices - edges + triangles.
    pub euler: i64,
}

impl Loops {
    pub(crate) fn of(cutter: &Cutter<'_>) -> Self {
        let mut rim = vec![disk::NONE; cutter.surface.positions.len()];
        for (k, l) in cutter.loops().iter().enumerate() {
            l.iter().for_each(|&v| rim[v as usize] = k as u32);
        }
        Self { rim, lengths: cutter.loop_lengths(), euler: cutter.euler() }
    }

    /// The loops of a surface. `None` if it is empty or not a manifold.
    pub fn new(surface: &Surface) -> Option<Self> {
        Cutter::new(surface).map(|cutter| Self::of(&cutter))
    }
}

/// Cuts a connected surface open in each way worth laying out: along UV seams or not, as the options say, and grown into
/// limbs. `uv_seam` tells the half-edges on UV seams, if the surface has any.
///
/// Errors: [`crate::Error::Piece`] with `name` where the surface is not a manifold.
pub fn cuts(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
) -> Result<Vec<OpenSurface>> {
    Ok(Maker::new(name, surface, uv_seam, options)?.cuts(true)?.candidates)
}

/// Cost of an edge on a UV seam, as a share of its length.
pub(crate) const SEAM_DISCOUNT: f64 = 0.15;

/// The growing cut: its edges and every vertex on it or on the boundary.
struct Growing<'a> {
    graph: &'a EdgeGraph,
    edges: Vec<bool>,
    tree: Vec<bool>,
}

impl Growing<'_> {
    fn add(&mut self, paths: &Wave, end: u32) {
        for (v, e) in paths.back(end) {
            self.tree[v as usize] = true;
            if e != crate::base::graph::NONE && !self.graph.is_boundary(e as usize) {
                self.edges[e as usize] = true;
            }
        }
    }

    fn members(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tree.len() as u32).filter(|&v| self.tree[v as usize])
    }
}

impl<'a> Cutter<'a> {
    /// Prepares a connected surface. `None` if it is empty or not edge-manifold with one fan a vertex.
    pub(crate) fn new(surface: &'a Surface) -> Option<Self> {
        if surface.triangles.is_empty() {
            return None;
        }
        let twin = halfedge::twins(&surface.triangles).ok()?;
        let mut loops = halfedge::boundary_loops(&surface.triangles, &twin)?;
        let mut keyed: Vec<_> = loops.drain(..).map(|l| (loop_length(surface, &l), l)).collect();
        keyed.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        let graph = EdgeGraph::new(&surface.positions, &surface.triangles);
        let used = surface.positions.len() as i64;
        let euler = used - graph.ends.len() as i64 + surface.triangles.len() as i64;
        let wanted = vec![1.0; surface.positions.len()];
        Some(Self { surface, graph, loops: keyed.into_iter().map(|x| x.1).collect(), euler, wanted })
    }

    /// Boundary loops, longest first.
    pub(crate) fn loops(&self) -> &[Vec<u32>] {
        &self.loops
    }

    /// Their lengths \[m\].
    pub(crate) fn loop_lengths(&self) -> Vec<f64> {
        self.loops.iter().map(|l| loop_length(self.surface, l)).collect()
    }

    /// Vertices - edges + triangles.
    pub(crate) fn euler(&self) -> i64 {
        self.euler
    }

    /// Independent handles (twice the genus) or cross-caps that a cut has to open.
    pub(crate) fn handles(&self) -> usize {
        (2 - self.euler - self.loops.len() as i64).max(0) as usize
    }

    /// Cuts to a disk along cheap edges; `cost` is one positive number an edge. `terminals` are vertices that the cut
    /// must reach. O(L n log n) for L loops and terminals.
    pub(crate) fn cut(&self, cost: &[f64], terminals: &[u32]) -> Cut {
        let cost = &order::whole(cost);
        let graph = &self.graph;
        let n = graph.vertices();
        let mut grow = Growing { graph, edges: vec![false; graph.ends.len()], tree: vec![false; n] };
        let mut keep = vec![false; n];
        if self.loops.is_empty() {
            if self.handles() == 0 {
                let (a, b) = self.far_pair(cost);
                (keep[a as usize], keep[b as usize]) = (true, true);
                let mut paths = Paths::new(graph, cost, [a]);
                paths.next(|v| v == b);
                grow.add(&paths.wave, b);
                if paths.wave.via[b as usize].0 == a {
                    // A slit of one edge does not open: its two sides would have the same two ends.
                    let others = graph.neighbours(b).iter().filter(|x| x.0 != a);
                    if let Some(&(c, e)) = others.min_by(|x, y| cost[x.1 as usize].total_cmp(&cost[y.1 as usize])) {
                        (grow.edges[e as usize], grow.tree[c as usize], keep[c as usize]) = (true, true, true);
                    }
                }
            } else {
                grow = self.best_rooted(cost);
            }
        } else {
            self.join_loops(cost, &mut grow);
            if self.handles() > 0 {
                self.open_handles(cost, &mut grow);
            }
        }
        for &t in terminals {
            keep[t as usize] = true;
            if !grow.tree[t as usize] {
                // From the terminal outwards: it is near the tree more often than not.
                let mut paths = Paths::new(graph, cost, [t]);
                if let Some(hit) = paths.next(|v| grow.tree[v as usize]) {
                    grow.add(&paths.wave, hit);
                }
            }
        }
        prune(graph, &mut grow.edges, &keep);
        Cut { edges: grow.edges }
    }

    /// Two vertices far apart, by a double sweep from the one nearest to the middle.
    fn far_pair(&self, cost: &[f64]) -> (u32, u32) {
        let p = &self.surface.positions;
        let n = p.len().max(1) as f64;
        let middle = p.iter().fold([0.0; 3], |m, q| crate::base::vec3::add(m, crate::base::vec3::scale(*q, 1.0 / n)));
        let mut a = (0..p.len() as u32)
            .min_by(|&i, &j| {
                let d = |v: u32| crate::base::vec3::distance(p[v as usize], middle);
                d(i).total_cmp(&d(j)).then(i.cmp(&j))
            })
            .unwrap_or(0);
        let mut b = a;
        for _ in 0..3 {
            let far = Paths::all(&self.graph, cost, [b]).farthest().unwrap_or(b);
            (a, b) = (b, far);
        }
        (a, b)
    }

    /// Joins all boundary loops into one tree, nearest first (Prim), from the longest.
    fn join_loops(&self, cost: &[f64], grow: &mut Growing<'_>) {
        let mut loop_of = vec![u32::MAX; self.graph.vertices()];
        for (k, l) in self.loops.iter().enumerate() {
            l.iter().for_each(|&v| loop_of[v as usize] = k as u32);
        }
        let mut done = vec![false; self.loops.len()];
        let mut near = Paths::new(&self.graph, cost, []);
        let mut take = 0usize;
        for _ in 1..self.loops.len() {
            done[take] = true;
            self.loops[take].iter().for_each(|&v| near.wave.source(v));
            let open = |v: u32| loop_of[v as usize] != u32::MAX && !done[loop_of[v as usize] as usize];
            let Some(hit) = near.next(open) else { break };
            grow.add(&near.wave, hit);
            for (v, _) in near.wave.back(hit) {
                near.wave.source(v);
            }
            take = loop_of[hit as usize] as usize;
        }
        self.loops.iter().flatten().for_each(|&v| grow.tree[v as usize] = true);
    }

    /// Opens handles and cross-caps: the edges in neither a primal shortest-path tree nor a dual spanning tree, each
    /// with its two paths back to the tree.
    fn open_handles(&self, cost: &[f64], grow: &mut Growing<'_>) {
        let graph = &self.graph;
        let sources: Vec<u32> = grow.members().collect();
        let paths = Paths::all(graph, cost, sources);
        let mut primal = grow.edges.clone();
        for (e, p) in primal.iter_mut().enumerate() {
            *p |= graph.is_boundary(e);
        }
        for &(p, e) in &paths.via {
            if p != crate::base::graph::NONE {
                primal[e as usize] = true;
            }
        }
        // The dual tree takes the edges that would close the longest loops, so that short loops are left over.
        let mut order: Vec<(f64, u32)> = (0..graph.ends.len())
            .filter(|&e| !primal[e])
            .map(|e| {
                let [a, b] = graph.ends[e].map(|v| paths.distance[v as usize]);
                (a + b + cost[e], e as u32)
            })
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut sets = DisjointSets::new(self.surface.triangles.len());
        let mut left = Vec::new();
        for (_, e) in order {
            let [a, b] = graph.halves[e as usize].map(|h| h / 3);
            if !sets.union(a, b) {
                left.push(e);
            }
        }
        for e in left {
            grow.edges[e as usize] = true;
            for v in graph.ends[e as usize] {
                grow.add(&paths, v);
            }
        }
    }

    /// A closed surface with handles: the shortest system of loops over a few spread-out roots.
    fn best_rooted(&self, cost: &[f64]) -> Growing<'_> {
        const ROOTS: usize = 8;
        let n = self.graph.vertices();
        let mut roots = vec![self.far_pair(cost).0];
        while roots.len() < ROOTS.min(n) {
            let paths = Paths::all(&self.graph, cost, roots.iter().copied());
            match paths.farthest() {
                Some(v) if !roots.contains(&v) => roots.push(v),
                _ => break,
            }
        }
        let mut best: Option<(f64, Growing<'_>)> = None;
        for r in roots {
            let mut grow =
                Growing { graph: &self.graph, edges: vec![false; self.graph.ends.len()], tree: vec![false; n] };
            grow.tree[r as usize] = true;
            self.open_handles(cost, &mut grow);
            prune(&self.graph, &mut grow.edges, &vec![false; n]);
            let total: f64 = grow.edges.iter().zip(cost).filter(|(c, _)| **c).map(|(_, l)| l).sum();
            if best.as_ref().is_none_or(|b| total < b.0) {
                best = Some((total, grow));
            }
        }
        let mut grow = best.map(|b| b.1).unwrap_or_else(|| Growing {
            graph: &self.graph,
            edges: vec![false; self.graph.ends.len()],
            tree: vec![false; n],
        });
        grow.tree.iter_mut().for_each(|t| *t = false);
        for (e, _) in grow.edges.iter().enumerate().filter(|(_, c)| **c) {
            self.graph.ends[e].iter().for_each(|&v| grow.tree[v as usize] = true);
        }
        grow
    }
}

fn loop_length(surface: &Surface, l: &[u32]) -> f64 {
    let at = |i: usize| surface.positions[l[i % l.len()] as usize];
    (0..l.len()).map(|i| crate::base::vec3::distance(at(i), at(i + 1))).sum()
}

/// Takes away dead ends of the cut that lead to no boundary and no vertex to keep.
pub(crate) fn prune(graph: &EdgeGraph, edges: &mut [bool], keep: &[bool]) {
    let mut degree = vec![0u32; graph.vertices()];
    let mut boundary = vec![false; graph.vertices()];
    for (e, &is_cut) in edges.iter().enumerate() {
        if graph.is_boundary(e) {
            graph.ends[e].iter().for_each(|&v| boundary[v as usize] = true);
        } else if is_cut {
            graph.ends[e].iter().for_each(|&v| degree[v as usize] += 1);
        }
    }
    let dead = |v: u32, degree: &[u32]| degree[v as usize] == 1 && !boundary[v as usize] && !keep[v as usize];
    let mut stack: Vec<u32> = (0..graph.vertices() as u32).filter(|&v| dead(v, &degree)).collect();
    while let Some(v) = stack.pop() {
        if !dead(v, &degree) {
            continue;
        }
        for &(w, e) in graph.neighbours(v) {
            if edges[e as usize] {
                edges[e as usize] = false;
                degree[v as usize] -= 1;
                degree[w as usize] -= 1;
                if dead(w, &degree) {
                    stack.push(w);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::stage::cut::disk;
    use proptest::prelude::*;

    /// Cuts, opens, and checks what every cut must keep: terminals on the boundary and no other dead ends.
    fn check(s: &Surface, terminals: &[u32]) -> Cut {
        let cutter = Cutter::new(s).unwrap();
        let cut = cutter.cut(&cutter.graph.length, terminals);
        let disk = disk::open(&cutter, &cut).unwrap();
        let mut on = vec![false; s.positions.len()];
        disk.boundary.iter().for_each(|&v| on[disk.origin[v as usize] as usize] = true);
        assert!(terminals.iter().all(|&t| on[t as usize]), "a terminal is not on the boundary");
        let mut degree = vec![0; s.positions.len()];
        for (e, _) in cut.edges.iter().enumerate().filter(|(_, c)| **c) {
            assert!(!cutter.graph.is_boundary(e));
            cutter.graph.ends[e].iter().for_each(|&v| degree[v as usize] += 1);
        }
        let rim = shapes::rim(s);
        let ends = (0..degree.len()).filter(|&v| degree[v] == 1 && !rim[v] && !terminals.contains(&(v as u32))).count();
        assert!(ends <= if cutter.euler() == 2 { 2 } else { 0 }, "{ends} dead ends");
        assert_eq!(cut, cutter.cut(&cutter.graph.length, terminals));
        cut
    }

    #[test]
    fn every_shape_opens_to_a_disk() {
        for (_, s) in shapes::all() {
            check(&s, &[]);
            let mut draw = shapes::random(9);
            let terminals: Vec<u32> = (0..4).map(|_| draw(s.positions.len()) as u32).collect();
            check(&s, &terminals);
        }
    }

    #[test]
    fn the_shapes_are_what_they_are_called() {
        for (name, euler, loops) in [
            ("triangle", 1, 1),
            ("holed", -8, 10),
            ("tube", 0, 2),
            ("sphere", 2, 0),
            ("tetrahedron", 2, 0),
            ("torus", 0, 0),
            ("double torus", -2, 0),
            ("genus 4", -6, 0),
            ("torus with holes", -3, 3),
            ("moebius", 0, 1),
            ("klein", 0, 0),
            ("projective plane", 1, 0),
            ("projective plane with holes", -1, 2),
        ] {
            let s = shapes::all().into_iter().find(|x| x.0 == name).unwrap().1;
            let c = Cutter::new(&s).unwrap();
            assert_eq!((c.euler(), c.loops().len()), (euler, loops), "{name}");
        }
    }

    #[test]
    fn an_empty_surface_is_refused() {
        assert!(Cutter::new(&Surface::default()).is_none());
    }

    #[test]
    fn a_tube_is_cut_straight_and_along_discounted_edges() {
        let s = shapes::tube(12, 8, 0.7);
        let cutter = Cutter::new(&s).unwrap();
        let cut = cutter.cut(&cutter.graph.length, &[]);
        assert!((cut.length(&cutter.graph) - 0.7).abs() < 1e-12);
        for column in [0, 5] {
            let on = |v: u32| v % 12 == column;
            let cost: Vec<f64> = cutter
                .graph
                .ends
                .iter()
                .zip(&cutter.graph.length)
                .map(|(e, l)| if e.iter().all(|&v| on(v)) { 0.15 * l } else { *l })
                .collect();
            let cut = cutter.cut(&cost, &[]);
            assert_eq!(cut.edges.iter().filter(|c| **c).count(), 8);
            let along = |e: usize| cutter.graph.ends[e].iter().all(|&v| on(v));
            assert!((0..cut.edges.len()).all(|e| !cut.edges[e] || along(e)));
        }
    }

    #[test]
    fn hundreds_of_loops_are_joined_by_a_tree_of_paths() {
        let s = shapes::holed(20);
        let cutter = Cutter::new(&s).unwrap();
        assert_eq!(cutter.loops().len(), 401);
        let cut = check(&s, &[]);
        // Neighbouring holes are two cells apart, and the outer rim is one or two from the nearest.
        assert!(cut.length(&cutter.graph) <= 400.0 * 2.0 / 81.0 + 1e-9);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn random_blobs_open_to_a_disk(seed in any::<u64>(), cells in 1usize..120, holes in 0usize..30, many in 0usize..5) {
            let s = shapes::blob(seed, cells, holes);
            prop_assume!(!s.triangles.is_empty());
            let mut draw = shapes::random(seed);
            let terminals: Vec<u32> = (0..many).map(|_| draw(s.positions.len()) as u32).collect();
            check(&s, &terminals);
        }
    }
}
