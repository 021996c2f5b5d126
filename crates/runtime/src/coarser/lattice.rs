//! Where the texels of a coarser image lie in the image that it is made of, and what lies between them.

use super::border::Sides;
use crate::cloth::{Cloth, Grid};
use crate::number::real::dot;

/// Up to three particles of the coarse image, and how much each counts. Unused entries repeat the first particle with a weight of 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    pub of: [u32; 3],
    pub weight: [f32; 3],
}

impl Stencil {
    fn one(k: u32) -> Self {
        Stencil { of: [k; 3], weight: [1.0, 0.0, 0.0] }
    }

    /// The particles that count, with their weights.
    pub fn parts(&self) -> impl Iterator<Item = (usize, f32)> {
        self.of.into_iter().zip(self.weight).filter(|(_, w)| *w > 0.0).map(|(k, w)| (k as usize, w))
    }

    /// The same particles with weights of the point of their triangle, or of their edge, that is nearest to `p` \[m\]: springs of a fine
    /// image differ in length, and texels halfway between two others lie anywhere between them.
    pub fn at_place(self, p: [f32; 3], place: impl Fn(usize) -> [f32; 3]) -> Self {
        let parts: Vec<_> = self.parts().collect();
        let from = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| f64::from(b[c]) - f64::from(a[c]));
        let a = place(parts.first().map_or(0, |part| part.0));
        let to = |n: usize| from(a, parts.get(n).map_or(a, |part| place(part.0)));
        let (e, f, d) = (to(1), to(2), from(a, p));
        let (ee, ef, ff, de, df) = (dot(e, e), dot(e, f), dot(f, f), dot(d, e), dot(d, f));
        let det = ee * ff - ef * ef;
        let weights = match parts.len() {
            2 if ee > 0.0 => [1.0 - de / ee, de / ee, 0.0],
            3 if det > 1e-6 * ee * ff => {
                let (u, v) = ((ff * de - ef * df) / det, (ee * df - ef * de) / det);
                [1.0 - u - v, u, v]
            }
            _ => return self,
        };
        let weights = weights.map(|w| w.max(0.0));
        let sum: f64 = weights.iter().sum();
        let moved = parts.iter().zip(weights).map(|((k, _), w)| (*k as u32, (w / sum) as f32));
        if sum.is_finite() { weighted(moved).unwrap_or(self) } else { self }
    }
}

/// The coarse grid of a grid whose sides keep some texels, its particles beginning at `first`, and the texel of each. Inside, columns and
/// rows follow from those of opposite sides.
pub fn texels(grid: &Grid, sides: &Sides, first: u32) -> (Grid, Vec<[u32; 2]>) {
    let (width, height) = (sides[0].len() as u32, sides[2].len() as u32);
    let between = |a: u32, b: u32, n: u32, of: u32| {
        let t = f64::from(n) / f64::from(of.max(2) - 1);
        (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round() as u32
    };
    let at = |i: u32, j: u32| {
        let x = between(sides[0][i as usize], sides[1][i as usize], j, height);
        [x, between(sides[2][j as usize], sides[3][j as usize], i, width)]
    };
    let all = (0..height).flat_map(|j| (0..width).map(move |i| at(i, j))).collect();
    (Grid { name: grid.name.clone(), first, width, height }, all)
}

/// Each texel of a fine grid in terms of the coarse one: a point of the triangle that is drawn there. `there` tells
/// which coarse particles exist. `None` beside holes.
pub fn stencils(fine: &Grid, coarse: &Grid, texels: &[[u32; 2]], there: impl Fn(u32) -> bool) -> Vec<Option<Stencil>> {
    let mut all: Vec<Option<Stencil>> = vec![None; fine.texels()];
    let place = |[x, y]: [u32; 2]| (y * fine.width + x) as usize;
    for (k, at) in texels.iter().enumerate().filter(|(k, _)| there(coarse.first + *k as u32)) {
        all[place(*at)] = Some(Stencil::one(coarse.first + k as u32));
    }
    for (j, i) in (0..coarse.height - 1).flat_map(|j| (0..coarse.width - 1).map(move |i| (j, i))) {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| (j + down) * coarse.width + i + right);
        for corners in [[a, c, d], [a, d, b]] {
            let at = corners.map(|k| texels[k as usize]);
            let range =
                |c: usize| at.iter().map(|p| p[c]).min().unwrap_or(0)..=at.iter().map(|p| p[c]).max().unwrap_or(0);
            for [x, y] in range(1).flat_map(|y| range(0).map(move |x| [x, y])) {
                let stencil = inside(at, [x, y]).and_then(|weight| {
                    let parts = corners.map(|k| coarse.first + k).into_iter().zip(weight);
                    weighted(parts.filter(|(k, _)| there(*k)))
                });
                let texel = &mut all[place([x, y])];
                *texel = texel.or(stencil);
            }
        }
    }
    all
}

