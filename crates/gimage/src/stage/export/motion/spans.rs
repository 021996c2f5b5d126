//! Frames of one topology in a glTF file: their meshes, and the animation that shows them.

use serde_json::{Value, json};

use super::super::draco::{self, Vertices};
use super::super::glb::{BinaryChunk, Component, bounds};
use super::super::split::Split;
use super::dressing::Dressing;
use crate::error::{Error, Result};
use crate::stage::reconstruct::Reconstruction;

/// How a glTF file shows frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// One mesh per piece with a morph target per frame after the first; weights animate linearly from frame to frame.
    #[default]
    Targets,
    /// A mesh per piece and frame; scales of 0 and 1 show one frame at a time.
    Meshes,
}

/// How a glTF file is compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    #[default]
    None,
    /// By `EXT_meshopt_compression`: vectors are rounded by at most 2^-17 of their largest component.
    Meshopt,
    /// By `KHR_draco_mesh_compression`, for [`Shown::Meshes`]: positions and texture coordinates have 16 bits over the box of each mesh, normals
    /// 12, colours 10.
    Draco,
}

/// A piece of a topology: its vertices, and what no frame changes.
pub struct PieceOf {
    name: String,
    split: Split,
    colors: Option<Vec<[f32; 4]>>,
    /// The accessors of what frames share; none where each frame is compressed by itself.
    shared: Option<Shared>,
    material: usize,
}

/// Accessors that frames share.
struct Shared {
    uv: Option<usize>,
    color: Option<usize>,
    indices: usize,
}

impl PieceOf {
    /// The pieces of a surface that have triangles; for Draco without anything that frames share.
    pub fn all(
        surface: &Reconstruction,
        dressing: Option<&Dressing>,
        compression: Compression,
        chunk: &mut BinaryChunk,
    ) -> Vec<Self> {
        let there = surface.pieces.iter().enumerate().filter(|(_, piece)| !piece.triangles.is_empty());
        let of = there.map(|(index, piece)| {
            let mut split = Split::new(surface, piece);
            if compression == Compression::Meshopt {
                split.optimize();
            }
            let colors = dressing.and_then(|d| d.colors(&split.points));
            let shared = (compression != Compression::Draco).then(|| Shared {
                uv: split.push_uv(chunk),
                color: colors.as_ref().map(|c| chunk.floats(c, json!({}))),
                indices: split.push_indices(chunk),
            });
            let material = dressing.map_or(0, |d| d.material(index));
            PieceOf { name: piece.name.clone(), split, colors, shared, material }
        });
        of.collect()
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.split.points.len()
    }

    /// The primitive of a frame.
    fn primitive(&self, surface: &Reconstruction, chunk: &mut BinaryChunk) -> Result<Value> {
        let (positions, normals) = (self.split.of(&surface.positions), self.split.of(&surface.normals));
        let mut primitive = match &self.shared {
            Some(Shared { uv, color, indices }) => {
                let mut attributes = json!({
                    "POSITION": chunk.floats(&positions, bounds(&positions)),
                    "NORMAL": chunk.floats(&normals, json!({})),
                });
                for (name, accessor) in [("TEXCOORD_0", uv), ("COLOR_0", color)] {
                    if let Some(accessor) = accessor {
                        attributes[name] = (*accessor).into();
                    }
                }
                json!({"attributes": attributes, "indices": indices})
            }
            None => {
                let vertices = Vertices {
                    positions: &positions,
                    normals: &normals,
                    uv: self.split.uv(),
                    colors: self.colors.as_deref(),
                };
                draco::primitive(&vertices, self.split.indices(), chunk).map_err(|problem| Error::Piece {
                    piece: self.name.clone(),
                    stage: "export",
                    problem: format!("Draco: {problem}"),
                    hint: "export it with `--compress meshopt`, or without compression".into(),
                })?
            }
        };
        primitive["material"] = self.material.into();
        Ok(primitive)
    }
}

/// Frames one after another with the same vertices.
pub struct Span {
    /// Times \[s\] of the frames.
    pub times: Vec<f32>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    meshes: Vec<Value>,
}

impl Span {
    /// Begins with a frame, which is what a mesh shows without weights. Errors on a piece that cannot be compressed.
    pub fn new(surface: &Reconstruction, time: f32, pieces: &[PieceOf], chunk: &mut BinaryChunk) -> Result<Self> {
        let mesh = |piece: &PieceOf| Ok(json!({"name": piece.name, "primitives": [piece.primitive(surface, chunk)?]}));
        let meshes = pieces.iter().map(mesh).collect::<Result<_>>()?;
        let (positions, normals) = (surface.positions.clone(), surface.normals.clone());
        Ok(Span { times: vec![time], positions, normals, meshes })
    }

