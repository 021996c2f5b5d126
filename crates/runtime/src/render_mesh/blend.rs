//! Vertices that are drawn on the skin, or between the skin and the cloth.

use super::RenderMesh;
use crate::cloth::{Influence, Poses, Rows, Skinning};
use crate::cpu::blend;
use crate::error::{Error, Result};
use crate::layout::{BlendRow, RenderVertex};

/// Those of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blended {
    /// A row per vertex, in ascending order.
    pub rows: Vec<BlendRow>,
    /// `sets` per row. A vertex whose weights are all 0 follows no joint.
    pub influences: Vec<Influence>,
    /// Sets of four joints per vertex.
    pub sets: usize,
    /// Joints of the bundle, at least 1.
    pub joints: usize,
}

/// A matrix that moves nothing.
const STILL: Rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

impl Blended {
    /// The rows as shaders/blend.wgsl reads them.
    #[cfg(feature = "gpu")]
    pub fn list(&self) -> Vec<[u32; 4]> {
        let mut out = Vec::with_capacity(self.rows.len() * (3 + 2 * self.sets));
        for (row, own) in self.rows.iter().zip(self.influences.chunks(self.sets.max(1))) {
            out.extend(bytemuck::cast::<BlendRow, [[u32; 4]; 3]>(*row));
            out.extend(own.iter().flat_map(|i| [i.joints, i.weights.map(f32::to_bits)]));
        }
        out
    }

    /// Joint matrices for all joints: those given, or ones that move nothing. Errors if there are fewer than the bundle has joints.
    pub fn matrices(&self, given: Option<Vec<Rows>>) -> Result<Vec<Rows>> {
        match given {
            None => Ok(vec![STILL; self.joints]),
            Some(rows) if rows.len() >= self.joints => Ok(rows),
            Some(rows) => Err(Error::Joints { found: rows.len(), expected: self.joints }),
        }
    }
}

impl RenderMesh {
    /// The number of vertices that are drawn on the skin, or between the skin and the cloth, by the map `blend` of the bundle.
    pub fn blended(&self) -> usize {
        self.blended.as_ref().map_or(0, |b| b.rows.len())
    }

    /// Moves the vertices that [`RenderMesh::deform`] made on the cloth to the skin, as far as the map `blend` of the bundle says.
    /// `matrices` are those of the joints, as [`crate::Stepper::set_joints`] takes them, `skinning` is that of the cloth. Nothing happens without the map.
    ///
    /// 60 ns per blended vertex. Errors on another number of vertices, on fewer matrices than the bundle has joints, and on a number that is not
    /// finite.
    pub fn blend(&self, matrices: &[[f32; 16]], skinning: Skinning, vertices: &mut [RenderVertex]) -> Result<()> {
        let Some(blended) = &self.blended else { return Ok(()) };
        if let Some(index) = matrices.iter().position(|m| m.iter().any(|x| !x.is_finite())) {
            return Err(Error::JointNotFinite { joint: "of the bundle".into(), index });
        }
        let rows = matrices.iter().map(|m| [0, 1, 2].map(|r| [m[r], m[4 + r], m[8 + r], m[12 + r]])).collect();
        self.to_skin(&blended.matrices(Some(rows))?, skinning, vertices)
    }

    /// As [`RenderMesh::blend`], by rows.
    pub(crate) fn to_skin(&self, matrices: &[Rows], skinning: Skinning, vertices: &mut [RenderVertex]) -> Result<()> {
        let Some(blended) = &self.blended else { return Ok(()) };
        if vertices.len() != self.len() {
            return Err(Error::RenderVertices { expected: self.len(), found: vertices.len() });
        }
        blend::run(&blended.rows, &blended.influences, &Poses::new(skinning, matrices), vertices);
        Ok(())
    }
}
