//! The mesh of the source of a bundle, frame by frame.

use std::fs;
use std::path::Path;

use gimage::export::motion::{Dressing, Worn};
use gimage::reconstruct::{ReconstructedPiece, Reconstruction};
use gimage_bundle::RENDER_FILE;

use super::grid::{NO_NORMAL, refuse_lost};
use crate::commands::engine::Engine;
use crate::commands::surface::SourceMesh;
use crate::exit::Failure;

/// The parts that move with the cloth.
pub struct MeshSource {
    of: SourceMesh,
    surface: Reconstruction,
    /// The vertex of the mesh at each position of the surface.
    vertices: Vec<usize>,
    worn: Vec<Worn>,
}

impl MeshSource {
    /// A piece per part with a vertex that moves with the cloth. Triangles with a vertex that does not are left out of an animated character, as
    /// its joints would move that vertex.
    pub fn new(of: SourceMesh, is_animated: bool) -> Self {
        let (mut surface, mut vertices, mut worn) = (Reconstruction::default(), Vec::new(), Vec::new());
        let mesh = &of.mesh;
        let mut places = vec![u32::MAX; mesh.len()];
        for part in mesh.parts.iter().filter(|part| part.is_bound) {
            let start = surface.triangles.len();
            let mut uv = Vec::new();
            let own = mesh.indices.get(part.indices.clone()).unwrap_or_default();
            for t in own.as_chunks::<3>().0.iter().map(|t| t.map(|v| v as usize)) {
                if is_animated && !t.iter().all(|v| mesh.is_bound(*v)) {
                    continue;
                }
                uv.push(t.map(|v| mesh.uv[v]));
                surface.triangles.push(t.map(|v| {
                    if places[v] == u32::MAX {
                        places[v] = vertices.len() as u32;
                        vertices.push(v);
                    }
                    places[v]
                }));
            }
            let has_uv = uv.as_flattened().iter().any(|uv| *uv != [0.0; 2]);
            let (name, triangles) = (part.name.clone(), start..surface.triangles.len());
            surface.pieces.push(ReconstructedPiece { name, triangles, uv: has_uv.then_some(uv) });
            worn.push((part.material_index, part.material.base_set));
        }
        MeshSource { of, surface, vertices, worn }
    }

    /// The materials of its pieces, from the files of the bundle.
    pub fn dressing(&self, bundle: &str) -> Result<Dressing, Failure> {
        let path = Path::new(bundle).join(RENDER_FILE);
        let bytes = fs::read(&path).map_err(|e| Failure::io(&path, &e))?;
        let all = &self.of.mesh.colors;
        let colors = self.vertices.iter().filter_map(|v| all.get(*v).copied()).collect();
        Ok(Dressing::of_glb(&bytes, &self.worn, colors)?)
    }

    /// Triangles, pieces and the positions of the last frame.
    pub fn surface(&self) -> &Reconstruction {
        &self.surface
    }

    /// The surface as it is, at a fraction of the last step.
    pub fn read(&mut self, engine: &Engine, fraction: f32) -> Result<&Reconstruction, Failure> {
        refuse_lost(engine, 0, &engine.positions(0)?)?;
        let moved = self.of.vertices(engine, fraction)?;
        let three = |[x, y, z, _]: [f32; 4]| [x, y, z];
        self.surface.positions = self.vertices.iter().map(|v| three(moved[*v].position)).collect();
        let normal = |v: &usize| Some(three(moved[*v].normal)).filter(|n| *n != [0.0; 3]).unwrap_or(NO_NORMAL);
        self.surface.normals = self.vertices.iter().map(normal).collect();
        Ok(&self.surface)
    }
}
