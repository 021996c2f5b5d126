//! Stitches: points of one piece that are tied to points of another.

use crate::bundle::Bundle;
use crate::map::MapKind;
use crate::particle::Particle;

/// The value of a texel of the map `stitch` that has no stitch.
pub const NO_STITCH: [f32; 4] = [-1.0, 0.0, 0.0, 0.0];

/// Stitches that may move one point, as their particle or as a corner of their quad.
pub const MAX_STITCHES_AT_POINT: u32 = 32;

/// A particle that is tied to a point of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stitch {
    /// Bundle-wide index of the particle.
    pub particle: u32,
    /// Index of the piece that it is tied to.
    pub piece: u32,
    /// The point of that piece, u and v, each 0 to 1.
    pub at: [f32; 2],
    /// Length of the thread \[m\]: the distance of the two at rest.
    pub distance: f32,
}

/// The quad of a grid that a point lies in, and where in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Texel (i, j) of the quad, `j * width + i`. The others are one to the right, one below, and below that to the right.
    pub texel: u32,
    /// Where the point is in the quad, to the right and down, each 0 to 1.
    pub inner: [f32; 2],
}

impl Place {
    /// The quad of the point (u, v) of a grid with these sides, at least 2 each; coordinates outside 0 to 1 are clamped, NaN is 0.
    ///
    /// ```
    /// let place = gimage_bundle::Place::of(5, 3, [0.5, 1.0]);
    /// assert_eq!((place.texel, place.inner), (5 + 2, [0.0, 1.0]));
    /// ```
    pub fn of(width: u32, height: u32, at: [f32; 2]) -> Self {
        let along = |n: u32, x: f32| {
            let x = if x > 0.0 { f64::from(x.min(1.0)) * f64::from(n - 1) } else { 0.0 };
            let cell = (x as u32).min(n - 2);
            (cell, (x - f64::from(cell)) as f32)
        };
        let ((i, s), (j, t)) = (along(width.max(2), at[0]), along(height.max(2), at[1]));
        Place { texel: j * width + i, inner: [s, t] }
    }

    /// The four texels of the quad in a grid of this width: (i, j), (i+1, j), (i, j+1), (i+1, j+1).
    pub fn corners(&self, width: u32) -> [u32; 4] {
        [self.texel, self.texel + 1, self.texel + width, self.texel + width + 1]
    }

    /// The shares of the corners in the point; they sum to 1.
    pub fn shares(&self) -> [f32; 4] {
        let [s, t] = self.inner;
        [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t]
    }
}

impl Bundle {
    /// The stitches of all pieces, in the order of their particles. Texels without a particle, and values that are not
    /// finite or name no piece, have none: [`crate::validate`] names them.
    pub fn stitches(&self) -> Vec<Stitch> {
        let mut out = Vec::new();
        for (index, piece) in self.manifest.pieces.iter().enumerate() {
            let Some(image) = self.image(index, &MapKind::Stitch) else { continue };
            let positions = self.image(index, &MapKind::Position);
            for k in 0..piece.width as usize * piece.height as usize {
                let there = positions.and_then(|p| p.at(k).get(3)).is_some_and(|w| *w != 0.0);
                let &[to, u, v, distance] = image.at(k) else { continue };
                let known = to >= 0.0 && to.fract() == 0.0 && (to as usize) < self.manifest.pieces.len();
                if there && known && [u, v, distance].iter().all(|x| x.is_finite()) {
                    let particle = piece.first_particle + k as u32;
                    out.push(Stitch { particle, piece: to as u32, at: [u, v], distance });
                }
            }
        }
        out
    }
}

/// The fault of a texel of the map `stitch`.
pub(crate) fn fault(texel: &[f32], all: &[Particle], bundle: &Bundle) -> Option<String> {
    let &[to, u, v, distance] = texel else { return None };
    if to == NO_STITCH[0] {
        return None;
    }
    let pieces = &bundle.manifest.pieces;
    let known = to >= 0.0 && to.fract() == 0.0 && (to as usize) < pieces.len();
    if !known {
        return Some(format!("{to} is neither -1 nor the index of one of the {} pieces", pieces.len()));
    }
    if ![u, v].iter().all(|x| (0.0..=1.0).contains(x)) || distance < 0.0 {
        return Some(format!("no stitch of {distance} m to the point ({u}, {v})"));
    }
    let piece = &pieces[to as usize];
    let there = |k: &u32| all.get((piece.first_particle + k) as usize).is_some_and(|p| p.exists());
    let corners = Place::of(piece.width, piece.height, [u, v]).corners(piece.width);
    let message = || format!("the quad of the point ({u}, {v}) of piece {} lacks a particle", piece.name);
    (!corners.iter().all(there)).then(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::tests::sample;
    use crate::map::Image;
    use crate::validate::{FaultKind, validate};

    /// The sample with one stitch, of its first texel.
    fn with(value: [f32; 4]) -> Bundle {
        let mut bundle = sample();
        let (width, height) = (bundle.manifest.pieces[0].width, bundle.manifest.pieces[0].height);
        let mut data = NO_STITCH.repeat((width * height) as usize);
        data[..4].copy_from_slice(&value);
        bundle.insert(0, MapKind::Stitch, Image { width, height, channels: 4, data }).unwrap();
        bundle
    }

    #[test]
    fn stitches_are_read_as_they_were_written() {
        assert_eq!(sample().stitches(), []);
        assert_eq!(with(NO_STITCH).stitches(), []);
        let bundle = Bundle::from_files(&with([0.0, 0.5, 1.0, 0.002]).encode().unwrap()).unwrap();
        assert_eq!(validate(&bundle), []);
        assert_eq!(bundle.stitches(), [Stitch { particle: 0, piece: 0, at: [0.5, 1.0], distance: 0.002 }]);
    }

    #[test]
    fn stitches_that_lead_nowhere_are_faults() {
        for bad in [[2.0, 0.5, 0.5, 0.0], [-2.0, 0.5, 0.5, 0.0], [0.5; 4], [0.0, 1.1, 0.5, 0.0], [0.0, 0.5, 0.5, -1.0]]
        {
            let faults = validate(&with(bad));
            assert!(
                faults.iter().any(|f| f.kind == FaultKind::Stitch && f.texel == Some((0, 0))),
                "{bad:?}: {faults:?}"
            );
        }
        assert!(validate(&with([0.0, f32::NAN, 0.0, 0.0])).iter().any(|f| f.kind == FaultKind::NotFinite));
    }

    #[test]
    fn a_place_is_in_its_quad() {
        let place = Place::of(4, 3, [0.5, 0.25]);
        assert_eq!((place.texel, place.corners(4)), (1, [1, 2, 5, 6]));
        assert_eq!(place.shares(), [0.25; 4]);
        for at in [[f32::NAN, -1.0], [2.0, 1.0], [1.0, f32::INFINITY]] {
            let place = Place::of(4, 3, at);
            assert!(place.corners(4).iter().all(|k| *k < 12) && place.inner.iter().all(|x| (0.0..=1.0).contains(x)));
        }
    }
}
