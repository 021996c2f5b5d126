//! The mesh that a bundle was built from, bound to its pieces. A game draws it in place of the grid.

mod blend;
mod load;

use std::ops::Range;
use std::sync::Arc;

use gimage_bundle::{Bundle, RenderMaterial};

use crate::cpu::rows::Threads;
use crate::cpu::wrap::{self, Sheet, UNBOUND};
use crate::error::{Error, Result};
use crate::layout::BoundRow;
pub use crate::layout::RenderVertex;
pub(crate) use blend::Blended;

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
/// skin, or between the skin and the cloth. Reading it costs memory once: 64 bytes per vertex for the binding, 8 for texture coordinates
/// and 4 per index; 80 more per blended vertex with up to four joints.
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
    /// The bytes of the image files, PNG or JPEG, that [`RenderMaterial::base_image`] names; empty for an image that no material uses.
    pub images: Vec<Vec<u8>>,
    /// The names of the images, else their numbers.
    pub image_names: Vec<String>,
    pub(crate) rows: Arc<Vec<BoundRow>>,
    pub(crate) blended: Option<Arc<Blended>>,
    texels: usize,
}

impl RenderMesh {
    /// Reads the mesh of a bundle; `None` if it has none. Errors on a damaged `render.glb`, and on vertices that are not bound to a
    /// point of the surface. O(n) in vertices, triangles and texels.
    pub fn from_bundle(bundle: &Bundle) -> Result<Option<Self>> {
        load::load(bundle)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether a vertex moves with the cloth; false for one that does not exist.
    pub fn is_bound(&self, vertex: usize) -> bool {
        self.rows.get(vertex).is_some_and(|row| row.corners[0] != UNBOUND)
    }

    /// Whether the mesh has no vertices.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The vertices for given positions \[m\] and unit normals of the texels of the cloth, without the map `blend` ([`RenderMesh::blend`]), as [`crate::Stepper::positions`] and
    /// [`crate::Stepper::normals`] return them or as they are read back from a device. `out` gets one entry per vertex, and keeps
    /// its memory from call to call. Errors if the lists are not those of the cloth. 0.33 ms for 10,000 vertices on one core.
    pub fn deform(&self, positions: &[[f32; 4]], normals: &[[f32; 4]], out: &mut Vec<RenderVertex>) -> Result<()> {
        let sheet = Sheet { now: positions, before: positions, normals, fraction: 1.0 };
        self.run(&Threads::new(1)?, "", &sheet, out)
    }

    pub(crate) fn run(&self, threads: &Threads, cloth: &str, sheet: &Sheet, out: &mut Vec<RenderVertex>) -> Result<()> {
        for list in [sheet.now, sheet.before, sheet.normals] {
            self.fits(cloth, list.len())?;
        }
        out.resize(self.len(), RenderVertex::default());
        wrap::run(threads, *sheet, &self.rows, out);
        Ok(())
    }

    /// Refuses a cloth of another bundle.
    pub(crate) fn fits(&self, cloth: &str, found: usize) -> Result<()> {
        if found == self.texels {
            return Ok(());
        }
        Err(Error::RenderMesh { cloth: cloth.into(), expected: self.texels, found })
    }
}
