//! The meshes of the sources of bundles, frame by frame.

use gimage::export::motion::{Dressing, Worn};
use gimage::reconstruct::{ReconstructedPiece, Reconstruction};
use gimage_runtime::RenderPart;

use super::grid::{NO_NORMAL, refuse_lost};
use crate::commands::engine::Engine;
use crate::commands::scene::Loaded;
use crate::commands::surface::SourceMesh;
use crate::exit::Failure;

/// The parts that move with cloth.
pub struct MeshSource {
    meshes: Vec<Part>,
    surface: Reconstruction,
    is_animated: bool,
}

/// Those of one mesh.
struct Part {
    of: SourceMesh,
    /// The first position of the surface that is a vertex of it.
    first: u32,
    /// Its vertex at each position of the surface.
    vertices: Vec<usize>,
    /// The position of each vertex, after `first`; `NONE` for one that no triangle of a piece has.
    places: Vec<u32>,
    worn: Vec<Worn>,
}

/// No position.
const NONE: u32 = u32::MAX;

impl MeshSource {
    /// A piece per part with a vertex that moves with the cloth. Triangles with a vertex that does not are left out of an animated character, as
    /// its joints would move that vertex.
    pub fn new(meshes: Vec<SourceMesh>, is_animated: bool) -> Self {
        let mut first = 0;
        let parts = meshes.into_iter().map(|of| {
            let part = Part::new(of, first, is_animated);
            first += part.vertices.len() as u32;
            part
        });
        let mut source = MeshSource { meshes: parts.collect(), surface: Reconstruction::default(), is_animated };
        source.gather();
        source
    }

    /// Triangles and pieces.
    fn gather(&mut self) {
        let Reconstruction { triangles, pieces, .. } = &mut self.surface;
        (*triangles, *pieces) = Default::default();
        self.meshes.iter().for_each(|part| part.gather(self.is_animated, triangles, pieces));
    }

    /// The materials of its pieces, from the files of the bundles.
    pub fn dressing(&self, loaded: &Loaded) -> Result<Dressing, Failure> {
        let mut colors = Vec::new();
        if self.meshes.iter().any(|part| !part.of.mesh.colors.is_empty()) {
            let of = |part: &Part, v: &usize| part.of.mesh.colors.get(*v).copied().unwrap_or([1.0; 4]);
            colors = self.meshes.iter().flat_map(|part| part.vertices.iter().map(move |v| of(part, v))).collect();
        }
        let mut dressing = Dressing::new(colors);
        for part in &self.meshes {
            let bundle = loaded.bundles.get(part.of.cloth).and_then(Option::as_ref);
            let bytes = bundle.and_then(|bundle| bundle.render.as_deref()).unwrap_or_default();
            dressing.add_glb(bytes, &part.worn)?;
        }
        Ok(dressing)
    }

    /// Triangles, pieces and the positions of the last frame.
    pub fn surface(&self) -> &Reconstruction {
        &self.surface
    }

    /// The surface as it is, at a fraction of the last step.
    pub fn read(&mut self, engine: &Engine, fraction: f32) -> Result<&Reconstruction, Failure> {
        let mut is_cut = false;
        (self.surface.positions, self.surface.normals) = Default::default();
        for Part { of, vertices, .. } in &mut self.meshes {
            refuse_lost(engine, of.cloth, &engine.positions(of.cloth)?)?;
            is_cut |= of.follow(engine, fraction)?;
            let moved = of.moved();
            let three = |[x, y, z, _]: [f32; 4]| [x, y, z];
            self.surface.positions.extend(vertices.iter().map(|v| three(moved[*v].position)));
            let normal = |v: &usize| Some(three(moved[*v].normal)).filter(|n| *n != [0.0; 3]).unwrap_or(NO_NORMAL);
            self.surface.normals.extend(vertices.iter().map(normal));
        }
        if is_cut {
            self.gather();
        }
        Ok(&self.surface)
    }
}

impl Part {
    fn new(of: SourceMesh, first: u32, is_animated: bool) -> Self {
        let (mut places, mut vertices) = (vec![NONE; of.mesh.len()], Vec::new());
        let parts = || of.mesh.parts.iter().filter(|part| part.is_bound);
        let indices = parts().flat_map(|part| triangles(&of, part, is_animated).flatten());
        for v in indices {
            if places[v] == NONE {
                places[v] = vertices.len() as u32;
                vertices.push(v);
            }
        }
        let worn = parts().map(|part| (part.material_index, part.material.base_set)).collect();
        Part { of, first, vertices, places, worn }
    }

    fn gather(&self, is_animated: bool, all: &mut Vec<[u32; 3]>, pieces: &mut Vec<ReconstructedPiece>) {
        let mesh = &self.of.mesh;
        for part in mesh.parts.iter().filter(|part| part.is_bound) {
            let (start, mut uv) = (all.len(), Vec::new());
            let own = mesh.indices.get(part.indices.clone()).unwrap_or_default();
            let has_uv = own.iter().any(|v| mesh.uv[*v as usize] != [0.0; 2]);
            for t in triangles(&self.of, part, is_animated) {
                uv.push(t.map(|v| mesh.uv[v]));
                all.push(t.map(|v| self.first + self.places[v]));
            }
            let triangles = start..all.len();
            pieces.push(ReconstructedPiece { name: part.name.clone(), triangles, uv: has_uv.then_some(uv) });
        }
    }
}

/// The triangles of a part that are drawn and left; one that is cut away is a point.
fn triangles<'a>(
    of: &'a SourceMesh,
    part: &RenderPart,
    is_animated: bool,
) -> impl Iterator<Item = [usize; 3]> + use<'a> {
    let all = of.indices().get(part.indices.clone()).unwrap_or_default().as_chunks::<3>().0;
    let is_shown = move |t: &[usize; 3]| {
        let is_point = t[1] == t[0] && t[2] == t[0];
        !is_point && (!is_animated || t.iter().all(|v| of.mesh.is_bound(*v)))
    };
    all.iter().map(|t| t.map(|v| v as usize)).filter(is_shown)
}