    /// Adds a frame as a morph target. Errors if a vertex has moved farther than floats reach.
    pub fn add(
        &mut self,
        surface: &Reconstruction,
        time: f32,
        pieces: &[PieceOf],
        chunk: &mut BinaryChunk,
    ) -> Result<()> {
        let frame = self.times.len();
        for (piece, mesh) in pieces.iter().zip(&mut self.meshes) {
            let deltas = |now: &[[f32; 3]], first: &[[f32; 3]]| -> Vec<[f32; 3]> {
                let delta = |p: &u32| [0, 1, 2].map(|c| now[*p as usize][c] - first[*p as usize][c]);
                piece.split.points.iter().map(delta).collect()
            };
            let moved = deltas(&surface.positions, &self.positions);
            if moved.as_flattened().iter().any(|x| !x.is_finite()) {
                return Err(Error::Piece {
                    piece: piece.name.clone(),
                    stage: "export",
                    problem: format!("frame {frame} is farther from the first one than 32-bit floats reach"),
                    hint: "export it by `--as meshes`, or as OBJ or USD".into(),
                });
            }
            let turned = deltas(&surface.normals, &self.normals);
            let target =
                json!({"POSITION": target(&moved, bounds(&moved), chunk), "NORMAL": target(&turned, json!({}), chunk)});
            let primitive = &mut mesh["primitives"][0];
            if primitive["targets"].is_null() {
                primitive["targets"] = json!([]);
            }
            if let Some(list) = primitive["targets"].as_array_mut() {
                list.push(target);
            }
        }
        self.times.push(time);
        Ok(())
    }

    /// Forgets what only further frames would need.
    pub fn end(&mut self) {
        (self.positions, self.normals) = Default::default();
    }

    /// Puts its meshes into nodes, and what shows them into the animation. `all` is the times of the starts of all spans.
    pub fn place(self, index: usize, all: &[f32], file: &mut Contents) {
        let frames = self.times.len();
        let mut children = Vec::new();
        let weights = (frames > 1).then(|| file.sampler(&self.times, &weights(frames), "SCALAR", "LINEAR"));
        for mut mesh in self.meshes {
            let node = file.nodes.len();
            if let Some(sampler) = weights {
                let names: Vec<_> = (1..frames).map(|k| format!("{} s", self.times[k])).collect();
                mesh["extras"] = json!({"targetNames": names});
                let target = json!({"node": node, "path": "weights"});
                file.channels.push(json!({"sampler": sampler, "target": target}));
            }
            children.push(node);
            file.nodes.push(json!({"name": mesh["name"], "mesh": file.meshes.len()}));
            file.meshes.push(mesh);
        }
        if all.len() < 2 {
            file.roots.extend(children);
            return;
        }
        let node = file.nodes.len();
        let hidden = index > 0;
        let mut keys = vec![(0.0, if hidden { 0.0f32 } else { 1.0 })];
        keys.extend(hidden.then(|| (all[index], 1.0)));
        keys.extend(all.get(index + 1).map(|end| (*end, 0.0)));
        let times: Vec<f32> = keys.iter().map(|k| k.0).collect();
        let scales: Vec<u8> = keys.iter().flat_map(|k| [k.1; 3]).flat_map(f32::to_le_bytes).collect();
        let sampler = file.sampler(&times, &scales, "VEC3", "STEP");
        file.channels.push(json!({"sampler": sampler, "target": {"node": node, "path": "scale"}}));
        let scale = if hidden { 0.0 } else { 1.0 };
        file.nodes.push(
            json!({"name": format!("from {} s", all[index]), "children": children, "scale": [scale, scale, scale]}),
        );
        file.roots.push(node);
    }
}

/// The contents of a file so far.
#[derive(Default)]
pub struct Contents {
    pub chunk: BinaryChunk,
    pub roots: Vec<usize>,
    pub nodes: Vec<Value>,
    pub meshes: Vec<Value>,
    pub channels: Vec<Value>,
    pub samplers: Vec<Value>,
}

impl Contents {
    /// A sampler of the animation with keys at `times` \[s\]; `output` is their values of a `kind`.
    fn sampler(&mut self, times: &[f32], output: &[u8], kind: &str, interpolation: &str) -> usize {
        let limits = json!({"max": times.last().map(|t| [t]), "min": times.first().map(|t| [t])});
        let input: Vec<u8> = times.iter().flat_map(|t| t.to_le_bytes()).collect();
        let input = self.chunk.push(&input, None, times.len(), "SCALAR", Component::F32, limits);
        let count = output.len() / if kind == "VEC3" { 12 } else { 4 };
        let output = self.chunk.push(output, None, count, kind, Component::F32, json!({}));
        self.samplers.push(json!({"input": input, "interpolation": interpolation, "output": output}));
        self.samplers.len() - 1
    }
}

/// The weights of all targets at each of `frames` frames: 1 for the target of the frame. The first has none.
fn weights(frames: usize) -> Vec<u8> {
    let mut all = vec![0; 4 * frames * (frames - 1)];
    for frame in 1..frames {
        let at = 4 * (frame * (frames - 1) + frame - 1);
        all[at..at + 4].copy_from_slice(&1.0f32.to_le_bytes());
    }
    all
}

/// The accessor of the differences of a target: without those that are 0 where that is smaller.
fn target(deltas: &[[f32; 3]], more: Value, chunk: &mut BinaryChunk) -> usize {
    let changed = |k: &u32| deltas[*k as usize] != [0.0; 3];
    let indices: Vec<u32> = (0..deltas.len() as u32).filter(changed).collect();
    // An index of up to 4 bytes and a value of 12, against a value for each vertex.
    if 16 * indices.len() >= 12 * deltas.len() {
        return chunk.floats(deltas, more);
    }
    let values: Vec<_> = indices.iter().map(|k| deltas[*k as usize]).collect();
    chunk.sparse((&indices, &values), deltas.len(), more)
}
