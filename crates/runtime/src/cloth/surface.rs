//! The surface of a body as a collider: triangles that joints move.

mod height;
mod nearest;
mod sides;
mod tree;

use gimage_bundle::Bundle;

use super::Influence;
use crate::error::{Error, Result};
use crate::number::real::{V3, add, cast, cross, dot, scale, sub};

pub(super) use height::heights;
pub(crate) use height::{Near, Posed};
pub(crate) use nearest::{On, Spot, on_triangle};
pub(crate) use sides::NONE;
pub(crate) use tree::{Bound, Tree, apart};

/// A patch passes near if it comes nearer to a particle than this \[m\] beyond its own extent, by its middle.
pub(crate) const PASSES_M: f64 = 0.02;
/// Triangles in a patch, at most, and the share of all that may be one.
const PATCH: usize = 48;
const PATCHES: usize = 256;

/// The surface of a body: triangles whose vertices follow the joints of the cloth that is worn on it ([`crate::Cloth::set_body`]).
///
/// Particles find the nearest point of it by walking from triangle to triangle. It need not be closed, nor one component, but triangles must be
/// counter-clockwise as seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySurface {
    /// Positions at rest \[m\].
    pub(crate) rest: Vec<[f32; 3]>,
    /// Unit normals there.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Influences per vertex; 0 of a body that does not move.
    pub(crate) sets: usize,
    pub(crate) influences: Vec<Influence>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// For each triangle those beyond its sides, the first from corner 0 to corner 1; [`NONE`] at a border.
    pub(crate) across: Vec<[u32; 3]>,
    /// A bit for each side at which the surface is hollow.
    pub(crate) hollow: Vec<u8>,
    /// Whether a vertex is on a border.
    pub(crate) border: Vec<bool>,
    /// The patch of each triangle, and a triangle in the middle of each patch.
    pub(crate) patch: Vec<u32>,
    pub(crate) middles: Vec<u32>,
    /// How far \[m\] the vertices of each patch are from the first corner of that triangle at rest, at most.
    pub(crate) extents: Vec<f32>,
    /// Triangles by patches, and where each patch begins in that list.
    pub(crate) order: Vec<u32>,
    pub(crate) starts: Vec<u32>,
    pub(crate) tree: Tree,
}

