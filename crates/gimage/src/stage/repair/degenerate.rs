//! Removes triangles without area, without opening the surface.
//!
//! A triangle that names a vertex twice just goes: its neighbours share its edge already. One whose vertices differ has
//! neighbours on all three sides, and dropping it would leave a crack. A needle (two vertices at one place) goes by
//! joining these two; a cap (a vertex on the opposite edge) goes by splitting whatever lies across that edge at that
//! vertex. Longest edges go first: then a split only ever makes triangles with shorter edges, and the work ends.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use gimage_bundle::DisjointSets;

use super::split_edge::split_edge;
use super::work::Work;
use crate::base::halfedge::sorted_edges;
use crate::base::vec3::{cross, dot, norm, scale, sub};
use crate::base::words;
use crate::record::Severity;

/// Height over longest edge at which a triangle counts as having no area. Far under what single precision can place on
/// a line, so slivers that a file can express survive.
const FLAT: f64 = 1e-10;

/// Heights under this many rounding errors of the coordinates mean nothing.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Rounds of joining and splitting before what is left is dropped.
const ROUNDS: usize = 16;

/// The shape of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Sound,
    /// The edge from this corner to the next has no length.
    Needle(usize),
    /// This corner lies on the opposite edge, which has this length \[m\].
    Cap(usize, f64),
}

fn shape(p: [[f64; 3]; 3]) -> Shape {
    let mut edges = [sub(p[1], p[0]), sub(p[2], p[1]), sub(p[0], p[2])];
    let size = edges.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    if size == 0.0 {
        return Shape::Needle(0);
    }
    // Scaled, so that no size of garment under- or overflows.
    edges = edges.map(|e| e.map(|x| x / size));
    let length = edges.map(norm);
    let order = |a: &usize, b: &usize| length[*a].total_cmp(&length[*b]);
    let longest = (0..3).max_by(order).unwrap_or(0);
    let shortest = (0..3).min_by(order).unwrap_or(0);
    let height = norm(cross(edges[shortest], edges[longest])) / length[longest];
    let coordinate = p.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let tolerance = (FLAT * length[longest]).max(ROUNDING * (coordinate / size));
    if height > tolerance {
        Shape::Sound
    } else if length[shortest] <= tolerance {
        Shape::Needle(shortest)
    } else {
        Shape::Cap((longest + 2) % 3, length[longest] * size)
    }
}

/// Drops triangles that name a vertex twice. O(n).
pub(super) fn drop_collapsed(work: &mut Work) {
    let keep: Vec<bool> = work.mesh.triangles.iter().map(|[a, b, c]| a != b && b != c && c != a).collect();
    let examples = (0..work.len()).filter(|&t| !keep[t]).take(4).map(|t| work.triangle_words(t)).collect();
    let count = work.retain(&keep);
    let message = format!("{} with two corners at one vertex dropped", words::triangles(count));
    work.report(Severity::Repair, "collapsed-faces", count, examples, message);
}

/// How the flat triangles went.
#[derive(Default)]
struct Tally {
    joined: usize,
    split: usize,
    rim: usize,
    dropped: usize,
}

/// Removes triangles without area. O(n log n) for few of them.
pub(super) fn remove_flat(work: &mut Work) {
    let flat: Vec<usize> = (0..work.len()).filter(|&t| shape(work.mesh.corners(t)) != Shape::Sound).collect();
    if flat.is_empty() {
        return;
    }
    let examples = flat.iter().take(4).map(|&t| work.triangle_words(t)).collect();
    let limit = 4 * work.len() + 64;
    let mut tally = Tally::default();
    for round in 0..=ROUNDS {
        tally.joined += join_needles(work);
        let keep: Vec<bool> = work.mesh.triangles.iter().map(|[a, b, c]| a != b && b != c && c != a).collect();
        work.retain(&keep);
        let keep: Vec<bool> = (0..work.len()).map(|t| shape(work.mesh.corners(t)) == Shape::Sound).collect();
        if keep.iter().all(|&k| k) {
            break;
        } else if round == ROUNDS || work.len() >= limit {
            tally.dropped += work.retain(&keep);
        } else {
            Caps::new(work).remove(limit, &mut tally);
        }
    }
    let mut message = format!(
        "{} without area removed: {} without length joined, {} split off across the long edge, {} taken from a rim",
        words::triangles(flat.len()),
        words::edges(tally.joined),
        words::triangles(tally.split),
        tally.rim
    );
    if tally.dropped > 0 {
        message += &format!(", {} dropped, which may leave cracks", tally.dropped);
    }
    work.report(Severity::Repair, "zero-area-faces", flat.len(), examples, message);
}

