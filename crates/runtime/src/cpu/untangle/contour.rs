//! Joins the edges that pierce faces to contours: the lines along which two sheets, or two parts of one, cross.

use super::net::Net;
use super::pierce::Hit;

/// Two sheets cross along a contour. A sheet is 0 or 1.
#[derive(Clone, Debug, Default)]
pub struct Contour {
    /// For each sheet the hits whose edge is of it, and whose face is of the other one, by number.
    pub hits: [Vec<u32>; 2],
}

/// The contours of all hits, in the order of their first hits. Two hits follow one another on a contour if they are the ends of the line in
/// which two triangles meet.
pub fn contours(net: &Net, hits: &[Hit]) -> Vec<Contour> {
    // For each end of such a line the two triangles, the lower number first, the hit, and which of both has the edge.
    let mut ends: Vec<([u32; 2], u32, bool)> = Vec::new();
    for (n, hit) in hits.iter().enumerate() {
        let pair = |own: u32| ([own.min(hit.face), own.max(hit.face)], n as u32, own < hit.face);
        ends.extend(net.faces_at(hit.edge as usize).map(pair));
    }
    ends.sort_unstable();
    let mut joined = Joined::new(hits.len());
    for both in ends.chunk_by(|a, b| a.0 == b.0) {
        both.windows(2).for_each(|w| joined.join(w[0].1, w[1].1, w[0].2 != w[1].2));
    }
    let mut index = vec![u32::MAX; hits.len()];
    let mut found: Vec<Contour> = Vec::new();
    for n in 0..hits.len() as u32 {
        let (first, other) = joined.first(n);
        let at = &mut index[first as usize];
        if *at == u32::MAX {
            *at = found.len() as u32;
            found.push(Contour::default());
        }
        found[*at as usize].hits[usize::from(other)].push(n);
    }
    found
}

/// Sets of hits, each with whether its edge is of the other sheet than that of the hit before it.
struct Joined {
    before: Vec<(u32, bool)>,
}

impl Joined {
    fn new(count: usize) -> Self {
        Joined { before: (0..count as u32).map(|n| (n, false)).collect() }
    }

    /// The first hit of a set, and whether the edge of hit `n` is of the other sheet than that of the first one.
    fn first(&mut self, n: u32) -> (u32, bool) {
        let (mut at, mut other) = (n, false);
        while self.before[at as usize].0 != at {
            let (next, differs) = self.before[at as usize];
            (at, other) = (next, other ^ differs);
        }
        // The way is shorter the next time.
        self.before[n as usize] = (at, other);
        (at, other)
    }

    /// Joins two sets. A contour on which sheets change places, as on a strip with one side, keeps those found first.
    fn join(&mut self, a: u32, b: u32, differ: bool) {
        let ((a, of_a), (b, of_b)) = (self.first(a), self.first(b));
        if a != b {
            self.before[a.max(b) as usize] = (a.min(b), of_a ^ of_b ^ differ);
        }
    }
}
