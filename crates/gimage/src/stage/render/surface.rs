//! The drawn surface of some pieces, and the nearest point on it along its interpolated normals.

use gimage_bundle::{Bundle, MapKind, triangles};

use crate::base::closest::Closest;
use crate::base::mesh::NONE;
use crate::base::vec3::{add, cross, dot, norm, scale, sub};

/// The drawn triangles of all pieces of a bundle, by bundle-wide texels.
pub(super) struct Texels {
    /// Positions \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Whether a texel is a particle.
    pub exists: Vec<bool>,
    /// For each texel the first of its duplicates.
    pub welded: Vec<u32>,
    /// Triangles, piece after piece.
    pub triangles: Vec<[u32; 3]>,
    /// For each piece where its triangles begin; one more for the end.
    pub first: Vec<usize>,
}

impl Texels {
    /// The mean distance of neighbouring particles \[m\]: the side of a square of two triangles.
    pub fn spacing(&self) -> f64 {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| self.position(k));
            0.5 * norm(cross(sub(b, a), sub(c, a)))
        };
        let whole: f64 = self.triangles.iter().map(area).sum();
        (2.0 * whole / self.triangles.len().max(1) as f64).sqrt()
    }

    /// Those of a bundle. Errors on illegal particle codes.
    pub fn new(bundle: &Bundle) -> gimage_bundle::Result<Self> {
        let particles = bundle.particles()?;
        let exists: Vec<bool> = particles.iter().map(|p| p.exists()).collect();
        let mut welded: Vec<u32> = (0..particles.len() as u32).collect();
        for ring in gimage_bundle::find_rings(&particles).0.iter() {
            ring.iter().for_each(|&k| welded[k as usize] = ring[0]);
        }
        let (mut positions, mut all, mut first) = (Vec::new(), Vec::new(), vec![0]);
        for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
            let (base, w) = (piece.first_particle, piece.width);
            let image = bundle.image(index, &MapKind::Position);
            let at = |k: usize| image.and_then(|i| i.at(k).first_chunk().copied()).unwrap_or_default();
            positions.extend((0..w as usize * piece.height as usize).map(at));
            for j in 0..piece.height.saturating_sub(1) {
                for i in 0..w.saturating_sub(1) {
                    let own = triangles(j * w + i, w, |k| exists.get((base + k) as usize).is_some_and(|e| *e));
                    all.extend(own.map(|t| t.map(|k| base + k)));
                }
            }
            first.push(all.len());
        }
        let normals = gimage_bundle::surface_normals(bundle)?;
        Ok(Texels { positions, normals, exists, welded, triangles: all, first })
    }

    fn position(&self, k: u32) -> [f64; 3] {
        self.positions[k as usize].map(f64::from)
    }
}

/// A point of a triangle: the triangle among those of [`Texels`], and the weights of its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub triangle: u32,
    pub weights: [f64; 3],
}

/// Some pieces, ready for queries.
pub(super) struct Surface<'a> {
    texels: &'a Texels,
    closest: Closest,
    /// The triangles among those of all pieces.
    triangles: Vec<u32>,
    /// The triangles around each welded texel: where the list of a texel begins, and the lists.
    first: Vec<u32>,
    around: Vec<u32>,
    /// The number of each welded texel among those of these pieces, or [`NONE`].
    number: Vec<u32>,
}

/// Rounds of Newton's method; it doubles the digits with each.
const ROUNDS: usize = 8;
/// How far outside of its triangle a foot may be, as a weight.
const INSIDE: f64 = -1e-9;
/// How much farther than the nearest point the foot of a perpendicular may be.
const FARTHER: f64 = 1.5;

impl<'a> Surface<'a> {
    /// The surface of some pieces. O(n log n) in their triangles.
    pub fn new(texels: &'a Texels, pieces: impl Iterator<Item = usize>) -> Self {
        let ranges = pieces.map(|p| texels.first[p] as u32..texels.first[p + 1] as u32);
        let triangles: Vec<u32> = ranges.flatten().collect();
        let corners: Vec<[[f64; 3]; 3]> =
            triangles.iter().map(|&t| texels.triangles[t as usize].map(|k| texels.position(k))).collect();
        let mut number = vec![NONE; texels.positions.len()];
        let mut count = 0;
        let welded = |t: u32| texels.triangles[t as usize].map(|k| texels.welded[k as usize]);
        for k in triangles.iter().flat_map(|&t| welded(t)) {
            if number[k as usize] == NONE {
                (number[k as usize], count) = (count, count + 1);
            }
        }
        let mut first = vec![0u32; count as usize + 1];
        let own = |t: u32| welded(t).map(|k| number[k as usize]);
        triangles.iter().flat_map(|&t| own(t)).for_each(|k| first[k as usize + 1] += 1);
        (1..first.len()).for_each(|k| first[k] += first[k - 1]);
        let (mut next, mut around) = (first.clone(), vec![0; 3 * triangles.len()]);
        for &t in &triangles {
            for k in own(t) {
                around[next[k as usize] as usize] = t;
                next[k as usize] += 1;
            }
        }
        Surface { texels, closest: Closest::of(&corners), triangles, first, around, number }
    }