impl BodySurface {
    /// A surface of `positions` \[m\] at rest and `triangles`. `influences` are the same number per vertex, and index the joints of the cloth that is
    /// worn on it; without any the surface rests. Weights are divided by their sum. Triangles without an area are left out. O(n log n).
    ///
    /// Errors ([`Error::Surface`]) on positions that are not finite, vertices that do not exist, a number of influences that does not fit, weights
    /// that are negative, not finite or all 0, and a surface without any area.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, influences: Vec<Influence>) -> Result<Self> {
        let count = positions.len();
        let sets = influences.len() / count.max(1);
        let bad = |index: usize, problem| Err(Error::Surface { index, problem });
        if let Some(index) = positions.iter().position(|p| p.iter().any(|x| x.is_nan() || x.abs() >= MAX_COORDINATE_M))
        {
            return bad(index, "a position is not finite");
        }
        if let Some(index) = triangles.iter().position(|t| t.iter().any(|v| *v as usize >= count)) {
            return bad(index, "a corner of a triangle is not a vertex");
        }
        if influences.len() != sets * count {
            return bad(count, "the number of influences is not a multiple of the number of vertices");
        }
        let mut surface = BodySurface { rest: positions, sets, ..Self::empty() };
        for (index, own) in influences.chunks(sets.max(1)).enumerate() {
            let weights = || own.iter().flat_map(|i| i.weights);
            let sum: f64 = weights().map(f64::from).sum();
            if weights().any(|w| w.is_nan() || w < 0.0) || !(sum > 0.0 && sum.is_finite()) {
                return bad(index, "the weights of its joints are negative, not finite or all 0");
            }
            let share = |i: &Influence| {
                let weights = i.weights.map(|w| (f64::from(w) / sum) as f32);
                let joints = [0, 1, 2, 3].map(|k| if weights[k] > 0.0 { i.joints[k] } else { 0 });
                Influence { joints, weights }
            };
            surface.influences.extend(own.iter().map(share));
        }
        let has_area = |t: &[u32; 3]| {
            let n = normal(t.map(|v| cast(surface.rest[v as usize])));
            dot(n, n) > 0.0
        };
        let kept: Vec<[u32; 3]> = triangles.into_iter().filter(has_area).collect();
        if kept.is_empty() {
            return bad(0, "it has no area");
        }
        surface.triangles = kept;
        surface.normals = surface.vertex_normals();
        surface.across = sides::across(&surface.triangles);
        surface.hollow = sides::hollow(&surface);
        surface.border = sides::border(&surface);
        surface.tree = Tree::new(&surface.rest, &surface.triangles);
        let most = (surface.triangles.len() / PATCHES).clamp(4, PATCH);
        (surface.patch, surface.middles) = surface.tree.patches(&surface.rest, &surface.triangles, most);
        let of = |t: &u32| surface.patch[*t as usize];
        surface.order = (0..surface.triangles.len() as u32).collect();
        surface.order.sort_by_key(of);
        let begin = |patch: u32| surface.order.partition_point(|t| of(t) < patch) as u32;
        surface.starts = (0..=surface.middles.len() as u32).map(begin).collect();
        surface.extents = (0..surface.middles.len()).map(|n| surface.extent(n)).collect();
        Ok(surface)
    }

    fn extent(&self, patch: usize) -> f32 {
        let at = |v: u32| self.rest[v as usize].map(f64::from);
        let middle = at(self.triangles[self.middles[patch] as usize][0]);
        let corners = self.of_patch(patch).iter().flat_map(|t| self.triangles[*t as usize]);
        let far = |v: u32| dot(sub(at(v), middle), sub(at(v), middle));
        corners.map(far).fold(0.0, f64::max).sqrt() as f32
    }

    /// That of a bundle; `None` if it has none. Its influences index the joints of the bundle, as those of its cloth do. Errors as
    /// [`BodySurface::new`].
    pub fn of_bundle(bundle: &Bundle) -> Result<Option<Self>> {
        let Some(body) = &bundle.body else { return Ok(None) };
        let influence = |(joints, weights): (&[u32; 4], &[f32; 4])| Influence { joints: *joints, weights: *weights };
        let influences = body.joints.iter().zip(&body.weights).map(influence).collect();
        BodySurface::new(body.positions.clone(), body.triangles.clone(), influences).map(Some)
    }

    /// Number of its vertices.
    pub fn vertices(&self) -> usize {
        self.rest.len()
    }

    /// Number of its patches.
    pub(crate) fn patches(&self) -> usize {
        self.middles.len()
    }

    /// One over the square of the distance \[m\] from its middle at which a patch passes near.
    pub(crate) fn reach(&self, patch: usize) -> f64 {
        (f64::from(self.extents[patch]) + PASSES_M).powi(-2)
    }

    /// Words of [`BodySurface::list`].
    pub(crate) fn words(&self) -> usize {
        (9 * self.triangles.len() + 3 * self.patches() + 1).next_multiple_of(4)
    }

    /// Its triangles and patches as shaders/part/surface.wgsl reads them.
    #[cfg(feature = "gpu")]
    pub(crate) fn list(&self) -> Vec<u32> {
        let mut list = Vec::with_capacity(self.words());
        for (t, [a, b, c]) in self.triangles.iter().enumerate() {
            let borders = [a, b, c].map(|v| u32::from(self.border[*v as usize]));
            let flags = u32::from(self.hollow[t]) | borders[0] << 3 | borders[1] << 4 | borders[2] << 5;
            let [x, y, z] = self.across[t];
            list.extend([*a, *b, *c, flags, x, y, z, self.patch[t]]);
        }
        [&self.order, &self.starts, &self.middles].into_iter().for_each(|words| list.extend(words));
        list.extend((0..self.patches()).map(|n| (self.reach(n) as f32).to_bits()));
        list.resize(self.words(), 0);
        list
    }

    /// The positions of its vertices at rest, their normals there and `sets` of their influences, all or none, as shaders/surface_pose.wgsl reads them.
    #[cfg(feature = "gpu")]
    pub(crate) fn shape(&self, sets: usize) -> Vec<[u32; 4]> {
        let mut rows = Vec::with_capacity(self.rest.len() * 2 * (1 + sets));
        for (v, vectors) in self.rest.iter().zip(&self.normals).enumerate() {
            rows.extend([vectors.0, vectors.1].map(|[x, y, z]| [x.to_bits(), y.to_bits(), z.to_bits(), 0]));
            let own = &self.influences[v * self.sets..v * self.sets + sets];
            rows.extend(own.iter().flat_map(|i| [i.joints, i.weights.map(f32::to_bits)]));
        }
        rows
    }

    /// Its triangles: vertices, counter-clockwise as seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// One more than the largest joint that it follows; 0 if it rests.
    pub(crate) fn joints(&self) -> usize {
        let of = |i: &Influence| i.joints.iter().zip(i.weights).filter(|x| x.1 > 0.0).map(|x| *x.0 as usize + 1).max();
        self.influences.iter().filter_map(of).max().unwrap_or(0)
    }

    /// The triangles of a patch.
    pub(crate) fn of_patch(&self, n: usize) -> &[u32] {
        &self.order[self.starts[n] as usize..self.starts[n + 1] as usize]
    }

    /// Whether a point is on the border.
    pub(crate) fn is_border<T>(&self, spot: &Spot<T>) -> bool {
        match spot.on {
            On::Face => false,
            On::Side(side) => self.across[spot.triangle as usize][usize::from(side)] == NONE,
            On::Corner(corner) => self.border[self.triangles[spot.triangle as usize][usize::from(corner)] as usize],
        }
    }

    fn empty() -> Self {
        BodySurface {
            rest: Vec::new(),
            normals: Vec::new(),
            sets: 0,
            influences: Vec::new(),
            triangles: Vec::new(),
            across: Vec::new(),
            hollow: Vec::new(),
            border: Vec::new(),
            patch: Vec::new(),
            middles: Vec::new(),
            extents: Vec::new(),
            order: Vec::new(),
            starts: Vec::new(),
            tree: Tree::default(),
        }
    }

    /// The normals of vertices at rest, weighed by area; by angle where the former points behind one of its triangles, as at the edge of a plate with small faces there.
    fn vertex_normals(&self) -> Vec<[f32; 3]> {
        let at: Vec<V3<f64>> = self.rest.iter().map(|p| cast(*p)).collect();
        let faces = || self.triangles.iter().map(|t| (t, normal(t.map(|v| at[v as usize]))));
        let mut sums = vec![[0.0f64; 3]; at.len()];
        for (t, n) in faces() {
            t.iter().for_each(|v| sums[*v as usize] = add(sums[*v as usize], n));
        }
        let by_angle = vertex_normals(&self.triangles, &at);
        let mut own = sums.clone();
        for (t, n) in faces() {
            for v in t.map(|v| v as usize).into_iter().filter(|v| dot(sums[*v], n) < 0.0) {
                own[v] = by_angle[v];
            }
        }
        own.into_iter().map(|n| cast(scale(n, 1.0 / dot(n, n).sqrt().max(1e-30)))).collect()
    }
}

