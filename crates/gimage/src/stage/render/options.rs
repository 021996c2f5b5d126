//! Options of the render mesh.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::options::{Choice, Range, stage_options};

/// Whether a bundle has the mesh of the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RenderMesh {
    /// It has.
    On,
    /// It has not.
    Off,
}

impl Choice for RenderMesh {
    const ALL: &'static [(&'static str, Self)] = &[("on", Self::On), ("off", Self::Off)];
}

/// How fine the drawn cloth is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subdivision {
    /// As the file has it.
    None,
    /// No edge is longer than this many times the mean distance of neighbouring texels, 1 to 64.
    Cells(f64),
}

/// The longest edge that [`crate::pipeline::dress`] leaves by default, as a multiple of the mean distance of neighbouring texels.
pub(crate) const CELLS: f64 = 4.0;

impl fmt::Display for Subdivision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Subdivision::None => f.write_str("none"),
            Subdivision::Cells(cells) => write!(f, "{cells}"),
        }
    }
}

impl FromStr for Subdivision {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let cells = || text.parse().ok().filter(|n: &f64| (1.0..=64.0).contains(n));
        match text {
            "none" => Ok(Subdivision::None),
            _ => cells().map(Subdivision::Cells).ok_or_else(|| Error::Option {
                option: "subdivide".into(),
                problem: format!("`{text}` is neither none nor a number from 1 to 64"),
                hint: "give a number of cells, for example 4".into(),
            }),
        }
    }
}

stage_options! {
    /// Options of the render mesh.
    #[derive(Copy)]
    pub struct RenderOptions of "render" {
        /// Put the mesh of the file, with its materials and textures, into the bundle as render.glb, its vertices bound to the
        /// pieces (on), or leave it out (off).
        pub render_mesh: RenderMesh = RenderMesh::On => "render-mesh" [""] Range::Any;
        /// Halve the edges of the drawn cloth in render.glb until none is longer than this many times the distance of two texels, so that it can
        /// show what the cloth does; none keeps the triangles of the file. Default: none, and 4 for gimage dress.
        pub subdivide: Option<Subdivision> = None => "subdivide" ["cells"] Range::Any;
    }
}
