//! The triangles of the cloth that each triangle of a bound mesh covers, so that it falls away with the first of them that is cut away.
//!
//! Points of a triangle of the mesh, half a texel apart, are looked up on the surface at rest by walking from triangle to triangle, over
//! seams as well. So it does not matter how large triangles of the mesh are beside texels, and where the seams of either lie.

use gimage_bundle::triangles;

use super::bound::Bound;
use crate::cloth::Cloth;
use crate::cloth::surface::on_triangle;
use crate::cpu::wrap::UNBOUND;
use crate::number::real::{V3, add, cast, cross, dot, scale, sub, xyz};

/// Distance of the points, as a share of a texel.
const SPACING: f64 = 0.5;
/// The share of the way to the middle of the triangle by which they lie within it, so that a triangle does not cover a neighbour whose side it only touches.
const INSET: f64 = 0.02;
/// Points along the longest side of a triangle, and steps of a walk.
const POINTS: f64 = 512.0;
const STEPS: usize = 256;
/// No triangle.
const NONE: u32 = u32::MAX;

/// Pairs of a triangle of the cloth (twice the texel of its quad, plus 1 for the second one, as [`crate::ClothBuffers::holes`] counts them) and a
/// triangle of the mesh that covers it, in the order of the latter.
#[derive(Debug)]
pub struct Covers(pub Vec<[u32; 2]>);

/// The triangles of a cloth at rest.
struct Surface<'a> {
    positions: &'a [[f32; 4]],
    /// The corners of triangle n of [`Covers`]; `NONE` where there is none.
    corners: Vec<[u32; 3]>,
    /// For every particle the first duplicate of its seam point.
    points: Vec<u32>,
    /// The triangles around each point.
    starts: Vec<u32>,
    around: Vec<u32>,
    /// The mean side of a texel \[m\].
    texel: f64,
}

impl Covers {
    /// For a mesh that is bound to a cloth. O(n) in the triangles of both, some 0.2 microseconds per point that is looked up.
    pub fn new(bound: &Bound, cloth: &Cloth, indices: &[u32]) -> Self {
        let surface = Surface::new(bound, cloth);
        let rows = &bound.rows;
        let own: Vec<u32> = rows.iter().map(|row| surface.find(row.corners)).collect();
        let (mut list, mut covered) = (Vec::new(), Vec::new());
        for (triangle, t) in indices.as_chunks::<3>().0.iter().enumerate() {
            covered.clear();
            let under = t.map(|v| own[v as usize]);
            if under.contains(&NONE) {
                covered.extend(under.iter().filter(|n| **n != NONE));
            } else {
                let feet = t.map(|v| surface.foot(own[v as usize], rows[v as usize].weights));
                surface.between(feet, under, &mut covered);
            }
            covered.sort_unstable();
            covered.dedup();
            list.extend(covered.iter().map(|n| [*n, triangle as u32]));
        }
        Covers(list)
    }
}

impl<'a> Surface<'a> {
    fn new(bound: &'a Bound, cloth: &Cloth) -> Self {
        let (positions, points) = (&bound.positions, cloth.points());
        let mut corners = vec![[NONE; 3]; 2 * positions.len()];
        for g in cloth.grids() {
            let exists = |k: u32| cloth.particles()[(g.first + k) as usize].exists();
            let quads = (0..g.height - 1).flat_map(|j| (0..g.width - 1).map(move |i| j * g.width + i));
            for k in quads {
                for (n, t) in triangles(k, g.width, exists).enumerate() {
                    corners[2 * (g.first + k) as usize + n] = t.map(|k| g.first + k);
                }
            }
        }
        let there = || corners.iter().enumerate().filter(|(_, t)| t[0] != NONE);
        let mut starts = vec![0u32; positions.len() + 1];
        there().flat_map(|(_, t)| t).for_each(|k| starts[points[*k as usize] as usize + 1] += 1);
        (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let (mut next, mut around) = (starts.clone(), vec![0; starts.last().map_or(0, |n| *n as usize)]);
        for (n, t) in there() {
            for k in t {
                let slot = &mut next[points[*k as usize] as usize];
                around[*slot as usize] = n as u32;
                *slot += 1;
            }
        }
        let (count, area) = there().fold((0.0, 0.0), |(n, sum), (_, t)| (n + 1.0, sum + area(positions, *t)));
        let texel = if count > 0.0 { (2.0 * area / count).sqrt() } else { 0.0 };
        Surface { positions, corners, points, starts, around, texel }
    }

    /// The number of a triangle by its corners.
    fn find(&self, corners: [u32; 3]) -> u32 {
        if corners[0] == UNBOUND {
            return NONE;
        }
        let around = self.around(corners[0]);
        around.iter().copied().find(|n| self.corners[*n as usize] == corners).unwrap_or(NONE)
    }

    /// The triangles around a particle.
    fn around(&self, particle: u32) -> &[u32] {
        let point = self.points[particle as usize] as usize;
        &self.around[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    fn at(&self, n: u32) -> [V3<f64>; 3] {
        self.corners[n as usize].map(|k| cast(xyz(self.positions[k as usize])))
    }

    fn foot(&self, n: u32, [s, t]: [f32; 2]) -> V3<f64> {
        let [a, b, c] = self.at(n);
        add(a, add(scale(sub(b, a), s.into()), scale(sub(c, a), t.into())))
    }

    /// Adds the triangles under the points of a triangle whose corners lie on some triangles.
    fn between(&self, feet: [V3<f64>; 3], own: [u32; 3], covered: &mut Vec<u32>) {
        let longest = (0..3).map(|c| length(sub(feet[c], feet[(c + 1) % 3]))).fold(0.0, f64::max);
        let texel = own.iter().map(|n| (2.0 * area(self.positions, self.corners[*n as usize])).sqrt());
        let texel = texel.fold(self.texel, f64::min).max(0.1 * self.texel);
        let count = if texel > 0.0 { (longest / (SPACING * texel)).ceil().clamp(1.0, POINTS) as usize } else { 1 };
        let [a, b, c] = feet;
        let share = |n: usize| INSET / 3.0 + (1.0 - INSET) * n as f64 / count as f64;
        let mut row = own[0];
        for j in 0..=count {
            let mut on = row;
            for i in 0..=count - j {
                let p = add(a, add(scale(sub(b, a), share(i)), scale(sub(c, a), share(j))));
                // Corners may lie on pieces between which no way leads.
                let from = if i == count {
                    own[1]
                } else if j == count {
                    own[2]
                } else {
                    on
                };
                on = self.walk(from, p);
                if i == 0 {
                    row = on;
                }
                if covered.last() != Some(&on) {
                    covered.push(on);
                }
            }
        }
    }

    /// The triangle nearest to a point that a walk from another one finds.
    fn walk(&self, start: u32, p: V3<f64>) -> u32 {
        let gap2 = |n: u32| on_triangle(p, n, self.at(n)).distance2;
        let mut best = (gap2(start), start);
        for _ in 0..STEPS {
            let from = best;
            for n in self.corners[from.1 as usize].iter().flat_map(|k| self.around(*k)) {
                let gap2 = gap2(*n);
                if gap2 < best.0 {
                    best = (gap2, *n);
                }
            }
            if best.1 == from.1 {
                break;
            }
        }
        best.1
    }
}

fn area(positions: &[[f32; 4]], corners: [u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|k| cast(xyz(positions[k as usize])));
    0.5 * length(cross(sub(b, a), sub(c, a)))
}

fn length(v: V3<f64>) -> f64 {
    dot(v, v).sqrt()
}
