//! One mesh triangle as an affine map of the plane.

use crate::base::vec3::{cross, dot, norm, scale, sub};
use crate::stage::parameterize::distortion::signed_area2;

/// P(u, v) = o + u du + v dv, as the rounds of the fit need it.
pub(super) struct Facet {
    pub du: [f64; 3],
    pub dv: [f64; 3],
    pub normal: [f64; 3],
    /// Its plane is `normal . x = height`.
    pub height: f64,
    /// The map crushes it so far that its gradient says nothing of the surface around it.
    pub extreme: bool,
}

/// A facet with what only the clipping needs of it.
pub(super) struct Affine {
    pub facet: Facet,
    o: [f64; 3],
    /// Surface per area of the plane.
    pub density: f64,
}

/// A facet is extreme where a texel spans this many times the mean texel's side on it.
const EXTREME: f64 = 30.0;

impl Affine {
    /// `None` for a triangle without area on the surface or in the plane. `texel` is the side of a mean texel \[m\].
    pub(super) fn new(x: [[f64; 3]; 3], p: [[f64; 2]; 3], texel: f64) -> Option<Self> {
        let area2 = signed_area2(p);
        let (e, f) = (sub(x[1], x[0]), sub(x[2], x[0]));
        let n = cross(e, f);
        if area2 <= 1e-14 || norm(n) <= 0.0 {
            return None;
        }
        let (a, b) = ([p[1][0] - p[0][0], p[1][1] - p[0][1]], [p[2][0] - p[0][0], p[2][1] - p[0][1]]);
        let du = [0, 1, 2].map(|c| (e[c] * b[1] - f[c] * a[1]) / area2);
        let dv = [0, 1, 2].map(|c| (f[c] * a[0] - e[c] * b[0]) / area2);
        let o = [0, 1, 2].map(|c| x[0][c] - p[0][0] * du[c] - p[0][1] * dv[c]);
        let normal = scale(n, 1.0 / norm(n));
        let extreme = norm(du).max(norm(dv)) > EXTREME * texel;
        let facet = Facet { du, dv, normal, height: dot(normal, x[0]), extreme };
        Some(Self { facet, o, density: norm(n) / area2 })
    }

    pub(super) fn at(&self, q: [f64; 2]) -> [f64; 3] {
        let Facet { du, dv, .. } = &self.facet;
        [0, 1, 2].map(|c| self.o[c] + q[0] * du[c] + q[1] * dv[c])
    }
}
