//! Backstops: how far particles may go behind where they rest, or behind the skin.

use gimage_bundle::triangles;

use super::Cloth;
use crate::error::{Result, check as range};
use crate::number::real::{V3, add, cross, dot, scale, sub};

/// How far a particle may go behind the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backstop {
    /// Largest distance \[m\] behind the position at rest, against the normal of the cloth there, at least 0; below 0 means no backstop.
    pub distance: f32,
    /// Radius \[m\] of the sphere that begins there, above 0. Larger is flatter: a particle that has moved aside is kept out as by a plane.
    pub radius: f32,
}

impl Backstop {
    /// No backstop.
    pub const NONE: Backstop = Backstop { distance: -1.0, radius: 0.0 };

    /// Whether there is one.
    pub fn exists(&self) -> bool {
        self.distance >= 0.0
    }
}

impl Cloth {
    /// Errors on another number of backstops than particles, values that are not finite, radii not above 0, and duplicates that differ.
    pub(super) fn check_backstops(&self) -> Result<()> {
        let Some(backstops) = &self.backstops else { return Ok(()) };
        range("the number of backstops", backstops.len() as f64, "one per particle", |n| n == self.len() as f64)?;
        for backstop in backstops.iter() {
            range("the distance of a backstop [m]", f64::from(backstop.distance), "finite", |_| true)?;
            let radius = if backstop.exists() { f64::from(backstop.radius) } else { 1.0 };
            range("the radius of a backstop [m]", radius, "above 0", |r| r > 0.0)?;
        }
        let (starts, members) = self.rings();
        let rings = starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]);
        let value = |k: &u32| Some(backstops[*k as usize]).filter(Backstop::exists);
        let differ = rings.map(|ring| ring.iter().filter(|k| value(k) != value(&ring[0])).count()).sum::<usize>();
        range("the number of seam duplicates with another backstop", differ as f64, "0", |n| n == 0.0)
    }

    /// The sphere of each particle's backstop at rest: its centre \[m\] and its radius \[m\], -1 for none. Empty for cloth without backstops.
    ///
    /// The shape at rest is the start, or that of the skin for cloth that follows joints. A particle of which no triangle has an area has none.
    pub(crate) fn spheres(&self) -> Vec<[f32; 4]> {
        let Some(backstops) = &self.backstops else { return Vec::new() };
        let rest = self.skin().filter(|_| self.follows_joints()).map_or(self.positions(), |skin| &skin.rest);
        let sphere = |((p, n), backstop): ((&[f32; 3], V3<f64>), &Backstop)| {
            let length = dot(n, n).sqrt();
            if !backstop.exists() || length <= 0.0 {
                return [p[0], p[1], p[2], -1.0];
            }
            let back = scale(n, (f64::from(backstop.distance) + f64::from(backstop.radius)) / length);
            let [x, y, z] = sub(p.map(f64::from), back).map(|x| x as f32);
            [x, y, z, backstop.radius]
        };
        rest.iter().zip(self.facing(rest)).zip(backstops.iter()).map(sphere).collect()
    }

    /// Sums of the normals of the triangles around each particle in a shape, weighed by area, equal at duplicates.
    fn facing(&self, shape: &[[f32; 3]]) -> Vec<V3<f64>> {
        let mut sums = vec![[0.0; 3]; shape.len()];
        for grid in self.grids() {
            let first = grid.first as usize;
            let exists = |k: u32| self.particles()[first + k as usize].exists();
            let corners = (0..grid.height - 1).flat_map(|j| (0..grid.width - 1).map(move |i| j * grid.width + i));
            for [a, b, c] in corners.flat_map(|corner| triangles(corner, grid.width, exists)) {
                let [p, q, r] = [a, b, c].map(|k| shape[first + k as usize].map(f64::from));
                // As in `gimage_bundle::surface_normals`.
                let face = if c > b { cross(sub(q, p), sub(r, p)) } else { cross(sub(r, p), sub(q, p)) };
                [a, b, c].iter().for_each(|k| sums[first + *k as usize] = add(sums[first + *k as usize], face));
            }
        }
        let (starts, members) = self.rings();
        for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
            let sum = ring.iter().fold([0.0; 3], |sum, k| add(sum, sums[*k as usize]));
            ring.iter().for_each(|k| sums[*k as usize] = sum);
        }
        sums
    }
}
