//! The surface that pictures and exports show: the mesh of the source, moved with the cloth, or the grid.

use std::path::Path;

use clap::ValueEnum;
use gimage_runtime::{RenderMesh, RenderVertex};

use crate::commands::engine::Engine;
use crate::commands::scene::Loaded;
use crate::exit::Failure;
use crate::output::{Output, Tone};

/// Which surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SurfaceArg {
    #[default]
    Auto,
    Render,
    Grid,
}

/// The mesh of the source of a cloth, as the cloth moves it.
pub struct SourceMesh {
    pub mesh: RenderMesh,
    /// Of the scene.
    pub cloth: usize,
    vertices: Vec<RenderVertex>,
    /// Triangles of the cloth that were cut away when `left` was made.
    holes: Vec<u32>,
    /// The triangles that are left, as long as the mesh has; none before the first cut.
    left: Option<Vec<u32>>,
}

impl SourceMesh {
    /// The meshes to show in place of the grid, in the order of their cloths. Auto shows the mesh of a bundle, with a note where it has none; the
    /// cloths of a scene file have looks of their own, so that their meshes are shown on demand alone, which is refused where there is
    /// none at all.
    pub fn choose(arg: SurfaceArg, name: &str, loaded: &Loaded, out: &Output) -> Result<Vec<Self>, Failure> {
        let is_bundle = Path::new(name).is_dir();
        if arg == SurfaceArg::Grid || (arg == SurfaceArg::Auto && !is_bundle) {
            return Ok(Vec::new());
        }
        let mut found = Vec::new();
        let mut problem = "only bundles and garments have a mesh of their source".to_owned();
        for (cloth, bundle) in loaded.bundles.iter().enumerate() {
            let Some(bundle) = bundle else { continue };
            match RenderMesh::from_bundle(bundle) {
                Ok(Some(mesh)) => {
                    found.push(SourceMesh { mesh, cloth, vertices: Vec::new(), holes: Vec::new(), left: None });
                }
                Ok(None) => problem = "the bundle has no render.glb; build it with --render-mesh on".into(),
                Err(error) => problem = error.to_string(),
            }
        }
        if found.is_empty() && arg == SurfaceArg::Render {
            return Err(Failure::refused(format!("{name}: --surface render: {problem}")));
        }
        if found.is_empty() {
            out.remark(Tone::Note, "note", &format!("{name}: {problem}; the grid is shown"));
        }
        Ok(found)
    }

    /// The vertices of the last call of [`SourceMesh::follow`].
    pub fn moved(&self) -> &[RenderVertex] {
        &self.vertices
    }

    /// The triangles that were left then, three indices each; those that are gone are points.
    pub fn indices(&self) -> &[u32] {
        self.left.as_ref().unwrap_or(&self.mesh.indices)
    }

    /// Moves its vertices to a fraction of the last step, and takes away triangles that are cut. Returns whether triangles have changed.
    pub fn follow(&mut self, engine: &Engine, fraction: f32) -> Result<bool, Failure> {
        let (stepper, cloth) = (&engine.stepper, self.cloth);
        if engine.gpu().is_none() {
            stepper.wrap(cloth, &self.mesh, fraction, &mut self.vertices)?;
        } else {
            let (mut now, normals) = (engine.positions(cloth)?, engine.normals(cloth)?);
            if fraction < 1.0 {
                for (now, before) in now.iter_mut().zip(engine.previous(cloth)?) {
                    (0..3).for_each(|c| now[c] = before[c] + (now[c] - before[c]) * fraction);
                }
            }
            self.mesh.deform(&now, &normals, &mut self.vertices)?;
            stepper.blend(cloth, &self.mesh, fraction, &mut self.vertices)?;
        }
        let holes = engine.holes(cloth)?;
        if holes == self.holes {
            return Ok(false);
        }
        let left = stepper.render_indices(cloth, &self.mesh, &holes)?;
        let is_other = left != self.indices();
        (self.left, self.holes) = (Some(left), holes);
        Ok(is_other)
    }
}
