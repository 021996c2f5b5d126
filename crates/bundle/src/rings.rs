//! The rings that seam links form: each joins all duplicates of one point of the surface.

use crate::particle::Particle;

/// The closed rings of a bundle. Each begins at its lowest index and goes on in the order of the links; the rings are
/// in the order of their lowest indices where no link is faulty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rings {
    members: Vec<u32>,
    ends: Vec<usize>,
}

impl Rings {
    /// The rings, each as the bundle-wide indices of its two or more members.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let start = |k: usize| if k == 0 { 0 } else { self.ends[k - 1] };
        (0..self.ends.len()).map(move |k| &self.members[start(k)..self.ends[k]])
    }

    /// Number of rings.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no ring.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
}

/// A fault of the link of one seam texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkFault {
    /// It points past the last texel of the bundle.
    OutOfRange(u32),
    /// It points at its own texel.
    Itself,
    /// It points at a texel that is not on a seam.
    NotASeam(u32),
    /// It points where another link points too, so that one of the two rings stays open.
    Shared(u32),
}

/// Finds the rings from the particles of all pieces, one for each texel of the bundle in the order of the indices.
/// Returns the rings that close, and each faulty link with the index of its texel. Without faults every seam texel is in
/// exactly one ring. Takes time and memory linear in the number of texels.
pub fn find_rings(particles: &[Particle]) -> (Rings, Vec<(u32, LinkFault)>) {
    let mut faults = Vec::new();
    let mut reached = vec![false; particles.len()];
    for (index, particle) in particles.iter().enumerate() {
        let Some(next) = particle.next() else { continue };
        let fault = match particles.get(next as usize) {
            None => Some(LinkFault::OutOfRange(next)),
            Some(_) if next as usize == index => Some(LinkFault::Itself),
            Some(target) if target.next().is_none() => Some(LinkFault::NotASeam(next)),
            Some(_) if std::mem::replace(&mut reached[next as usize], true) => Some(LinkFault::Shared(next)),
            Some(_) => None,
        };
        if let Some(fault) = fault {
            faults.push((index as u32, fault));
        }
    }

    let mut rings = Rings::default();
    // The walk that came through each texel first: its start + 1; 0 = none yet.
    let mut walk = vec![0_u32; particles.len()];
    for start in 0..particles.len() {
        let id = start as u32 + 1;
        let from = rings.members.len();
        let mut at = start;
        while let Some(next) = particles.get(at).and_then(|p| p.next()) {
            if walk[at] != 0 {
                break;
            }
            walk[at] = id;
            rings.members.push(at as u32);
            at = next as usize;
        }
        // A walk that comes back to itself has found a ring, behind a tail if a link is faulty.
        let tail = if walk.get(at) == Some(&id) {
            rings.members[from..].iter().position(|&m| m as usize == at).unwrap_or(0)
        } else {
            rings.members.len() - from
        };
        rings.members.drain(from..from + tail);
        if rings.members.len() < from + 2 {
            rings.members.truncate(from);
            continue;
        }
        let ring = &mut rings.members[from..];
        let lowest = (0..ring.len()).min_by_key(|&k| ring[k]).unwrap_or(0);
        ring.rotate_left(lowest);
        rings.ends.push(rings.members.len());
    }
    (rings, faults)
}

/// The largest distance between two linked duplicates, in the unit of the positions; 0 in a sound bundle, infinite
/// where a position is not finite. `position` gives x, y, z of a bundle-wide index.
pub fn ring_gap(rings: &Rings, position: impl Fn(u32) -> [f32; 3]) -> f64 {
    let mut largest = 0.0_f64;
    for ring in rings.iter() {
        for pair in ring.windows(2) {
            let (a, b) = (position(pair[0]), position(pair[1]));
            let squared: f64 = (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum();
            largest = if squared.is_finite() { largest.max(squared.sqrt()) } else { f64::INFINITY };
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particles(next: &[i64]) -> Vec<Particle> {
        let link = |n: i64| if n < 0 { Particle::Free { next: None } } else { Particle::Free { next: Some(n as u32) } };
        next.iter().map(|&n| link(n)).collect()
    }

    #[test]
    fn rings_close() {
        let (rings, faults) = find_rings(&particles(&[3, -1, 4, 5, 2, 0]));
        assert_eq!(faults, []);
        let found: Vec<_> = rings.iter().map(<[u32]>::to_vec).collect();
        assert_eq!(found, [vec![0, 3, 5], vec![2, 4]]);
    }

    #[test]
    fn each_bad_link_is_named() {
        let (rings, faults) = find_rings(&particles(&[1, 0, 9, 3, 5, -1, 0]));
        assert_eq!(rings.len(), 1);
        let expected = [
            (2, LinkFault::OutOfRange(9)),
            (3, LinkFault::Itself),
            (4, LinkFault::NotASeam(5)),
            (6, LinkFault::Shared(0)),
        ];
        assert_eq!(faults, expected);
    }

    #[test]
    fn a_tail_into_a_ring_is_not_a_ring() {
        let (rings, faults) = find_rings(&particles(&[1, 2, 1]));
        let found: Vec<_> = rings.iter().map(<[u32]>::to_vec).collect();
        assert_eq!(found, [vec![1, 2]]);
        assert_eq!(faults, [(2, LinkFault::Shared(1))]);
    }

    #[test]
    fn the_gap_is_the_largest_distance() {
        let (rings, _) = find_rings(&particles(&[1, 0, 3, 2]));
        assert_eq!(ring_gap(&rings, |_| [1.0; 3]), 0.0);
        assert_eq!(ring_gap(&rings, |k| [if k == 3 { 2.0 } else { 0.0 }, 0.0, 0.0]), 2.0);
        assert_eq!(ring_gap(&rings, |k| [if k == 1 { f32::NAN } else { 0.0 }, 0.0, 0.0]), f64::INFINITY);
    }
}
