//! Decides which triangles stay joined across each edge.
//!
//! Where three or more triangles meet in an edge, the straightest pair goes on as one sheet, then the straightest of the
//! rest, and so on: a pocket sewn on a shirt comes off, the shirt stays whole. A triangle that had a reversed copy comes
//! last: where it was a fin folded flat on a sheet, the sheet closes under it. Where sheets with one side come out, as from a pocket that is joined to the
//! shirt by both of its sides, only triangles that wind alike stay joined there.

use std::collections::HashSet;
use std::f64::consts::TAU;

use super::orient::one_sided;
use super::work::Work;
use crate::base::halfedge::{BOUNDARY, next, origin, prev, sorted_edges, target};
use crate::base::vec3::{cross, dot, normalize, scale, sub};

/// Loss of a pair that runs the same way along the edge against one that runs opposite ways, on the scale of the
/// cosine of the angle between them (-1 is flat).
const SAME_WAY: f64 = 0.5;

/// Loss of a pair with a triangle that had a reversed copy: more than any angle is worth.
const DOUBLED: f64 = 4.0;

/// Up to this many triangles on an edge all pairs are weighed.
const ALL_PAIRS: usize = 64;

/// Which half-edges stay joined.
pub(super) struct Gluing {
    /// For each half-edge the one it is joined to, or [`BOUNDARY`].
    pub twin: Vec<u32>,
    /// The half-edges of each edge that has three or more: pair by pair, straightest first, then the one left over.
    pub crowded: Vec<Vec<u32>>,
}

impl Gluing {
    /// Joins two half-edges.
    pub fn join(&mut self, a: u32, b: u32) {
        self.twin[a as usize] = b;
        self.twin[b as usize] = a;
    }

    /// Makes `h` and what it was joined to boundary.
    pub fn part(&mut self, h: u32) {
        let t = std::mem::replace(&mut self.twin[h as usize], BOUNDARY);
        if t != BOUNDARY {
            self.twin[t as usize] = BOUNDARY;
        }
    }
}

/// Joins triangles across edges, at most two to an edge; `doubled` are those that had a reversed copy, by their index in
/// the input. O(n log n).
pub(super) fn glue(work: &Work, doubled: &HashSet<u32>) -> Gluing {
    let gluing = glue_alike(work, doubled, &[]);
    if gluing.crowded.is_empty() {
        return gluing;
    }
    let twisted = one_sided(work, &gluing);
    let count = |twisted: &[bool]| twisted.iter().filter(|twisted| **twisted).count();
    if count(&twisted) == 0 {
        return gluing;
    }
    let alike = glue_alike(work, doubled, &twisted);
    if count(&one_sided(work, &alike)) < count(&twisted) { alike } else { gluing }
}

/// The same, where across crowded edges of some triangles only those that wind alike are joined.
fn glue_alike(work: &Work, doubled: &HashSet<u32>, alike: &[bool]) -> Gluing {
    let mut gluing = Gluing { twin: vec![BOUNDARY; 3 * work.len()], crowded: Vec::new() };
    for run in sorted_edges(&work.mesh.triangles).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match run {
            [_] => {}
            [x, y] => gluing.join(x.2, y.2),
            _ => {
                let mut edge: Vec<u32> = run.iter().map(|x| x.2).collect();
                let alike = edge.iter().any(|h| alike.get(*h as usize / 3).is_some_and(|alike| *alike));
                let pairs = pairs(work, &edge, doubled, alike);
                for &[a, b] in &pairs {
                    gluing.join(a, b);
                }
                edge.retain(|&h| gluing.twin[h as usize] == BOUNDARY);
                gluing.crowded.push(pairs.into_iter().flatten().chain(edge).collect());
            }
        }
    }
    gluing
}

/// One triangle seen along the edge.
struct Flap {
    half_edge: u32,
    /// The third vertex: differs from flap to flap, so it settles ties whatever the order of triangles.
    apex: u32,
    /// Unit vector away from the edge, within the triangle.
    away: [f64; 3],
    forward: bool,
    doubled: bool,
}

/// Pairs of half-edges of one crowded edge, straightest first; only of triangles that wind alike, if asked for.
fn pairs(work: &Work, edge: &[u32], doubled: &HashSet<u32>, alike: bool) -> Vec<[u32; 2]> {
    let tri = &work.mesh.triangles;
    let position = |v: u32| work.mesh.positions[v as usize];
    let (o, t) = (origin(tri, edge[0]), target(tri, edge[0]));
    let [a, b] = [o.min(t), o.max(t)];
    let along = normalize(sub(position(b), position(a)));
    let mut flaps: Vec<Flap> = edge
        .iter()
        .map(|&h| {
            let apex = origin(tri, prev(h));
            let d = sub(position(apex), position(a));
            let away = normalize(sub(d, scale(along, dot(d, along))));
            let doubled = doubled.contains(&work.source[h as usize / 3]);
            Flap { half_edge: h, apex, away, forward: origin(tri, h) == a && origin(tri, next(h)) == b, doubled }
        })
        .collect();
    flaps.sort_by_key(|f| f.apex);
    if flaps.len() > ALL_PAIRS {
        return opposite_in_order(flaps, along);
    }
    let mut all = Vec::new();
    for i in 0..flaps.len() {
        for j in (i + 1..flaps.len()).filter(|j| !alike || flaps[i].forward != flaps[*j].forward) {
            let bend = dot(flaps[i].away, flaps[j].away);
            let same_way = if flaps[i].forward == flaps[j].forward { SAME_WAY } else { 0.0 };
            let doubled = if flaps[i].doubled || flaps[j].doubled { DOUBLED } else { 0.0 };
            all.push((bend + same_way + doubled, i, j));
        }
    }
    all.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut taken = vec![false; flaps.len()];
    let mut out = Vec::new();
    for (_, i, j) in all {
        if !taken[i] && !taken[j] {
            (taken[i], taken[j]) = (true, true);
            out.push([flaps[i].half_edge, flaps[j].half_edge]);
        }
    }
    out
}

/// For a great many triangles on one edge: in order around it, each with the one half the way on.
fn opposite_in_order(flaps: Vec<Flap>, along: [f64; 3]) -> Vec<[u32; 2]> {
    let x = flaps[0].away;
    let y = cross(along, x);
    let mut turn: Vec<(f64, u32)> =
        flaps.iter().map(|f| (dot(f.away, y).atan2(dot(f.away, x)).rem_euclid(TAU), f.half_edge)).collect();
    turn.sort_by(|p, q| p.0.total_cmp(&q.0));
    let half = turn.len() / 2;
    (0..half).map(|i| [turn[i].1, turn[i + half].1]).collect()
}
