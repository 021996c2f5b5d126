//! The surface that is exported: the mesh of the source, or the grid.

use gimage::export::motion::Dressing;
use gimage::reconstruct::Reconstruction;

use super::grid::GridSource;
use super::mesh::MeshSource;
use crate::args::ExportArgs;
use crate::commands::engine::Engine;
use crate::commands::scene::Loaded;
use crate::commands::surface::SourceMesh;
use crate::exit::Failure;
use crate::output::Output;

/// One of the two.
pub enum Source {
    Grid(GridSource),
    Mesh(Box<MeshSource>),
}

impl Source {
    /// The surface that the arguments ask for. Refuses scenes without triangles.
    pub fn new(args: &ExportArgs, engine: &Engine, loaded: &Loaded, out: &Output) -> Result<Self, Failure> {
        let meshes = SourceMesh::choose(args.surface, args.scene.scene(), loaded, out)?;
        if meshes.is_empty() {
            return Ok(Source::Grid(GridSource::new(&engine.stepper)?));
        }
        let cloths = &engine.stepper.scene().cloths;
        if let Some(index) = (0..cloths.len()).find(|index| meshes.iter().all(|mesh| mesh.cloth != *index)) {
            let (scene, name) = (args.scene.scene(), cloths[index].name());
            return Err(Failure::refused(format!(
                "{scene}: --surface render: cloth '{name}' has no mesh of a source; use --surface grid"
            )));
        }
        Ok(Source::Mesh(Box::new(MeshSource::new(meshes, loaded.animated.is_some()))))
    }

    /// The value of `--surface` that it is.
    pub fn name(&self) -> &'static str {
        if matches!(self, Source::Mesh(_)) { "render" } else { "grid" }
    }

    /// The materials of its pieces; none of a grid.
    pub fn dressing(&self, loaded: &Loaded) -> Result<Option<Dressing>, Failure> {
        match self {
            Source::Grid(_) => Ok(None),
            Source::Mesh(mesh) => mesh.dressing(loaded).map(Some),
        }
    }

    /// The surface as it is, at a fraction of the last step. Refuses positions that are not finite or too far away.
    pub fn read(&mut self, engine: &Engine, fraction: f32) -> Result<&Reconstruction, Failure> {
        match self {
            Source::Grid(grid) => grid.read(engine, fraction),
            Source::Mesh(mesh) => mesh.read(engine, fraction),
        }
    }

    /// The names of pieces without triangles at the moment.
    pub fn empty(&self) -> impl Iterator<Item = &str> {
        self.surface().pieces.iter().filter(|piece| piece.triangles.is_empty()).map(|piece| piece.name.as_str())
    }

    /// Numbers of pieces with triangles, of vertices and of triangles.
    pub fn counts(&self) -> [usize; 3] {
        let pieces = self.surface().pieces.len() - self.empty().count();
        [pieces, self.surface().positions.len(), self.surface().triangles.len()]
    }

    fn surface(&self) -> &Reconstruction {
        match self {
            Source::Grid(grid) => grid.surface(),
            Source::Mesh(mesh) => mesh.surface(),
        }
    }
}
