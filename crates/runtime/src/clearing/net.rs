//! A cloth as points, links between them, and garments.

use gimage_bundle::DisjointSets;

use crate::cloth::Cloth;
use crate::number::real::{V3, add, cast, cross, dot, scale, sub};

/// A link may get shorter than at rest and at the start down to this share: springs push back, and would throw the cloth.
const SHORTEST: f64 = 0.97;

/// A spring or a stitch between two points.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub ends: [u32; 2],
    /// Its length at rest \[m\].
    pub rest: f64,
    /// The shortest and the longest \[m\] that it may be: as at rest or as at the start.
    pub range: [f64; 2],
}

/// The points of a cloth: duplicates of a seam point are one.
pub struct Net {
    /// The point of each particle; `u32::MAX` of no particle.
    pub of_particle: Vec<u32>,
    /// The first particle of each point.
    pub particles: Vec<u32>,
    /// Where points are \[m\].
    pub at: Vec<V3<f64>>,
    /// Where they were at the start \[m\].
    pub start: Vec<V3<f64>>,
    pub free: Vec<bool>,
    /// How far \[m\] points may go from where they were at the start.
    pub reach: Vec<f64>,
    pub links: Vec<Link>,
    /// A point of the garment of each point: the first one.
    pub garment: Vec<u32>,
}

/// Share of its limit that a particle may go.
const LIMIT_SHARE: f64 = 0.9;

impl Net {
    /// Takes time and memory linear in the particles.
    pub fn new(cloth: &Cloth) -> Self {
        let firsts = cloth.points();
        let mut of_particle = vec![u32::MAX; cloth.len()];
        let mut particles = Vec::new();
        for k in 0..cloth.len() {
            let first = firsts[k] as usize;
            if !cloth.particles()[k].exists() {
                continue;
            }
            if of_particle[first] == u32::MAX {
                of_particle[first] = particles.len() as u32;
                particles.push(first as u32);
            }
            of_particle[k] = of_particle[first];
        }
        let at: Vec<V3<f64>> = particles.iter().map(|k| cast(cloth.positions()[*k as usize])).collect();
        let mut free = vec![true; at.len()];
        let mut reach = vec![f64::INFINITY; at.len()];
        for (k, point) in of_particle.iter().enumerate().filter(|(_, point)| **point != u32::MAX) {
            free[*point as usize] &= !cloth.particles()[k].is_pinned();
            let limit = cloth.limits.as_ref().map_or(-1.0, |limits| f64::from(limits[k]));
            if limit >= 0.0 {
                reach[*point as usize] = reach[*point as usize].min(LIMIT_SHARE * limit);
            }
        }
        let mut net =
            Net { of_particle, particles, start: at.clone(), at, free, reach, links: Vec::new(), garment: Vec::new() };
        net.find_links(cloth);
        let mut sets = DisjointSets::new(net.at.len());
        net.links.iter().for_each(|link| _ = sets.union(link.ends[0], link.ends[1]));
        net.garment = sets.into_representatives();
        net
    }

    fn find_links(&mut self, cloth: &Cloth) {
        let mut links = Vec::with_capacity(4 * self.at.len());
        let mut add = |a: usize, b: usize, rest: f64| {
            let ends = [self.of_particle[a], self.of_particle[b]];
            if ends[0] != ends[1] && !ends.contains(&u32::MAX) {
                let d = sub(self.at[ends[0] as usize], self.at[ends[1] as usize]);
                let now = dot(d, d).sqrt();
                links.push(Link { ends, rest, range: [SHORTEST * rest.min(now), rest.max(now)] });
            }
        };
        for (index, grid) in cloth.grids().iter().enumerate() {
            for (k, direction) in (0..grid.range().len()).flat_map(|k| (0..4).map(move |direction| (k, direction))) {
                let rest = f64::from(cloth.spring(index, k, direction));
                if let Some(other) = cloth.neighbour(index, k, direction).filter(|_| rest > 0.0) {
                    add(grid.range().start + k, other, rest);
                }
            }
        }
        for thread in cloth.sewing().iter().flat_map(|sewing| &sewing.threads) {
            // The corner that is nearest to the point of the stitch stands for it.
            let [s, t] = thread.inner;
            let corner = thread.ends[usize::from(s > 0.5) + 2 * usize::from(t > 0.5)];
            add(thread.ends[4] as usize, corner as usize, f64::from(thread.distance));
        }
        self.links = links;
    }

    /// The links of each point, as the other end and the length at rest \[m\], and where those of each point begin.
    pub fn neighbours(&self) -> (Vec<u32>, Vec<(u32, f64)>) {
        let mut starts = vec![0u32; self.at.len() + 1];
        let ends = || self.links.iter().flat_map(|link| [(0, link), (1, link)]);
        ends().for_each(|(end, link)| starts[link.ends[end] as usize + 1] += 1);
        (1..starts.len()).for_each(|n| starts[n] += starts[n - 1]);
        let (mut next, mut others) = (starts.clone(), vec![(0, 0.0); 2 * self.links.len()]);
        for (end, link) in ends() {
            let place = &mut next[link.ends[end] as usize];
            others[*place as usize] = (link.ends[1 - end], link.rest);
            *place += 1;
        }
        (starts, others)
    }

    /// The unit normals of the cloth at its points; 0 where there is none.
    pub fn normals(&self, cloth: &Cloth) -> Vec<V3<f64>> {
        let mut sums = vec![[0.0; 3]; self.at.len()];
        for corners in cloth.indices().as_chunks::<3>().0 {
            let points = corners.map(|k| self.of_particle[k as usize]);
            if points.contains(&u32::MAX) {
                continue;
            }
            let [a, b, c] = points.map(|point| self.at[point as usize]);
            let n = cross(sub(b, a), sub(c, a));
            points.iter().for_each(|point| sums[*point as usize] = add(sums[*point as usize], n));
        }
        sums.into_iter().map(|n| scale(n, 1.0 / dot(n, n).sqrt().max(f64::MIN_POSITIVE))).collect()
    }

    /// Positions of all particles \[m\], those of points that have not moved as they were.
    pub fn positions(&self, cloth: &Cloth) -> Vec<[f32; 3]> {
        let mut positions = cloth.positions().to_vec();
        for (to, point) in positions.iter_mut().zip(&self.of_particle).filter(|(_, point)| **point != u32::MAX) {
            let point = *point as usize;
            if self.at[point] != self.start[point] {
                *to = self.at[point].map(|x| x as f32);
            }
        }
        positions
    }

    /// How far \[m\] a point has moved.
    pub fn way(&self, point: usize) -> f64 {
        let d = sub(self.at[point], self.start[point]);
        dot(d, d).sqrt()
    }
}
