//! Normals of the drawn surface at rest, as the runtime's passes `normals` and `seam_normals` compute them.

use crate::bundle::Bundle;
use crate::error::Result;
use crate::map::MapKind;
use crate::rings::find_rings;

type V3 = [f32; 3];

/// The unit normal of each texel of a bundle, piece after piece: the sum over the triangles around it, weighed by area, and at seams
/// the sum over all duplicates. 0 where no particle is, or no triangle has an area. Errors on an illegal particle code. O(n).
pub fn surface_normals(bundle: &Bundle) -> Result<Vec<[f32; 3]>> {
    let particles = bundle.particles()?;
    let mut sums = vec![[0.0; 3]; particles.len()];
    for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
        let (first, w) = (piece.first_particle as usize, piece.width);
        let Some(image) = bundle.image(index, &MapKind::Position) else { continue };
        let at = |k: u32| -> V3 { image.at(k as usize).first_chunk().copied().unwrap_or_default() };
        let exists = |k: u32| particles.get(first + k as usize).is_some_and(|p| p.exists());
        for j in 0..piece.height.saturating_sub(1) {
            for i in 0..w.saturating_sub(1) {
                for [a, b, c] in super::triangles(j * w + i, w, exists) {
                    let [p, q, r] = [a, b, c].map(at);
                    // Texels run to the right and down, seen from the side that normals point to; in a triangle that
                    // points down the third corner is above the first two.
                    let face = if c > b { cross(sub(q, p), sub(r, p)) } else { cross(sub(r, p), sub(q, p)) };
                    for k in [a, b, c] {
                        if let Some(sum) = sums.get_mut(first + k as usize) {
                            *sum = add(*sum, face);
                        }
                    }
                }
            }
        }
    }
    for ring in find_rings(&particles).0.iter() {
        let sum = ring.iter().fold([0.0; 3], |sum, &k| add(sum, sums[k as usize]));
        ring.iter().for_each(|&k| sums[k as usize] = sum);
    }
    Ok(sums.into_iter().map(unit).collect())
}

fn sub(a: V3, b: V3) -> V3 {
    std::array::from_fn(|k| a[k] - b[k])
}

fn add(a: V3, b: V3) -> V3 {
    std::array::from_fn(|k| a[k] + b[k])
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: V3) -> V3 {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_piece_has_one_normal_and_holes_have_none() {
        let mut bundle = Bundle::new("test");
        let piece = bundle.add_piece("flag", 4, 3).unwrap();
        let mut image = crate::Image::zeros(4, 3, 4);
        for k in 0..12 {
            let (i, j) = ((k % 4) as f32, (k / 4) as f32);
            image.data[4 * k..4 * k + 4].copy_from_slice(&[0.1 * i, 0.1 * j, 0.0, if k == 3 { 0.0 } else { 1.0 }]);
        }
        bundle.insert(piece, MapKind::Position, image).unwrap();
        let normals = surface_normals(&bundle).unwrap();
        for (k, n) in normals.iter().enumerate() {
            // Counter-clockwise in the order (i, j), (i+1, j), (i+1, j+1): +z for x to the right and y down the rows.
            assert_eq!(*n, if k == 3 { [0.0; 3] } else { [0.0, 0.0, 1.0] }, "{k}");
        }
    }
}
