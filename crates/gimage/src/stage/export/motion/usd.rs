//! A surface in motion as the text of a USD file.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;

use super::usd_names::{identifier, identifiers, quoted};
use super::{MotionWriter, Part, Topology, check, no_frames, piece_triangles};
use crate::error::{Error, Result};
use crate::stage::reconstruct::{ReconstructedPiece, Reconstruction};

/// Writes a USD file as text (.usda): a UsdGeomMesh per piece, with time samples of points, normals and extent.
///
/// Frames have the time codes 1, 2, 3, ...; metres, Y up. Each point of a seam is one point; texture coordinates are per corner of a face
/// (`faceVarying`), their v up. If triangles change, faces have time samples too. Numbers are the shortest that read back as the same f32.
/// Pieces without triangles are left out.
pub struct UsdMotion {
    name: String,
    rate: f64,
    frames: usize,
    written: u64,
    topology: Topology,
    meshes: Vec<Mesh>,
}

/// A piece, and where the text of its samples lies.
#[derive(Default)]
struct Mesh {
    name: String,
    /// The position of the surface that each of its points has.
    points: Vec<u32>,
    /// Whether any frame has triangles of it.
    is_drawn: bool,
    /// The text of faces by the first frame that has them.
    faces: Vec<(usize, Faces)>,
    extent: String,
    positions: Vec<Range<u64>>,
    normals: Vec<Range<u64>>,
}

/// The text of arrays.
#[derive(Default)]
struct Faces {
    counts: String,
    indices: String,
    uv: Option<String>,
}

impl UsdMotion {
    /// A file whose root is named after `name`, with `rate` frames per second.
    pub fn new(name: &str, rate: f64) -> Self {
        let (topology, meshes) = Default::default();
        UsdMotion { name: name.into(), rate, frames: 0, written: 0, topology, meshes }
    }

    fn begin(&mut self, surface: &Reconstruction) -> Result<()> {
        self.topology = Topology::of(surface);
        if self.frames == 0 {
            self.meshes = surface.pieces.iter().map(|p| Mesh { name: p.name.clone(), ..Mesh::default() }).collect();
        }
        if self.meshes.len() != surface.pieces.len() {
            return Err(Error::Internal(format!("frame {} has other pieces", self.frames)));
        }
        for (mesh, piece) in self.meshes.iter_mut().zip(&surface.pieces) {
            let faces = mesh.faces(surface, piece);
            mesh.faces.push((self.frames + 1, faces));
        }
        Ok(())
    }
}

impl MotionWriter for UsdMotion {
    fn frame(&mut self, surface: &Reconstruction, _time: f64) -> Result<Vec<u8>> {
        check(surface, self.frames)?;
        if self.frames == 0 || !self.topology.is_of(surface) {
            self.begin(surface)?;
        }
        self.frames += 1;
        let mut text = String::new();
        for mesh in &mut self.meshes {
            let extent = extent(mesh.points.iter().map(|p| surface.positions[*p as usize]));
            line(&mut mesh.extent, format_args!("            {}: {},\n", self.frames, array(&extent)));
            for (list, ranges) in [(&surface.positions, &mut mesh.positions), (&surface.normals, &mut mesh.normals)] {
                let start = self.written + text.len() as u64;
                line(&mut text, format_args!("            {}: ", self.frames));
                push_array(&mut text, mesh.points.iter().map(|p| list[*p as usize]));
                text.push_str(",\n");
                ranges.push(start..self.written + text.len() as u64);
            }
        }
        self.written += text.len() as u64;
        Ok(text.into_bytes())
    }

    fn finish(self: Box<Self>) -> Result<Vec<Part>> {
        if self.frames == 0 {
            return Err(no_frames());
        }
        let mut out = Text::default();
        let (root, rate) = (identifier(&self.name), self.rate);
        out.add(format_args!("#usda 1.0\n(\n    defaultPrim = \"{root}\"\n    doc = \"gimage export\"\n"));
        out.add(format_args!("    endTimeCode = {}\n    framesPerSecond = {rate}\n", self.frames));
        out.add(format_args!("    metersPerUnit = 1\n    startTimeCode = 1\n    timeCodesPerSecond = {rate}\n"));
        out.add(format_args!("    upAxis = \"Y\"\n)\n\ndef Xform \"{root}\" (\n    kind = \"component\"\n)\n{{\n"));
        let there = || self.meshes.iter().filter(|mesh| mesh.is_drawn);
        let names = identifiers(there().map(|mesh| mesh.name.as_str()));
        for (mesh, name) in there().zip(&names) {
            mesh.write(name, &mut out);
        }
        out.add(format_args!("}}\n"));
        Ok(out.finish())
    }
}

