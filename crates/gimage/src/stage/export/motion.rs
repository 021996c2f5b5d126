//! A surface in motion as files that film and game tools read: glTF and USD.
//!
//! A [`MotionWriter`] takes the surface frame by frame and gives bytes that the caller appends to a temporary file, so that memory holds one
//! frame. [`MotionWriter::finish`] lists the parts of the file, some of which are ranges of those bytes:
//!
//! ```
//! use gimage::export::motion::{MotionWriter, Part, UsdMotion};
//! use gimage::reconstruct::{ReconstructedPiece, Reconstruction};
//!
//! let piece = ReconstructedPiece { name: "flag".into(), triangles: 0..1, uv: None };
//! let mut surface = Reconstruction {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     normals: vec![[0.0, 0.0, 1.0]; 3],
//!     triangles: vec![[0, 1, 2]],
//!     pieces: vec![piece],
//! };
//! let (mut writer, mut written) = (Box::new(UsdMotion::new("flag", 30.0)), Vec::new());
//! for frame in 0..3 {
//!     surface.positions[2][2] = 0.1 * frame as f32;
//!     written.extend(writer.frame(&surface, f64::from(frame) / 30.0)?);
//! }
//! let part = |part| match part {
//!     Part::Bytes(bytes) => bytes,
//!     Part::Written(range) => written[range.start as usize..range.end as usize].to_vec(),
//! };
//! let text: Vec<u8> = writer.finish()?.into_iter().flat_map(part).collect();
//! assert!(String::from_utf8_lossy(&text).contains("point3f[] points.timeSamples"));
//! # Ok::<(), gimage::Error>(())
//! ```
//!
//! An OBJ file holds one frame: [`super::obj`] writes it.

mod dressing;
mod gltf;
mod spans;
mod usd;
mod usd_names;

use std::ops::Range;

pub use dressing::{Dressing, Worn};
pub use gltf::{GltfMotion, MAX_TARGETS};
pub use spans::{Compression, Shown};
pub use usd::UsdMotion;

use super::piece_triangles;
use crate::error::{Error, Result};
use crate::stage::reconstruct::{ReconstructedPiece, Reconstruction};

/// A part of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// These bytes.
    Bytes(Vec<u8>),
    /// A range of the bytes that [`MotionWriter::frame`] has given, counted over all frames.
    Written(Range<u64>),
}

/// A writer of a surface in motion.
pub trait MotionWriter {
    /// Adds the surface as it is in the next frame, at `time` \[s\], later than that of the frame before. Returns bytes to append to a
    /// temporary file. Triangles, pieces and texture coordinates may change from frame to frame. Errors on positions and normals that
    /// are not finite or are missing, and if the file becomes too large. Linear in the size of the surface.
    fn frame(&mut self, surface: &Reconstruction, time: f64) -> Result<Vec<u8>>;

    /// The parts of the file, in order. Errors if it is too large, or without a frame.
    fn finish(self: Box<Self>) -> Result<Vec<Part>>;
}

/// Checks a frame: a normal per position, all finite, and triangles that exist.
pub fn check(surface: &Reconstruction, frame: usize) -> Result<()> {
    let count = surface.positions.len();
    if surface.normals.len() != count || surface.triangles.as_flattened().iter().any(|v| *v as usize >= count) {
        return Err(Error::Internal(format!("frame {frame} has indices out of range")));
    }
    let finite = |list: &[[f32; 3]]| list.iter().position(|v| !v.iter().all(|x| x.is_finite()));
    for (what, list) in [("position", &surface.positions), ("normal", &surface.normals)] {
        let Some(point) = finite(list) else { continue };
        let has = |t: &&[u32; 3]| t.contains(&(point as u32));
        let piece = surface.pieces.iter().find(|piece| piece_triangles(surface, piece).iter().any(|t| has(&t)));
        return Err(Error::Piece {
            piece: piece.map_or("?", |piece| &piece.name).into(),
            stage: "export",
            problem: format!("the {what} of vertex {point} is not finite in frame {frame}"),
            hint: "export fewer frames, or make the motion stable: more substeps, smaller forces, the solver xpbd"
                .into(),
        });
    }
    Ok(())
}

/// The error of a file without frames.
fn no_frames() -> Error {
    let (option, problem) = ("frames".into(), "there is none".into());
    Error::Option { option, problem, hint: "export at least one frame".into() }
}

/// The parts of a surface that stay the same as long as no triangle changes.
#[derive(Clone, Debug, Default, PartialEq)]
struct Topology {
    triangles: Vec<[u32; 3]>,
    pieces: Vec<ReconstructedPiece>,
}

impl Topology {
    fn of(surface: &Reconstruction) -> Self {
        Topology { triangles: surface.triangles.clone(), pieces: surface.pieces.clone() }
    }

    fn is_of(&self, surface: &Reconstruction) -> bool {
        self.triangles == surface.triangles && self.pieces == surface.pieces
    }
}
