//! One triangle of three texels and what of the surface falls on it: its part of the normal equations.
//!
//! A fragment (a mesh triangle within a texel triangle) has the integrals M of b b^T, b the corner functions. The original
//! is affine on it, so its moments are M times the facet at the three texels; and along the facet nothing counts, so only
//! the height of the texels above the facet's plane is needed for each fragment. The rest is summed once.

use super::FitOptions;
use super::facet::{Affine, Facet};
use crate::base::least_squares::Part;
use crate::base::vec3::{cross, dot};

/// The corners of a quad's triangles, as steps right and down: both halves by one diagonal and by the other.
pub(super) const HALVES: [[[usize; 2]; 3]; 4] =
    [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]], [[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]];

/// Gradients of the corner functions of [`HALVES`], each of which is half a unit square.
const SLOPES: [[[f64; 2]; 3]; 4] = [
    [[-1.0, 0.0], [1.0, -1.0], [0.0, 1.0]],
    [[0.0, -1.0], [1.0, 0.0], [-1.0, 1.0]],
    [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]],
    [[0.0, -1.0], [1.0, 1.0], [-1.0, 0.0]],
];

/// How much more the gradient term counts where the image is turned over by more than a right angle.
const TURNED: f64 = 2.0;

/// A mesh triangle within a texel triangle.
#[derive(Clone, Copy, Default)]
pub(super) struct Fragment {
    pub facet: u32,
    /// Integrals of b b^T (00, 01, 02, 11, 12, 22). In f32: there are many.
    mass: [f32; 6],
}

impl Fragment {
    pub(super) fn new(facet: u32, mass: [f64; 6]) -> Self {
        Self { facet, mass: mass.map(|m| m as f32) }
    }

    /// The integrals, and their sum: the area.
    #[inline(always)]
    fn mass(&self) -> ([f64; 6], f64) {
        let m: [f64; 6] = std::array::from_fn(|k| f64::from(self.mass[k]));
        (m, m[0] + m[3] + m[5] + 2.0 * (m[1] + m[2] + m[4]))
    }
}

/// A texel triangle and the sums over its fragments.
#[derive(Clone, Copy, Default)]
pub(super) struct Patch {
    /// First texel of the quad, and which of [`HALVES`] this is.
    pub quad: u32,
    pub half: u8,
    /// Where its fragments end; they begin where those of the patch before end.
    pub end: u32,
    mass: [f64; 6],
    /// Integrals of b P^T, P the original.
    moment: [[f64; 3]; 3],
}

impl Patch {
    /// A texel triangle on which nothing falls yet.
    pub(super) fn new(quad: u32, half: u8) -> Self {
        Self { quad, half, ..Self::default() }
    }

    /// Counts a fragment of these integrals, `at` the place of the quad.
    pub(super) fn add(&mut self, mass: [f64; 6], facet: &Affine, at: [f64; 2]) {
        // As the fragment will have it.
        let m = mass.map(|m| f64::from(m as f32));
        self.mass.iter_mut().zip(m).for_each(|(s, m)| *s += m);
        let p = HALVES[self.half as usize].map(|c| facet.at([at[0] + c[0] as f64, at[1] + c[1] as f64]));
        for (moment, row) in self.moment.iter_mut().zip(square(m)) {
            (0..3).for_each(|c| moment[c] += row[0] * p[0][c] + row[1] * p[1][c] + row[2] * p[2][c]);
        }
    }

    #[inline(always)]
    fn corners(&self, columns: usize) -> [usize; 3] {
        HALVES[self.half as usize & 3].map(|c| self.quad as usize + c[1] * columns + c[0])
    }

    /// The area of the fragments, and of those that texels at `points` turn over by more than a right angle.
    pub(super) fn turned(
        &self,
        (fragments, facets): (&[Fragment], &[Facet]),
        points: &[[f64; 3]],
        columns: usize,
    ) -> (f64, f64) {
        let [p, q, r] = self.corners(columns).map(|k| points[k]);
        let normal = cross(crate::base::vec3::sub(q, p), crate::base::vec3::sub(r, p));
        let (mut all, mut over) = (0.0, 0.0);
        for f in fragments {
            let area = f.mass().1;
            all += area;
            over += if dot(normal, facets[f.facet as usize].normal) < 0.0 { area } else { 0.0 };
        }
        (all, over)
    }

