//! A surface in motion as a GLB file.

use serde_json::json;

use super::super::draco;
use super::super::glb::{BinaryChunk, push, too_large};
use super::dressing::Dressing;
use super::spans::{Compression, Contents, PieceOf, Shown, Span};
use super::{MotionWriter, Part, Topology, check, no_frames};
use crate::error::{Error, Result};
use crate::stage::reconstruct::Reconstruction;

/// Most frames times pieces of a file: each is a target or a mesh of its own.
pub const MAX_TARGETS: usize = 1 << 16;

/// About as many bytes of JSON has a frame of a piece.
const JSON_BYTES: u64 = 700;

/// Colour of the material, linear.
const COLOR: [f32; 4] = [0.48, 0.05, 0.06, 1.0];

/// Writes a GLB file: a node and a mesh per piece, an animation, and a material with two sides.
///
/// With [`Shown::Targets`] the first frame is the mesh, and each further frame is a morph target with POSITION and NORMAL; weights are
/// animated linearly between frames. If triangles change, for example by a cut, the frames after that have meshes of their own, and the scale of
/// their parent is 0 before and after (STEP). With [`Shown::Meshes`] each frame has meshes of its own. Differences that are 0 for a quarter of
/// the vertices or more are sparse accessors. A position is that of its frame to the rounding of one sum in f32.
pub struct GltfMotion {
    shown: Shown,
    frames: usize,
    written: u64,
    topology: Topology,
    pieces: Vec<PieceOf>,
    spans: Vec<Span>,
    file: Contents,
    dressing: Option<Dressing>,
    compression: Compression,
}

impl GltfMotion {
    /// A file for at most `frames` frames.
    pub fn new(shown: Shown, frames: usize) -> Self {
        GltfMotion {
            shown,
            frames,
            written: 0,
            topology: Topology::default(),
            pieces: Vec::new(),
            spans: Vec::new(),
            file: Contents::default(),
            dressing: None,
            compression: Compression::None,
        }
    }

    /// The same, compressed. Errors on Draco with [`Shown::Targets`]: it has no morph targets.
    pub fn compressed(self, compression: Compression) -> Result<Self> {
        if compression == Compression::Draco && self.shown == Shown::Targets {
            let problem = "Draco compresses meshes, and no morph targets".into();
            let hint = "write a mesh per frame (`--as meshes`), or use meshopt".into();
            return Err(Error::Option { option: "compress".into(), problem, hint });
        }
        let chunk = if compression == Compression::Meshopt { BinaryChunk::packed() } else { BinaryChunk::default() };
        Ok(GltfMotion { compression, file: Contents { chunk, ..self.file }, ..self })
    }

    /// The same with the materials of a source in place of one of its own.
    pub fn dressed(self, dressing: Dressing) -> Self {
        GltfMotion { dressing: Some(dressing), ..self }
    }

    /// Refuses a motion that GLB has no room for, before it is there: as if no difference were 0.
    fn check_size(&self) -> Result<()> {
        let (frames, pieces) = (self.frames as u64, self.pieces.len() as u64);
        if frames.saturating_mul(pieces) > MAX_TARGETS as u64 {
            return Err(Error::TooLarge {
                what: "the GLB file".into(),
                need: format!("{pieces} pieces in {frames} frames"),
                limit: format!("{MAX_TARGETS} frames of pieces"),
                hint: "write fewer frames, or USD or OBJ".into(),
            });
        }
        let vertices = self.pieces.iter().map(|piece| piece.vertices() as u64).sum::<u64>();
        let weights = if self.shown == Shown::Targets { frames.saturating_mul(4) } else { 0 };
        let bytes = frames.saturating_mul(24 * vertices + JSON_BYTES * pieces + weights);
        let bytes = bytes.saturating_add(self.dressing.as_ref().map_or(0, Dressing::bytes));
        if bytes > u32::MAX.into() { Err(too_large(bytes)) } else { Ok(()) }
    }
}

impl MotionWriter for GltfMotion {
    fn frame(&mut self, surface: &Reconstruction, time: f64) -> Result<Vec<u8>> {
        let frame = self.spans.iter().map(|span| span.times.len()).sum::<usize>();
        check(surface, frame)?;
        let last = self.spans.last().and_then(|span| span.times.last());
        if frame >= self.frames || last.is_some_and(|last| time as f32 <= *last) {
            return Err(Error::Internal(format!("frame {frame} at {time} s of {} frames", self.frames)));
        }
        let changes = frame == 0 || !self.topology.is_of(surface);
        if changes {
            self.topology = Topology::of(surface);
            self.pieces = PieceOf::all(surface, self.dressing.as_ref(), self.compression, &mut self.file.chunk);
            self.check_size()?;
        }
        match self.spans.last_mut() {
            Some(span) if !changes && self.shown == Shown::Targets => {
                span.add(surface, time as f32, &self.pieces, &mut self.file.chunk)?;
            }
            _ => {
                self.spans.last_mut().into_iter().for_each(Span::end);
                self.spans.push(Span::new(surface, time as f32, &self.pieces, &mut self.file.chunk)?);
            }
        }
        let bytes = self.file.chunk.drain();
        self.written += bytes.len() as u64;
        if self.written > u32::MAX.into() { Err(too_large(self.written)) } else { Ok(bytes) }
    }

    fn finish(self: Box<Self>) -> Result<Vec<Part>> {
        let GltfMotion { written, spans, mut file, dressing, compression, .. } = *self;
        if spans.is_empty() {
            return Err(no_frames());
        }
        let starts: Vec<f32> = spans.iter().map(|span| span.times[0]).collect();
        for (index, span) in spans.into_iter().enumerate() {
            span.place(index, &starts, &mut file);
        }
        let mut root = json!({"asset": {"version": "2.0", "generator": "gimage"}});
        // glTF has no empty arrays: a surface without triangles is a file without a scene.
        if !file.meshes.is_empty() {
            let rough = json!({"baseColorFactor": COLOR, "metallicFactor": 0.0, "roughnessFactor": 0.9});
            match dressing {
                Some(dressing) => dressing.place(&mut root, &mut file.chunk),
                None => {
                    root["materials"] = json!([{"name": "cloth", "doubleSided": true, "pbrMetallicRoughness": rough}]);
                }
            }
            if compression == Compression::Draco {
                for key in ["extensionsUsed", "extensionsRequired"] {
                    push(&mut root[key], draco::EXTENSION.into());
                }
            }
            root["scene"] = 0.into();
            root["scenes"] = json!([{"nodes": file.roots}]);
            root["nodes"] = file.nodes.into();
            root["meshes"] = file.meshes.into();
        }
        if !file.channels.is_empty() {
            root["animations"] = json!([{"name": "motion", "channels": file.channels, "samplers": file.samplers}]);
        }
        let (head, rest) = file.chunk.ends(root)?;
        Ok(vec![Part::Bytes(head), Part::Written(0..written), Part::Bytes(rest)])
    }
}
