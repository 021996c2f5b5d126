//! Twin of shaders/seam_moments.wgsl: the Laplacian at a seam point is the sum of what its duplicates see.

use super::moments::Plate;
use crate::number::real::{Real, V3, add};

/// Sums the multipliers of every ring; where one of its members has none, none of them has. Not shared out: seams are few.
///
/// A member is its sheet, its place in the layout of `Sheet::now` and that in the layout of `Sheet::w`.
pub fn run<T: Real>(plates: &mut [Plate<T>], starts: &[u32], members: &[(usize, usize, usize)]) {
    for ring in starts.windows(2) {
        let ring = &members[ring[0] as usize..ring[1] as usize];
        let whole = ring.iter().all(|(g, _, single)| plates[*g].compliance[*single] > T::of(0.0));
        let mut sum = [T::of(0.0); 3];
        for (g, triple, _) in ring.iter().filter(|_| whole) {
            sum = add(sum, at(&plates[*g], *triple));
        }
        for (g, triple, _) in ring {
            let half = plates[*g].weights.half;
            (0..3).for_each(|c| plates[*g].moments[triple + 2 * c * half] = sum[c]);
        }
    }
}

fn at<T: Real>(plate: &Plate<T>, triple: usize) -> V3<T> {
    [0, 1, 2].map(|c| plate.moments[triple + 2 * c * plate.weights.half])
}