    /// Adds the terms of its fragments with texels now at `points`. Triangles that are turned over are held harder if `turned`.
    #[inline(always)]
    pub(super) fn equations(
        &self,
        part: &mut Part<'_>,
        (fragments, facets): (&[Fragment], &[Facet]),
        points: &[[f64; 3]],
        rim: &[bool],
        (options, turned): (&FitOptions, bool),
    ) {
        if fragments.is_empty() {
            return;
        }
        let half = self.half as usize & 3;
        let corner = self.corners(part.columns);
        let now = corner.map(|k| points[k]);
        let slip = if corner.iter().any(|&k| rim[k]) { 0.0 } else { options.slip };
        let slope = &SLOPES[half];
        let sum = |w: [f64; 3]| [0, 1, 2].map(|c| w[0] * now[0][c] + w[1] * now[1][c] + w[2] * now[2][c]);
        let [xu, xv] = [0, 1].map(|c| sum([slope[0][c], slope[1][c], slope[2][c]]));
        let across = cross(xu, xv);
        let size = dot(across, across).sqrt();
        let facing = if size > 0.0 { across.map(|x| x / size) } else { [0.0; 3] };
        // Weights of the gradient term, the gradients wanted, and what X rises above its facets.
        let mut weight = 0.0;
        let [mut u, mut v] = [[0.0; 3]; 2];
        let mut rise = [[0.0; 3]; 3];
        for f in fragments {
            let facet = &facets[f.facet as usize];
            let (m, area) = f.mass();
            let n = facet.normal;
            let cos = dot(facing, n);
            // A facet that points away is held all the harder: left to itself it stays turned over.
            let w = if facet.extreme {
                0.0
            } else if turned && cos < 0.0 {
                TURNED * area * options.gradient
            } else {
                // The distance of the two normals; a right angle if the texels have none.
                let off = if size > 0.0 { (2.0 - 2.0 * cos).max(0.0).sqrt() } else { 1.0 };
                area * options.gradient * options.sharp / (options.sharp + off)
            };
            let height = |x: [f64; 3]| dot(n, x) - facet.height;
            let above = [height(now[0]), height(now[1]), height(now[2])];
            let along = |c: usize| slope[0][c] * above[0] + slope[1][c] * above[1] + slope[2][c] * above[2];
            let (nu, nv) = (along(0), along(1));
            let t = [
                m[0] * above[0] + m[1] * above[1] + m[2] * above[2],
                m[1] * above[0] + m[3] * above[1] + m[4] * above[2],
                m[2] * above[0] + m[4] * above[1] + m[5] * above[2],
            ];
            let (stay, off_u, off_v) = ((1.0 - slip) * w, slip * w * nu, slip * w * nv);
            weight += w;
            for c in 0..3 {
                u[c] += stay * facet.du[c] - off_u * n[c];
                v[c] += stay * facet.dv[c] - off_v * n[c];
                rise[0][c] += t[0] * n[c];
                rise[1][c] += t[1] * n[c];
                rise[2][c] += t[2] * n[c];
            }
        }
        let slid = slip * weight;
        (0..3).for_each(|c| (u[c], v[c]) = (u[c] + slid * xu[c], v[c] + slid * xv[c]));
        let mut stencil = square(self.mass);
        for x in 0..3 {
            let s = slope[x];
            let there = sum(stencil[x]);
            let rhs = [0, 1, 2].map(|c| {
                let target = (1.0 - slip) * self.moment[x][c] + slip * (there[c] - rise[x][c]);
                target + s[0] * u[c] + s[1] * v[c]
            });
            part.add_rhs(corner[x], rhs);
        }
        for x in 0..3 {
            for y in 0..3 {
                stencil[x][y] += weight * (slope[x][0] * slope[y][0] + slope[x][1] * slope[y][1]);
            }
        }
        part.add_three(corner, HALVES[half], &stencil);
    }
}

/// A symmetric matrix of its upper triangle.
#[inline(always)]
fn square([a, b, c, d, e, f]: [f64; 6]) -> [[f64; 3]; 3] {
    [[a, b, c], [b, d, e], [c, e, f]]
}
