//! Follows the vertices of the imported mesh through the stages before the image.
//!
//! Every stage carries attributes of corners along. One more attribute, whose values are the vertices of the imported mesh, tells at
//! the end where each corner came from. It is taken off before the maps are made.

use crate::base::mesh::{Channel, Mesh, NONE, Semantic};
use crate::stage::caps::Cap;

/// The name of the attribute: no file has it, as names of custom attributes begin with an underscore.
const NAME: &str = "imported vertex";

/// The imported mesh, and which of its vertices are cloth.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    /// Positions \[m\] of the vertices.
    pub positions: Vec<[f64; 3]>,
    /// The triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Whether a vertex belongs to a part that is cloth.
    pub is_cloth: Vec<bool>,
    /// For each corner of the mesh that became pieces the vertex that it was, or [`NONE`].
    pub corners: Vec<u32>,
    /// The joints of each vertex and their weights, `sets` per vertex; empty without joints, and where nobody asks.
    pub influences: Vec<Influence>,
    /// Sets of four joints per vertex.
    pub sets: usize,
    /// For each vertex of a cap around a limb that is not cloth the radius \[m\] of the opening that this closes, 0 for others; empty without such caps.
    pub lids: Vec<f32>,
}

/// Four joints, as whole floats, and their weights.
pub(crate) type Influence = ([f32; 4], [f32; 4]);

impl Trace {
    /// Begins with the mesh as it was imported, and marks its corners.
    pub fn start(mesh: &mut Mesh) -> Self {
        let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        let values = vec![0.0; mesh.positions.len()];
        mesh.channels.push(Channel { semantic: Semantic::Custom(NAME.into()), width: 1, values, corners });
        Trace {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            is_cloth: vec![false; mesh.positions.len()],
            corners: Vec::new(),
            influences: Vec::new(),
            sets: 0,
            lids: Vec::new(),
        }
    }

    /// Keeps the joints of the vertices too. Vertices without any follow the first joint with a weight of 0.
    pub fn with_joints(mut self, mesh: &Mesh) -> Self {
        let sets: Vec<(&Channel, &Channel)> = (0..)
            .map_while(|n| Some((mesh.channel(&Semantic::Joints(n))?, mesh.channel(&Semantic::Weights(n))?)))
            .collect();
        self.sets = sets.len();
        self.influences = vec![Influence::default(); self.sets * self.positions.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for (c, &v) in triangle.iter().enumerate() {
                let four = |channel: &Channel| channel.at(t, c)?.first_chunk::<4>().copied();
                for (n, (joints, weights)) in sets.iter().enumerate() {
                    if let (Some(joints), Some(weights)) = (four(joints), four(weights)) {
                        self.influences[v as usize * self.sets + n] = (joints, weights);
                    }
                }
            }
        }
        self
    }

    /// The joints of a vertex; none without any.
    pub fn joints(&self, vertex: u32) -> Option<&[Influence]> {
        let first = vertex as usize * self.sets;
        let own = self.influences.get(first..first + self.sets)?;
        own.iter().any(|(_, weights)| weights.iter().any(|w| *w > 0.0)).then_some(own)
    }

    /// The corners of a marked mesh, by the vertices that they were.
    fn marks<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = u32> + 'a {
        let channel = mesh.channel(&Semantic::Custom(NAME.into()));
        let known = |&v: &u32| if (v as usize) < self.positions.len() { v } else { NONE };
        channel.into_iter().flat_map(|c| &c.corners).map(known)
    }

    /// Takes in which parts are cloth: those that the mesh still has.
    pub fn selected(&mut self, mesh: &Mesh) {
        let mut is_cloth = vec![false; self.positions.len()];
        self.marks(mesh).filter(|&v| v != NONE).for_each(|v| is_cloth[v as usize] = true);
        self.is_cloth = is_cloth;
    }

    /// The vertices that the corners of the mesh were.
    pub fn corners_of(&self, mesh: &Mesh) -> Vec<u32> {
        self.marks(mesh).collect()
    }

    /// Takes in caps that were left out of a mesh with these corners.
    pub fn capped(&mut self, corners: &[u32], caps: &[Cap]) {
        for cap in caps.iter().filter(|cap| cap.bone.is_some()) {
            self.lids.resize(self.positions.len(), 0.0);
            let own = cap.triangles.iter().filter_map(|t| corners.get(3 * *t as usize..3 * *t as usize + 3));
            for &v in own.flatten().filter(|v| **v != NONE) {
                self.lids[v as usize] = (cap.length / std::f64::consts::TAU) as f32;
            }
        }
    }

    /// The radius \[m\] of the opening that a cap with this vertex closes, 0 if there is none.
    pub fn lid(&self, vertex: u32) -> f32 {
        self.lids.get(vertex as usize).copied().unwrap_or(0.0)
    }

    /// Takes the marks off the mesh that becomes pieces.
    pub fn finish(&mut self, mesh: &mut Mesh) {
        self.corners = self.marks(mesh).collect();
        mesh.channels.retain(|c| c.semantic != Semantic::Custom(NAME.into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repair::{RepairOptions, repair};

    #[test]
    fn corners_keep_their_vertices_through_a_repair() {
        // Two triangles that share an edge by position only, one wound the other way, and one without area.
        let mut mesh = Mesh {
            positions: vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]],
            triangles: vec![[0, 1, 1], [0, 1, 2], [5, 3, 4]],
            triangle_part: vec![0; 3],
            parts: vec![crate::base::mesh::Part::default()],
            ..Mesh::default()
        };
        let mut trace = Trace::start(&mut mesh);
        trace.selected(&mesh);
        assert!(trace.is_cloth.iter().all(|c| *c));
        let mut repaired = repair(mesh, &RepairOptions::default()).unwrap().mesh;
        trace.finish(&mut repaired);
        assert!(repaired.channels.is_empty());
        assert_eq!(trace.corners.len(), 6);
        for (corner, &v) in trace.corners.iter().enumerate() {
            let at = repaired.positions[repaired.triangles[corner / 3][corner % 3] as usize];
            assert_eq!(at, trace.positions[v as usize]);
        }
    }
}
