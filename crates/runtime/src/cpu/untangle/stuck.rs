//! Contours that stay where they are although points move: pins, colliders or rest lengths keep them so.

use super::contour::Contour;
use super::net::Net;
use super::pierce::Hit;
use crate::memory::Tally;

/// Time \[s\] for which the contour of points that cross for the first time is moved, and for which it is moved again after twice this time, four times, and
/// so on: in between it is left alone.
const MOVED_S: f64 = 1.0;
/// Age \[s\] at which a point is taken for one of half the age, so that it is moved again.
const MAX_S: f64 = 64.0;

/// Whether a point of an age \[s\] is left alone.
fn rests(age: f64) -> bool {
    let again = age.max(MOVED_S).log2().floor().exp2();
    age >= MOVED_S && (again < 2.0 * MOVED_S || age - again >= MOVED_S)
}

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
            let old = f64::from(*age);
            // A point that crosses now and then is not a new one; one that has crossed for long becomes new within some seconds.
            let new = if crosses { old + seconds } else { old - seconds * (0.5 * old).max(1.0) };
            *age = if new < MAX_S { new.max(0.0) as f32 } else { 0.5 * MAX_S as f32 };
        }
    }

    /// Whether most points of a contour are left alone.
    pub fn is_stuck(&self, net: &Net, hits: &[Hit], contour: &Contour) -> bool {
        let (mut old, mut all) = (0, 0);
        for hit in contour.hits.iter().flatten().map(|n| &hits[*n as usize]) {
            let ages = points(net, hit).map(|point| self.seconds.get(point as usize).copied().unwrap_or_default());
            let (stays, count) = ages.fold((0, 0), |(n, of), age| (n + i32::from(rests(age.into())), of + 1));
            (old, all) = (old + stays, all + count);
        }
        2 * old > all
    }
}

/// The ends of an edge that pierces a face, and the corners of the face.
fn points(net: &Net, hit: &Hit) -> impl Iterator<Item = u32> {
    net.edges[hit.edge as usize].into_iter().chain(net.faces[hit.face as usize])
}