/// Joins the close vertices of needles; the smallest index stays. Returns how many went.
fn join_needles(work: &mut Work) -> usize {
    let mut sets = DisjointSets::new(work.mesh.positions.len());
    let mut joined = 0;
    for t in 0..work.len() {
        if let Shape::Needle(c) = shape(work.mesh.corners(t)) {
            let v = work.mesh.triangles[t];
            joined += usize::from(sets.union(v[c], v[(c + 1) % 3]));
        }
    }
    if joined > 0 {
        work.rename(|v| sets.find(v));
    }
    joined
}

/// A cap in the queue: longest edge first, then the smallest triangle.
#[derive(PartialEq)]
struct Entry(f64, usize);

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

/// One round of removing caps.
struct Caps<'a> {
    work: &'a mut Work,
    alive: Vec<bool>,
    /// All edges as the round began; triangles are looked at again before an entry is believed.
    edges: Vec<(u32, u32, u32)>,
    /// Edges that came since, with their triangles.
    added: HashMap<[u32; 2], Vec<u32>>,
    queue: BinaryHeap<Entry>,
}

impl<'a> Caps<'a> {
    fn new(work: &'a mut Work) -> Self {
        let edges = sorted_edges(&work.mesh.triangles);
        let alive = vec![true; work.len()];
        let mut caps = Caps { work, alive, edges, added: HashMap::new(), queue: BinaryHeap::new() };
        (0..caps.work.len()).for_each(|t| caps.enqueue(t));
        caps
    }

    fn enqueue(&mut self, t: usize) {
        if let Shape::Cap(_, length) = shape(self.work.mesh.corners(t)) {
            self.queue.push(Entry(length, t));
        }
    }

    fn remove(mut self, limit: usize, tally: &mut Tally) {
        while let Some(Entry(key, t)) = self.queue.pop() {
            if !self.alive[t] {
                continue;
            }
            let Shape::Cap(apex, length) = shape(self.work.mesh.corners(t)) else { continue };
            if length != key {
                continue;
            }
            if self.work.len() >= limit {
                break;
            }
            let v = self.work.mesh.triangles[t];
            let [c, a, b] = [v[apex], v[(apex + 1) % 3], v[(apex + 2) % 3]];
            self.alive[t] = false;
            let across = self.across(a, b);
            *if across.is_empty() { &mut tally.rim } else { &mut tally.split } += 1;
            for u in across {
                if self.work.mesh.triangles[u].contains(&c) {
                    // The same three vertices again: both go, and what lies beyond them meets.
                    self.alive[u] = false;
                    continue;
                }
                let share = self.share(a, b, c);
                let new = split_edge(self.work, u, [a, b], t, apex, share);
                self.alive.push(true);
                let d = self.work.mesh.triangles[u].iter().copied().find(|&d| d != a && d != c).unwrap_or(c);
                for (edge, tri) in [([a, c], u), ([c, d], u), ([c, b], new), ([b, d], new), ([c, d], new)] {
                    self.added.entry([edge[0].min(edge[1]), edge[0].max(edge[1])]).or_default().push(tri as u32);
                }
                self.enqueue(u);
                self.enqueue(new);
            }
        }
        self.work.retain(&self.alive);
    }

