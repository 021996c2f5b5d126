//! Contours that stay where they are although points move: pins, colliders or rest lengths keep them so.

use super::contour::Contour;
use super::net::Net;
use super::pierce::Hit;
use crate::memory::Tally;

/// Time \[s\] for which the same points cross until their contour is left alone, and until it is moved again.
const STUCK_S: f64 = 1.0;
const AGAIN_S: f64 = 2.0;

/// For how long the same points cross.
#[derive(Default)]
pub struct Ages {
    /// For each point \[s\]; no list until time has passed.
    seconds: Vec<f32>,
    /// Points of edges and faces that pierced one another in the last look, some of them more than once.
    crossing: Vec<u32>,
}

impl Ages {
    /// Every contour is a new one.
    pub fn forget(&mut self) {
        *self = Ages::default();
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.seconds);
        tally.state(&self.crossing);
    }

    /// Takes in what crosses.
    pub fn see(&mut self, net: &Net, hits: &[Hit]) {
        self.crossing.clear();
        self.crossing.extend(hits.iter().flat_map(|hit| points(net, hit)));
    }

    /// Lets time \[s\] pass for `count` points.
    pub fn pass(&mut self, count: usize, seconds: f64) {
        self.crossing.sort_unstable();
        self.crossing.dedup();
        self.seconds.resize(count, 0.0);
        let mut crossing = self.crossing.iter().peekable();
        for (point, age) in self.seconds.iter_mut().enumerate() {
            let crosses = crossing.next_if(|next| **next as usize == point).is_some();
            // A point that crosses now and then is not a new one.
            let new = if crosses { f64::from(*age) + seconds } else { (f64::from(*age) - seconds).max(0.0) };
            *age = if new < AGAIN_S { new as f32 } else { 0.0 };
        }
    }

    /// Whether most points of a contour have crossed for long.
    pub fn is_stuck(&self, net: &Net, hits: &[Hit], contour: &Contour) -> bool {
        let (mut old, mut all) = (0, 0);
        for hit in contour.hits.iter().flatten().map(|n| &hits[*n as usize]) {
            let ages = points(net, hit).map(|point| self.seconds.get(point as usize).copied().unwrap_or_default());
            let (stays, count) = ages.fold((0, 0), |(n, of), age| (n + i32::from(f64::from(age) >= STUCK_S), of + 1));
            (old, all) = (old + stays, all + count);
        }
        2 * old > all
    }
}

/// The ends of an edge that pierces a face, and the corners of the face.
fn points(net: &Net, hit: &Hit) -> impl Iterator<Item = u32> {
    net.edges[hit.edge as usize].into_iter().chain(net.faces[hit.face as usize])
}
