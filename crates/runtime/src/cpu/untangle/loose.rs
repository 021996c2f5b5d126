//! Points near contours, which contact lets pass one another.

use super::Untangle;
use super::contour::Contour;
use super::pierce::Hit;
use super::side::Flood;

/// Rings of points around those of pierced faces and edges that are loose, of two cloths and of one: with more, cloth that contact does not push crosses
/// itself.
pub const RINGS: [usize; 2] = [2, 0];
/// The same for cloth that crossed in motion: contact is still the right one where no edge pierces a face.
pub const RINGS_IN_MOTION: [usize; 2] = [0, 0];
/// Rings around a contour at rest whose points keep the whole contact distance.
pub const RINGS_AT_REST: [usize; 2] = [8, 0];

/// Which points contact lets a point pass: those that are loose in the same way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Loose {
    /// Points of other cloths.
    pub others: bool,
    /// Points of its own cloth.
    pub own: bool,
}

impl Loose {
    /// Whether there is any.
    pub fn any(self) -> bool {
        self.others || self.own
    }
}

/// Marks points near contours as loose; those that are stay so.
pub fn run(of: &mut Untangle, flood: &mut Flood, (hits, contours): (&[Hit], &[Contour])) {
    for within in [false, true] {
        let number = flood.start(1) + 1;
        let mut ring: Vec<u32> = Vec::new();
        for hit in contours.iter().flat_map(|contour| contour.hits.iter().flatten()).map(|n| hits[*n as usize]) {
            let (ends, corners) = (of.net.edges[hit.edge as usize], of.net.faces[hit.face as usize]);
            if (of.cloth(ends[0]) == of.cloth(corners[0])) == within {
                ring.extend(ends.into_iter().chain(corners).filter(|point| flood.enter(*point, number)));
            }
        }
        for _ in 0..=of.rings[usize::from(within)] {
            let mut next = Vec::new();
            for point in ring {
                let loose = &mut of.loose[point as usize];
                (loose.own, loose.others) = (loose.own | within, loose.others | !within);
                let around = of.net.around(point).iter().map(|[other, _]| *other);
                next.extend(around.filter(|other| flood.enter(*other, number)));
            }
            ring = next;
        }
    }
}
