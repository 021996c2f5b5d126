//! The vertices of one piece as glTF wants them: one for each pair of position and texture coordinate.

use std::collections::HashMap;

use serde_json::json;

use super::glb::{BinaryChunk, Component, Target};
use super::piece_triangles;
use crate::stage::reconstruct::{ReconstructedPiece, Reconstruction};

/// The vertices of a piece, in the order of its triangles.
#[derive(Default)]
pub struct Split {
    /// The position of the surface that each vertex has.
    pub points: Vec<u32>,
    /// Its texture coordinates; empty for a piece without.
    uv: Vec<[f32; 2]>,
    /// Three vertices per triangle.
    indices: Vec<u32>,
}

impl Split {
    /// Splits the positions of a piece of a surface.
    pub fn new(surface: &Reconstruction, piece: &ReconstructedPiece) -> Self {
        let mut out = Self::default();
        let mut index: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        for (t, corners) in piece_triangles(surface, piece).iter().enumerate() {
            for (c, &v) in corners.iter().enumerate() {
                let uv = piece.uv.as_ref().and_then(|uv| uv.get(t)).map(|uv| uv[c]);
                let key = (v, uv.unwrap_or_default().map(f32::to_bits));
                let k = *index.entry(key).or_insert_with(|| {
                    out.points.push(v);
                    out.uv.extend(uv);
                    out.points.len() as u32 - 1
                });
                out.indices.push(k);
            }
        }
        out
    }

    /// Orders triangles and vertices so that they compress well.
    pub fn optimize(&mut self) {
        let count = self.points.len();
        self.indices = meshopt::optimize_vertex_cache(&self.indices, count);
        let place = meshopt::optimize_vertex_fetch_remap(&self.indices, count);
        self.indices.iter_mut().for_each(|k| *k = place[*k as usize]);
        let (points, uv) = (self.points.clone(), self.uv.clone());
        for (from, to) in place.iter().enumerate().filter(|(_, to)| (**to as usize) < count) {
            self.points[*to as usize] = points[from];
            if let (Some(slot), Some(uv)) = (self.uv.get_mut(*to as usize), uv.get(from)) {
                *slot = *uv;
            }
        }
    }

    /// Its texture coordinates, if it has any.
    pub fn uv(&self) -> Option<&[[f32; 2]]> {
        (self.uv.len() == self.points.len()).then_some(&self.uv)
    }

    /// Three vertices per triangle.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The values of its vertices, of one value per position of the surface.
    pub fn of(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.points.iter().map(|p| values[*p as usize]).collect()
    }

    /// Appends its texture coordinates, if it has any, and returns their accessor.
    pub fn push_uv(&self, chunk: &mut BinaryChunk) -> Option<usize> {
        self.uv().map(|uv| chunk.floats(uv, json!({})))
    }

    /// Appends its indices and returns their accessor.
    pub fn push_indices(&self, chunk: &mut BinaryChunk) -> usize {
        let raw: &[u8] = bytemuck::cast_slice(&self.indices);
        chunk.push(raw, Some(Target::Indices), self.indices.len(), "SCALAR", Component::U32, json!({}))
    }
}