/// Barycentric coordinates of a texel in a triangle of texels; `None` outside of it.
fn inside(at: [[u32; 2]; 3], [x, y]: [u32; 2]) -> Option<[f32; 3]> {
    let p = |k: usize| [i64::from(at[k][0]) - i64::from(x), i64::from(at[k][1]) - i64::from(y)];
    let cross = |a: [i64; 2], b: [i64; 2]| a[0] * b[1] - a[1] * b[0];
    let parts = [cross(p(1), p(2)), cross(p(2), p(0)), cross(p(0), p(1))];
    let sum: i64 = parts.iter().sum();
    let within = sum != 0 && parts.iter().all(|n| n * sum >= 0);
    within.then(|| parts.map(|n| (n as f64 / sum as f64) as f32))
}

/// A stencil of some particles, whose weights are scaled to a sum of 1; `None` of none.
fn weighted(parts: impl Iterator<Item = (u32, f32)>) -> Option<Stencil> {
    let parts: Vec<_> = parts.filter(|(_, w)| *w > 0.0).collect();
    let sum: f32 = parts.iter().map(|(_, w)| w).sum();
    let (first, _) = parts.first()?;
    let mut stencil = Stencil { of: [*first; 3], weight: [0.0; 3] };
    for (n, (k, w)) in parts.iter().enumerate().take(3) {
        (stencil.of[n], stencil.weight[n]) = (*k, w / sum);
    }
    Some(stencil)
}

/// Fills what has no stencil, beside a hole, with that of the nearest coarse particle. Duplicates of a seam point get the same stencil.
pub fn complete(
    cloth: &Cloth,
    mut all: Vec<Option<Stencil>>,
    (grids, samples): (&[Grid], &[u32]),
    there: impl Fn(u32) -> bool,
) -> Vec<Stencil> {
    for (fine, coarse) in cloth.grids().iter().zip(grids) {
        let at = |k: u32| [(k - fine.first) % fine.width, (k - fine.first) / fine.width];
        for k in fine.range() {
            if all[k].is_some() || !cloth.particles()[k].exists() {
                continue;
            }
            let [x, y] = at(k as u32);
            let far = |c: &usize| {
                let [u, v] = at(samples[*c]);
                u64::from(u.abs_diff(x)).pow(2) + u64::from(v.abs_diff(y)).pow(2)
            };
            let nearest = coarse.range().filter(|c| there(*c as u32)).min_by_key(far);
            all[k] = nearest.map(|c| Stencil::one(c as u32));
        }
    }
    let place = |c: usize| cloth.positions()[samples[c] as usize];
    for (stencil, p) in all.iter_mut().zip(cloth.positions()) {
        *stencil = stencil.map(|s| s.at_place(*p, place));
    }
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        // A point that the coarse image has is that point on all sides.
        let exact = ring.iter().find(|k| all[**k as usize].is_some_and(|s| s.weight[0] >= 1.0));
        let first = all[*exact.unwrap_or(&ring[0]) as usize];
        ring.iter().for_each(|k| all[*k as usize] = first);
    }
    all.into_iter().map(|s| s.unwrap_or(Stencil::one(0))).collect()
}