    /// The point of the surface for a vertex at `p` \[m\]: that whose interpolated normal leads to `p`, if there is one around the nearest
    /// point, else the nearest point. `None` for a surface without triangles.
    pub fn foot(&self, p: [f64; 3]) -> Option<Spot> {
        let near = self.closest.project(p)?;
        let nearest = Spot { triangle: self.triangles[near.triangle as usize], weights: near.barycentric };
        let mut best: Option<(f64, Spot)> = None;
        let mut looked = Vec::with_capacity(16);
        for k in self.texels.triangles[nearest.triangle as usize] {
            let n = self.number[self.texels.welded[k as usize] as usize] as usize;
            for &t in &self.around[self.first[n] as usize..self.first[n + 1] as usize] {
                if looked.contains(&t) {
                    continue;
                }
                looked.push(t);
                let Some((weights, height)) = self.perpendicular(t, p) else { continue };
                let is_near = height <= FARTHER * near.distance + 1e-12;
                if is_near && best.is_none_or(|b| height < b.0) {
                    best = Some((height, Spot { triangle: t, weights }));
                }
            }
        }
        Some(best.map_or(nearest, |b| b.1))
    }

    /// The weights at which the interpolated normal of a triangle leads to `p`, and its distance \[m\] along it.
    fn perpendicular(&self, t: u32, p: [f64; 3]) -> Option<([f64; 3], f64)> {
        let corners = self.texels.triangles[t as usize];
        let [a, b, c] = corners.map(|k| self.texels.position(k));
        let [na, nb, nc] = corners.map(|k| self.texels.normals[k as usize].map(f64::from));
        let (ab, ac, nab, nac) = (sub(b, a), sub(c, a), sub(nb, na), sub(nc, na));
        let (mut v, mut w, mut h) = (1.0 / 3.0, 1.0 / 3.0, 0.0);
        for _ in 0..ROUNDS {
            let n = add(na, add(scale(nab, v), scale(nac, w)));
            let miss = sub(p, add(add(a, add(scale(ab, v), scale(ac, w))), scale(n, h)));
            let (x, y) = (add(ab, scale(nab, h)), add(ac, scale(nac, h)));
            let det = dot(x, cross(y, n));
            let [dv, dw, dh] =
                [dot(miss, cross(y, n)), dot(x, cross(miss, n)), dot(x, cross(y, miss))].map(|d| d / det);
            if ![dv, dw, dh].iter().all(|d| d.is_finite() && d.abs() < 1e6) {
                return None;
            }
            (v, w, h) = (v + dv, w + dw, h + dh);
        }
        let weights = [1.0 - v - w, v, w];
        let n = add(na, add(scale(nab, v), scale(nac, w)));
        let at = add(a, add(scale(ab, v), scale(ac, w)));
        let miss = norm(sub(p, add(at, scale(n, h))));
        let fits = weights.iter().all(|&x| x >= INSIDE) && miss <= 1e-9 * (norm(ab) + norm(ac));
        fits.then(|| (weights, h.abs() * norm(n)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage_bundle::Image;

    #[test]
    fn a_vertex_over_a_bent_sheet_stands_on_the_normal() {
        // Half a tube of radius 1; rows along it.
        let mut bundle = Bundle::new("test");
        let piece = bundle.add_piece("tube", 9, 3).unwrap();
        let mut image = Image::zeros(9, 3, 4);
        for k in 0..27 {
            let angle = (k % 9) as f32 / 8.0 * std::f32::consts::PI;
            let at = [angle.cos(), (k / 9) as f32, angle.sin(), 1.0];
            image.data[4 * k..4 * k + 4].copy_from_slice(&at);
        }
        bundle.insert(piece, MapKind::Position, image).unwrap();
        let texels = Texels::new(&bundle).unwrap();
        let surface = Surface::new(&texels, 0..1);
        for step in 2..30 {
            let (angle, r) = (f64::from(step) / 32.0 * std::f64::consts::PI, 1.1);
            let p = [r * angle.cos(), 0.9, r * angle.sin()];
            let spot = surface.foot(p).unwrap();
            let corners = texels.triangles[spot.triangle as usize];
            let sum = |list: &[[f32; 3]]| {
                (0..3).fold([0.0; 3], |s, c| add(s, scale(list[corners[c] as usize].map(f64::from), spot.weights[c])))
            };
            let (at, n) = (sum(&texels.positions), sum(&texels.normals));
            let offset = sub(p, at);
            assert!(norm(cross(offset, n)) < 1e-9 * norm(offset), "{angle}");
        }
        // Beyond the border nothing is perpendicular: the nearest point counts.
        let spot = surface.foot([1.0, 2.5, -0.2]).unwrap();
        assert!(spot.weights.iter().all(|w| *w >= 0.0));
        assert!(Surface::new(&texels, std::iter::empty()).foot([0.0; 3]).is_none());
    }
}