impl Mesh {
    /// The text of its faces; its points are those of these faces from now on.
    fn faces(&mut self, surface: &Reconstruction, piece: &ReconstructedPiece) -> Faces {
        let triangles = piece_triangles(surface, piece);
        let mut local = BTreeMap::new();
        triangles.as_flattened().iter().for_each(|v| _ = local.insert(*v, 0u32));
        local.values_mut().zip(0..).for_each(|(at, k)| *at = k);
        self.points = local.keys().copied().collect();
        self.is_drawn |= !triangles.is_empty();
        let mut faces = Faces::default();
        push_list(&mut faces.counts, triangles.iter().map(|_| 3));
        push_list(&mut faces.indices, triangles.as_flattened().iter().map(|v| local[v]));
        faces.uv = piece.uv.as_ref().map(|uv| {
            let mut text = String::new();
            push_array(&mut text, uv.as_flattened().iter().map(|[u, v]| [*u, 1.0 - v]));
            text
        });
        faces
    }

    fn write(&self, name: &str, out: &mut Text) {
        out.add(format_args!(
            "    def Mesh \"{name}\" (\n        displayName = {}\n    )\n    {{\n",
            quoted(&self.name)
        ));
        out.add(format_args!("        uniform bool doubleSided = 1\n        float3[] extent.timeSamples = {{\n"));
        out.add(format_args!("{}        }}\n", self.extent));
        self.write_faces("int[] faceVertexCounts", |faces| Some(&faces.counts), out);
        self.write_faces("int[] faceVertexIndices", |faces| Some(&faces.indices), out);
        out.add(format_args!("        normal3f[] normals (\n            interpolation = \"vertex\"\n        )\n"));
        for (attribute, ranges) in [("normal3f[] normals", &self.normals), ("point3f[] points", &self.positions)] {
            out.add(format_args!("        {attribute}.timeSamples = {{\n"));
            ranges.iter().for_each(|range| out.written(range.clone()));
            out.add(format_args!("        }}\n"));
        }
        if self.faces.iter().any(|(_, faces)| faces.uv.is_some()) {
            let uv = "texCoord2f[] primvars:st";
            out.add(format_args!("        {uv} (\n            interpolation = \"faceVarying\"\n        )\n"));
            self.write_faces(uv, |faces| faces.uv.as_ref(), out);
        }
        out.add(format_args!("        uniform token subdivisionScheme = \"none\"\n    }}\n"));
    }

    /// An attribute of its faces: one value, or a sample per change.
    fn write_faces(&self, attribute: &str, text: impl Fn(&Faces) -> Option<&String>, out: &mut Text) {
        if let [(_, only)] = &self.faces[..] {
            out.add(format_args!("        {attribute} = {}\n", text(only).map_or("[]", String::as_str)));
            return;
        }
        out.add(format_args!("        {attribute}.timeSamples = {{\n"));
        for (frame, faces) in &self.faces {
            out.add(format_args!("            {frame}: {},\n", text(faces).map_or("[]", String::as_str)));
        }
        out.add(format_args!("        }}\n"));
    }
}

/// Text with ranges of the bytes of frames in it.
#[derive(Default)]
struct Text {
    parts: Vec<Part>,
    text: String,
}

impl Text {
    fn add(&mut self, args: std::fmt::Arguments) {
        line(&mut self.text, args);
    }

    fn written(&mut self, range: Range<u64>) {
        if !self.text.is_empty() {
            self.parts.push(Part::Bytes(std::mem::take(&mut self.text).into_bytes()));
        }
        self.parts.push(Part::Written(range));
    }

    fn finish(mut self) -> Vec<Part> {
        self.parts.push(Part::Bytes(self.text.into_bytes()));
        self.parts
    }
}

/// Writing to a string cannot fail.
fn line(out: &mut String, args: std::fmt::Arguments) {
    out.write_fmt(args).unwrap_or_default();
}

/// The box around points: its low and its high corner; at the origin without points.
fn extent(mut points: impl Iterator<Item = [f32; 3]>) -> [[f32; 3]; 2] {
    let first = points.next().unwrap_or_default();
    points
        .fold([first; 2], |[low, high], p| [[0, 1, 2].map(|c| low[c].min(p[c])), [0, 1, 2].map(|c| high[c].max(p[c]))])
}

fn array<const N: usize>(values: &[[f32; N]]) -> String {
    let mut text = String::new();
    push_array(&mut text, values.iter().copied());
    text
}

/// An array of vectors: `[(0, 1, 0.5), ...]`.
fn push_array<const N: usize>(out: &mut String, values: impl Iterator<Item = [f32; N]>) {
    out.push('[');
    for (k, value) in values.enumerate() {
        out.push_str(if k > 0 { ", (" } else { "(" });
        for (c, x) in value.iter().enumerate() {
            line(out, format_args!("{}{x}", if c > 0 { ", " } else { "" }));
        }
        out.push(')');
    }
    out.push(']');
}

/// An array of numbers.
fn push_list(out: &mut String, values: impl Iterator<Item = u32>) {
    out.push('[');
    for (k, value) in values.enumerate() {
        line(out, format_args!("{}{value}", if k > 0 { ", " } else { "" }));
    }
    out.push(']');
}
