//! Twin of shaders/seam_moments.wgsl: the Laplacian at a seam point is the sum of what its duplicates see.

use super::moments::Plate;
use super::seam_steps::Member;
use crate::number::real::{Real, V3, add};

/// Sums the multipliers of every ring; where one of its members has none, none of them has. Not shared out: seams are few.
pub fn run<T: Real>(plates: &mut [Plate<T>], starts: &[u32], members: &[Member]) {
    for ring in starts.windows(2) {
        let ring = &members[ring[0] as usize..ring[1] as usize];
        let whole = ring.iter().all(|m| plates[m.sheet as usize].compliance[m.single as usize] > T::of(0.0));
        let mut sum = [T::of(0.0); 3];
        for member in ring.iter().filter(|_| whole) {
            sum = add(sum, at(&plates[member.sheet as usize], member.at as usize));
        }
        for Member { sheet, at, .. } in ring {
            let plate = &mut plates[*sheet as usize];
            (0..3).for_each(|c| plate.moments[*at as usize + 2 * c * plate.weights.half] = sum[c]);
        }
    }
}

fn at<T: Real>(plate: &Plate<T>, triple: usize) -> V3<T> {
    [0, 1, 2].map(|c| plate.moments[triple + 2 * c * plate.weights.half])
}