    /// How far from `a` to `b` vertex `c` lies, 0..=1.
    fn share(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|v| self.work.mesh.positions[v as usize]);
        let (edge, out) = (sub(b, a), sub(c, a));
        let size = norm(edge);
        let s = dot(scale(out, 1.0 / size), scale(edge, 1.0 / size));
        if s.is_finite() { s.clamp(0.0, 1.0) } else { 0.5 }
    }

    /// The live triangles on the edge between `a` and `b`, in order.
    fn across(&self, a: u32, b: u32) -> Vec<usize> {
        let key = [a.min(b), a.max(b)];
        let from = self.edges.partition_point(|e| [e.0, e.1] < key);
        let old = self.edges[from..].iter().take_while(|e| [e.0, e.1] == key).map(|e| e.2 / 3);
        let new = self.added.get(&key).into_iter().flatten().copied();
        let has = |t: usize| self.alive[t] && key.iter().all(|v| self.work.mesh.triangles[t].contains(v));
        let mut out: Vec<usize> = old.chain(new).map(|t| t as usize).filter(|&t| has(t)).collect();
        out.sort_unstable();
        out.dedup();
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::halfedge::{boundary_loops, euler, twins};
    use crate::base::mesh::Mesh;

    fn flat(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Work {
        let mut w = Work::new(Mesh { positions, triangles, ..Default::default() });
        drop_collapsed(&mut w);
        remove_flat(&mut w);
        w
    }

    #[test]
    fn shapes() {
        let s = |a, b, c| shape([a, b, c]);
        assert_eq!(s([0., 0., 0.], [1., 0., 0.], [1., 1e-6, 0.]), Shape::Sound);
        assert_eq!(s([0., 0., 0.], [1e-200, 0., 0.], [0., 1e-200, 0.]), Shape::Sound);
        assert_eq!(s([1e6, 1e6, 1e6], [1e6 + 0.01, 1e6, 1e6], [1e6, 1e6 + 0.01, 1e6]), Shape::Sound);
        assert_eq!(s([0., 0., 0.], [2., 0., 0.], [1., 1e-13, 0.]), Shape::Cap(2, 2.0));
        assert_eq!(s([0., 0., 0.], [2., 0., 0.], [2., 1e-13, 0.]), Shape::Needle(1));
        assert_eq!(s([3.; 3], [3.; 3], [3.; 3]), Shape::Needle(0));
    }

    #[test]
    fn a_cap_splits_its_neighbour_and_leaves_no_crack() {
        // A square in four around a centre that lies on the diagonal of another half: 0 1 2 3, cap 0 2 4.
        let p = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 0.]];
        let w = flat(p, vec![[0, 1, 2], [0, 2, 4], [0, 4, 3], [4, 2, 3]]);
        assert_eq!(w.mesh.triangles, [[0, 1, 4], [0, 4, 3], [4, 2, 3], [4, 1, 2]]);
        let twin = twins(&w.mesh.triangles).unwrap();
        assert_eq!(boundary_loops(&w.mesh.triangles, &twin).unwrap(), [[0, 1, 2, 3]]);
        assert_eq!(w.findings[0].count, 1);
    }

    #[test]
    fn a_needle_is_joined() {
        let p = vec![[0., 0., 0.], [1., 0., 0.], [1., 1e-14, 0.], [0., 1., 0.], [0.5, -1., 0.]];
        let w = flat(p, vec![[0, 1, 2], [0, 2, 3], [1, 0, 4]]);
        assert_eq!(w.mesh.triangles, [[0, 1, 3], [1, 0, 4]]);
    }

    #[test]
    fn a_stack_of_caps_goes_whole() {
        // A line of five vertices, triangulated, between two proper triangles.
        let mut p: Vec<[f64; 3]> = (0..5).map(|i| [f64::from(i), 0., 0.]).collect();
        p.extend([[2., 3., 0.], [2., -3., 0.]]);
        let fan = [[0, 5, 1], [1, 5, 2], [2, 5, 3], [3, 5, 4]].map(|[a, b, c]| [a, c, b]);
        let mut t = vec![[0, 6, 4], [0, 4, 2], [0, 2, 1], [2, 4, 3]];
        t.extend(fan);
        let w = flat(p, t);
        assert_eq!(w.len(), 8);
        assert_eq!(euler(&w.mesh.triangles), 1);
        let twin = twins(&w.mesh.triangles).unwrap();
        assert_eq!(boundary_loops(&w.mesh.triangles, &twin).unwrap().len(), 1);
        assert!((0..8).all(|t| shape(w.mesh.corners(t)) == Shape::Sound));
    }

    #[test]
    fn nothing_but_a_line_leaves_nothing() {
        let p = (0..9).map(|i| [f64::from(i * i), 0., 0.]).collect();
        let w = flat(p, (0..7).map(|i| [i, i + 1, i + 2]).collect());
        assert_eq!(w.len(), 0);
    }
}
