//! The surface that pictures and exports show: the mesh of the source, moved with the cloth, or the grid.

use std::path::Path;

use clap::ValueEnum;
use gimage_bundle::dir::read_dir;
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

/// The mesh of the source of a bundle, as its cloth moves it.
pub struct SourceMesh {
    pub mesh: RenderMesh,
    vertices: Vec<RenderVertex>,
}

impl SourceMesh {
    /// The mesh to show in place of the grid; none where it is not asked for, and where there is none, which is said for a bundle.
    pub fn choose(arg: SurfaceArg, name: &str, loaded: &Loaded, out: &Output) -> Result<Option<Self>, Failure> {
        if arg == SurfaceArg::Grid {
            return Ok(None);
        }
        let path = Path::new(name);
        let problem = if !path.is_dir() {
            "only a bundle has a mesh of its source".into()
        } else if !loaded.file.script.cuts.is_empty() {
            "the mesh of the source cannot be cut".into()
        } else {
            let bundle = read_dir(path).map_err(|e| Failure::bundle(path, &e))?;
            match RenderMesh::from_bundle(&bundle) {
                Ok(Some(mesh)) => return Ok(Some(SourceMesh { mesh, vertices: Vec::new() })),
                Ok(None) => "the bundle has no render.glb; build it with --render-mesh on".into(),
                Err(error) => error.to_string(),
            }
        };
        if arg == SurfaceArg::Render {
            return Err(Failure::refused(format!("{name}: --surface render: {problem}")));
        }
        if path.is_dir() {
            out.remark(Tone::Note, "note", &format!("{name}: {problem}; the grid is shown"));
        }
        Ok(None)
    }

    /// The vertices of the last call of [`SourceMesh::vertices`].
    pub fn moved(&self) -> &[RenderVertex] {
        &self.vertices
    }

    /// Moves its vertices to a fraction of the last step.
    pub fn vertices(&mut self, engine: &Engine, fraction: f32) -> Result<&[RenderVertex], Failure> {
        // A bundle is the only cloth of its scene.
        if engine.gpu().is_none() {
            engine.stepper.wrap(0, &self.mesh, fraction, &mut self.vertices)?;
            return Ok(&self.vertices);
        }
        let (mut now, normals) = (engine.positions(0)?, engine.normals(0)?);
        if fraction < 1.0 {
            for (now, before) in now.iter_mut().zip(engine.previous(0)?) {
                (0..3).for_each(|c| now[c] = before[c] + (now[c] - before[c]) * fraction);
            }
        }
        self.mesh.deform(&now, &normals, &mut self.vertices)?;
        engine.stepper.blend(0, &self.mesh, fraction, &mut self.vertices)?;
        Ok(&self.vertices)
    }
}
