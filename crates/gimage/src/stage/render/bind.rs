//! Binds vertices to the drawn surfaces: piece, u, v, and the offset in the frame there.

use gimage_bundle::manifest::PieceEntry;
use gimage_bundle::{Frame, SurfacePoint};
use rayon::prelude::*;

use super::surface::{Spot, Surface, Texels};
use crate::base::vec3::{norm, sub};

/// Where a vertex is bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Binding {
    /// Piece, u, v.
    pub coord: [f32; 3],
    /// The offset \[m\] in the frame.
    pub offset: [f32; 3],
    /// Where it is drawn, 0 on the skin and 1 on the cloth.
    pub blend: f32,
}

/// A vertex that is bound to nothing.
pub(super) const UNBOUND: Binding = Binding { coord: [-1.0, 0.0, 0.0], offset: [0.0; 3], blend: 1.0 };

/// A point of the surface as the runtime finds it again.
pub(super) struct Anchor {
    coord: [f32; 3],
    frame: Frame,
    corners: [[f32; 3]; 3],
    weights: [f32; 2],
}

impl Anchor {
    /// The point of a triangle, with u and v rounded as they are stored.
    pub fn new(pieces: &[PieceEntry], texels: &Texels, spot: &Spot) -> Option<Self> {
        let corners = texels.triangles[spot.triangle as usize];
        let index = pieces.partition_point(|p| p.first_particle <= corners[0]).checked_sub(1)?;
        let piece = &pieces[index];
        let (w, h, base) = (piece.width, piece.height, piece.first_particle);
        let place = |f: &dyn Fn(u32) -> u32, size: u32| {
            let at: f64 = (0..3).map(|c| spot.weights[c] * f64::from(f(corners[c] - base))).sum();
            (at / f64::from(size - 1)).clamp(0.0, 1.0) as f32
        };
        let (u, v) = (place(&|k| k % w, w), place(&|k| k / w, h));
        let exists = |k: u32| texels.exists.get((base + k) as usize).is_some_and(|e| *e);
        let point = SurfacePoint::at((w, h), exists, [u, v])?;
        let at = point.texels.map(|k| (base + k) as usize);
        let corners = at.map(|k| texels.positions[k]);
        let frame = Frame::new(corners, at.map(|k| texels.normals[k]), point.weights);
        Some(Anchor { coord: [index as f32, u, v], frame, corners, weights: point.weights })
    }

    /// Binds a vertex at `p` \[m\] to the point.
    pub fn bind(&self, p: [f64; 3]) -> Binding {
        let [a, b, c] = self.corners.map(|p| p.map(f64::from));
        let [s, t] = self.weights.map(f64::from);
        let foot: [f64; 3] = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
        Binding { coord: self.coord, offset: self.frame.inward(sub(p, foot)).map(|x| x as f32), blend: 1.0 }
    }

    /// How far \[m\] a bound vertex is from `p` at rest, as a runtime computes it.
    pub fn miss(&self, binding: &Binding, p: [f64; 3]) -> f64 {
        norm(sub(self.frame.place(self.corners, self.weights, binding.offset).map(f64::from), p))
    }
}

/// A vertex that is bound, its distance from the surface \[m\], and its distance from the place of the source at rest \[m\].
pub(super) struct Bound {
    pub binding: Binding,
    pub far: f64,
    pub miss: f64,
}

/// How much farther than the stitches around it \[m\], as a factor, a vertex may be from the surface that it rides on in place of its own.
const SEWN: f64 = 2.0;

/// Binds vertices at `positions` \[m\], each to the surface that `of` gives for its index, in parallel; `None` where there is none. A vertex whose
/// point is sewn to another surface, which `sewn_to` gives with the distance of the two \[m\], is bound to that.
pub(super) fn bind_all<'a>(
    pieces: &[PieceEntry],
    texels: &Texels,
    positions: &[[f64; 3]],
    (of, sewn_to): (
        impl Fn(usize) -> Option<&'a Surface<'a>> + Sync,
        impl Fn(&Spot) -> Option<(&'a Surface<'a>, f64)> + Sync,
    ),
) -> Vec<Option<Bound>> {
    let at = |spot: &Spot, p: [f64; 3]| {
        let anchor = Anchor::new(pieces, texels, spot)?;
        let binding = anchor.bind(p);
        Some(Bound { binding, far: norm(binding.offset.map(f64::from)), miss: anchor.miss(&binding, p) })
    };
    let one = |(k, &p): (usize, &[f64; 3])| {
        let spot = of(k)?.foot(p)?;
        let own = at(&spot, p)?;
        let other = sewn_to(&spot).and_then(|(surface, distance)| {
            let most = own.far + SEWN * distance;
            at(&surface.foot(p)?, p).filter(|other| other.far <= most)
        });
        other.or(Some(own))
    };
    positions.par_iter().enumerate().map(one).collect()
}
