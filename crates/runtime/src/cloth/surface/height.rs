//! How high points are above a surface.

use super::{BodySurface, On, normal, on_triangle};
use crate::cloth::{Poses, Rows, Skinning};
use crate::number::real::{V3, add, cast, dot, scale, sub};

/// A surface somewhere: its vertices \[m\] and their normals, of any length.
pub struct Posed<'a> {
    surface: &'a BodySurface,
    at: Vec<V3<f64>>,
    normals: Vec<V3<f64>>,
    bounds: Vec<[V3<f64>; 2]>,
}

impl<'a> Posed<'a> {
    /// The surface at rest. O(n).
    pub fn at_rest(surface: &'a BodySurface) -> Self {
        let all = |list: &[[f32; 3]]| list.iter().map(|p| cast(*p)).collect();
        Posed::new(surface, all(&surface.rest), all(&surface.normals))
    }

    /// The surface where joints put it, of which there is a matrix each; at rest if it follows none. O(n).
    pub fn by_joints(surface: &'a BodySurface, skinning: Skinning, matrices: &[Rows]) -> Self {
        if surface.sets == 0 || matrices.len() < surface.joints() {
            return Posed::at_rest(surface);
        }
        let poses = Poses::new(skinning, matrices);
        let own = surface.influences.chunks(surface.sets);
        let at: Vec<V3<f64>> = surface.rest.iter().zip(own).map(|(p, own)| poses.place(own, cast(*p))).collect();
        let mut normals = vec![[0.0; 3]; at.len()];
        for t in &surface.triangles {
            let n = normal(t.map(|v| at[v as usize]));
            t.iter().for_each(|v| normals[*v as usize] = add(normals[*v as usize], n));
        }
        Posed::new(surface, at, normals)
    }

    fn new(surface: &'a BodySurface, at: Vec<V3<f64>>, normals: Vec<V3<f64>>) -> Self {
        let mut bounds = Vec::new();
        surface.tree.fit(|t| surface.triangles[t as usize].map(|v| at[v as usize]), &mut bounds);
        Posed { surface, at, normals, bounds }
    }

    /// The height \[m\] of a point above it, below 0 inside. O(log n).
    pub fn height(&self, p: V3<f64>) -> f64 {
        let triangle = |t: u32| self.surface.triangles[t as usize];
        let corners = |t: u32| triangle(t).map(|v| self.at[v as usize]);
        let (t, _) = self.surface.tree.nearest(&self.bounds, p, |t| on_triangle(p, t, corners(t)).distance2);
        let (own, spot) = (corners(t), on_triangle(p, t, corners(t)));
        let mix = |list: [V3<f64>; 3]| (0..3).fold([0.0; 3], |sum, k| add(sum, scale(list[k], spot.weights[k])));
        let smooth = || mix(triangle(t).map(|v| self.normals[v as usize]));
        let up = if spot.on == On::Face { normal(own) } else { smooth() };
        let far = spot.distance2.sqrt();
        if dot(sub(p, mix(own)), up) < 0.0 { -far } else { far }
    }
}

/// The heights \[m\] of points above a surface at rest, below 0 inside. O(log n) per point.
pub fn heights(surface: &BodySurface, points: impl Iterator<Item = [f32; 3]>) -> Vec<f32> {
    let posed = Posed::at_rest(surface);
    points.map(|p| posed.height(cast(p)) as f32).collect()
}
