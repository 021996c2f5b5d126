//! The mesh of a body where joints put it, and how deep points are inside of it.

use gimage_bundle::{Body, Winding};
use gimage_runtime::{JointPoses, Skinning};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use rayon::prelude::*;

use crate::Error;

/// A body winds around points inside of it more than this.
const INSIDE: f64 = 0.5;

/// The body at a time.
pub struct Judge {
    mesh: TriMesh,
}

impl Judge {
    /// The body where joint matrices put it.
    pub fn new(body: &Body, skinning: Skinning, matrices: &[[f32; 16]]) -> Result<Self, Error> {
        let (poses, sets) = (JointPoses::new(skinning, matrices), body.sets());
        let place = |(v, p): (usize, &[f32; 3])| {
            let own = body.joints.iter().zip(&body.weights).skip(v * sets).take(sets);
            let shares: Vec<(u32, f64)> =
                own.flat_map(|(j, w)| j.iter().copied().zip(w.iter().map(|w| f64::from(*w)))).collect();
            Vector::from_array(poses.place(&shares, p.map(f64::from)))
        };
        let vertices = body.positions.par_iter().enumerate().map(place).collect();
        Ok(Judge { mesh: TriMesh::with_flags(vertices, body.triangles.clone(), TriMeshFlags::ORIENTED)? })
    }

    /// For each point how deep \[m\] it is inside; 0 outside. The side is that of the normal of the nearest face, edge or corner, and a body winds around what
    /// is inside of it: beyond the border of a body that is open, that normal tells nothing.
    pub fn depths(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let depth = |p: &[f64; 3]| {
            let at = Vector::from_array(*p);
            let found = self.mesh.project_point(&Pose::IDENTITY, at, false);
            if found.is_inside && self.winding(*p) > INSIDE { (found.point - at).length() } else { 0.0 }
        };
        points.par_iter().map(depth).collect()
    }

    /// How often the body winds around a point: 1 inside, 2 where two parts of it cross.
    pub fn winding(&self, p: [f64; 3]) -> f64 {
        let vertices = self.mesh.vertices();
        let corner = |v: u32| vertices[v as usize].to_array();
        Winding::new(self.mesh.indices().iter().map(|t| t.map(corner))).number(p)
    }
}
