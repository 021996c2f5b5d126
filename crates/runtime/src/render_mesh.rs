//! The mesh that a bundle was built from, bound to its pieces. A game draws it in place of the grid.

mod blend;
mod bound;
mod covers;
mod load;
mod lookup;

use std::ops::Range;
use std::sync::Arc;

use gimage_bundle::{Bundle, RenderMaterial};

use crate::cloth::Cloth;
use crate::cpu::rows::Threads;
use crate::cpu::wrap::{self, Jumps, Sheet, UNBOUND};
use crate::cpu::wrap_indices;
use crate::error::Result;
pub use crate::layout::RenderVertex;
pub(crate) use blend::Blended;
pub(crate) use bound::{Binding, Bound};
#[cfg(feature = "gpu")]
pub(crate) use covers::Covers;

/// A part of a mesh with one material: a primitive of the file as a node places it.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderPart {
    /// The name of its node, else of its mesh, else empty.
    pub name: String,
    /// Its vertices among those of the mesh.
    pub vertices: Range<usize>,
    /// Its indices among those of the mesh, three per triangle, counter-clockwise seen from the front.
    pub indices: Range<usize>,
    /// Base colour, alpha and sides.
    pub material: RenderMaterial,
    /// The index of that material in `render.glb`.
    pub material_index: Option<usize>,
    /// Whether any vertex moves with the cloth.
    pub is_bound: bool,
}

/// The mesh of the source of a bundle, its vertices bound to the texels of the cloth that [`crate::Cloth::from_bundle`] makes of the same bundle.
///
/// Bound vertices move with the cloth; others are where the source has them. Vertices where the map `blend` of the bundle is below 1 are on the
/// skin, or between the skin and the cloth. Reading it costs memory once: 64 bytes per vertex for the binding, 28 per texel, 8 per vertex for
/// texture coordinates and 4 per index; 80 more per blended vertex with up to four joints. Each coarser level of the cloth on which its vertices are
/// asked for costs 64 bytes per vertex and 28 per texel of that level, shared by all copies of the mesh.
#[derive(Clone, Debug)]
pub struct RenderMesh {
    /// Parts by material; each vertex belongs to one.
    pub parts: Vec<RenderPart>,
    /// Texture coordinates of the base colour, one per vertex, as in glTF (v down); 0 where a part has none.
    pub uv: Vec<[f32; 2]>,
    /// Linear colours of the vertices, which multiply the base colour; empty if no part has any.
    pub colors: Vec<[f32; 4]>,
    /// Vertices of the triangles.
    pub indices: Vec<u32>,
    /// The bytes of the image files (PNG or JPEG, or another format that an extension of the file has) that [`RenderMaterial::base_image`] names; empty for an image that no material uses.
    pub images: Vec<Vec<u8>>,
    /// The names of the images, else their numbers.
    pub image_names: Vec<String>,
    pub(crate) binding: Arc<Binding>,
    pub(crate) blended: Option<Arc<Blended>>,
}

impl RenderMesh {
    /// Reads the mesh of a bundle; `None` if it has none. Errors on a damaged `render.glb`, and on vertices that are not bound to a
    /// point of the surface. O(n) in vertices, triangles and texels.
    pub fn from_bundle(bundle: &Bundle) -> Result<Option<Self>> {
        load::load(bundle)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.binding.finest.rows.len()
    }

    /// Whether a vertex moves with the cloth; false for one that does not exist.
    pub fn is_bound(&self, vertex: usize) -> bool {
        self.binding.finest.rows.get(vertex).is_some_and(|row| row.corners[0] != UNBOUND)
    }

    /// Whether the mesh has no vertices.
    pub fn is_empty(&self) -> bool {
        self.binding.finest.rows.is_empty()
    }

    /// The vertices for given positions \[m\] and unit normals of the texels of the cloth, without the map `blend` ([`RenderMesh::blend`]), as [`crate::Stepper::positions`] and
    /// [`crate::Stepper::normals`] return them or as they are read back from a device. `out` gets one entry per vertex, and keeps
    /// its memory from call to call. Errors if the lists are not those of the cloth. 0.33 ms for 10,000 vertices on one core.
    pub fn deform(&self, positions: &[[f32; 4]], normals: &[[f32; 4]], out: &mut Vec<RenderVertex>) -> Result<()> {
        let sheet = Sheet { now: positions, before: positions, normals, fraction: 1.0 };
        self.binding.finest.run(&Threads::new(1)?, "", (&sheet, None), out)
    }

    /// The triangles that are left after cuts, in place of [`RenderMesh::indices`]: a triangle that covers a triangle of the cloth that is cut away is
    /// its first vertex three times, so that the ranges of the parts stay. `cloth` is the finest level of one that
    /// [`crate::Cloth::from_bundle`] made of the same bundle, `holes` as [`crate::Stepper::holes`], or read back from
    /// [`crate::ClothBuffers::holes`]; empty for cloth that is whole. [`crate::Stepper::render_indices`] does the same on any level.
    ///
    /// The first call of a cut cloth looks up which triangles cover which, a microsecond per triangle or texel; copies of the mesh share
    /// that. Errors on a cloth of another bundle and on another number of holes.
    pub fn indices_left(&self, cloth: &Cloth, holes: &[u32]) -> Result<Vec<u32>> {
        self.left(&self.binding.finest, cloth, holes)
    }

    /// The same with the binding to the level that the cloth is on.
    pub(crate) fn left(&self, bound: &Bound, cloth: &Cloth, holes: &[u32]) -> Result<Vec<u32>> {
        bound.fits(cloth.name(), cloth.len())?;
        let mut indices = self.indices.clone();
        if !holes.is_empty() {
            bound.fits(cloth.name(), holes.len())?;
            wrap_indices::run(&bound.covers(cloth, &self.indices).0, holes, &mut indices);
        }
        Ok(indices)
    }
}

impl Bound {
    /// The vertices for a cloth of the level. Errors if its lists are not of that level.
    pub(crate) fn run(
        &self,
        threads: &Threads,
        cloth: &str,
        (sheet, jumps): (&Sheet, Option<Jumps>),
        out: &mut Vec<RenderVertex>,
    ) -> Result<()> {
        for list in [sheet.now, sheet.before, sheet.normals] {
            self.fits(cloth, list.len())?;
        }
        out.resize(self.rows.len(), RenderVertex::default());
        wrap::run(threads, *sheet, &self.rows, jumps, out);
        Ok(())
    }
}