/// For each vertex, sums of the unit normals of its triangles, weighed by their angles there. With these at corners, and with the sum of both normals at a side, it is exact whether a point is
/// inside: J. A. Baerentzen and H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", 2005.
pub(crate) fn vertex_normals(triangles: &[[u32; 3]], at: &[V3<f64>]) -> Vec<V3<f64>> {
    let mut normals = vec![[0.0; 3]; at.len()];
    for t in triangles {
        let corners = t.map(|v| at[v as usize]);
        let n = normal(corners);
        let n = scale(n, 1.0 / dot(n, n).sqrt().max(f64::MIN_POSITIVE));
        for c in 0..3 {
            let [u, v] = [1, 2].map(|k| sub(corners[(c + k) % 3], corners[c]));
            let x = cross(u, v);
            let angle = dot(x, x).sqrt().atan2(dot(u, v));
            normals[t[c] as usize] = add(normals[t[c] as usize], scale(n, angle));
        }
    }
    normals
}

/// Positions are that far from the origin, at most.
const MAX_COORDINATE_M: f32 = 1e6;

/// Twice the area of a triangle, along its normal.
pub(crate) fn normal([a, b, c]: [V3<f64>; 3]) -> V3<f64> {
    cross(sub(b, a), sub(c, a))
}

#[cfg(test)]
#[path = "surface/tests.rs"]
mod tests;
