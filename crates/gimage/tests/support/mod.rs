//! Builds small GLB files, and finds the shared garments.

use std::path::{Path, PathBuf};

use crate::skip;
use gimage::import::{ImportOptions, Imported, import_bytes};
use gimage::{Error, Result};
use serde_json::{Value, json};

/// A GLB file under construction.
pub struct Glb {
    pub json: Value,
    pub bin: Vec<u8>,
}

pub const F32: u32 = 5126;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;

impl Default for Glb {
    fn default() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "n"}],
            "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]
        });
        Self { json, bin: Vec::new() }
    }
}

impl Glb {
    pub fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.json.as_object_mut().unwrap().entry(list).or_insert(json!([])).as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let at = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": at, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "count": count, "type": kind}))
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, F32, values.len() / width, &bytes)
    }

    pub fn u16s(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", U16, values.len(), &bytes)
    }

    /// Adds a mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"name": "m", "primitives": [primitive]}))
    }

    pub fn finish(mut self) -> Vec<u8> {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = b"glTF".to_vec();
        let word = |out: &mut Vec<u8>, w: usize| out.extend_from_slice(&(w as u32).to_le_bytes());
        word(&mut out, 2);
        word(&mut out, 28 + text.len() + self.bin.len());
        word(&mut out, text.len());
        out.extend_from_slice(b"JSON");
        out.extend(text);
        word(&mut out, self.bin.len());
        out.extend_from_slice(b"BIN\0");
        out.extend(self.bin);
        out
    }
}

/// The unit square in the plane z = 0: positions of its four corners.
pub const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

/// A square of two triangles with normals and texture coordinates.
pub fn square() -> Glb {
    let mut glb = Glb::default();
    let p = glb.floats("VEC3", &SQUARE);
    let n = glb.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let t = glb.floats("VEC2", &[0., 1., 1., 1., 1., 0., 0., 0.]);
    let i = glb.u16s(&[0, 1, 2, 0, 2, 3]);
    glb.mesh(json!({"attributes": {"POSITION": p, "NORMAL": n, "TEXCOORD_0": t}, "indices": i}));
    glb
}

pub fn load_with(name: &str, bytes: &[u8], options: &ImportOptions) -> Result<Imported> {
    let none = |_: &str| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
    import_bytes(Path::new(name), bytes, &none, options)
}

pub fn load(glb: Glb) -> Result<Imported> {
    load_with("test.glb", &glb.finish(), &ImportOptions::default())
}

pub fn load_obj(text: &str) -> Result<Imported> {
    load_with("test.obj", text.as_bytes(), &ImportOptions::default())
}

pub fn has(imported: &Imported, kind: &str) -> bool {
    imported.findings.iter().any(|f| f.kind == kind)
}

pub fn is_malformed(result: &Result<Imported>, words: &str) -> bool {
    matches!(result, Err(e @ Error::Malformed { .. }) if e.to_string().contains(words))
}

/// Checks what every imported mesh keeps.
pub fn check(imported: &Imported) {
    let mesh = &imported.mesh;
    assert_eq!(mesh.triangles.len(), mesh.triangle_part.len());
    assert!(mesh.triangle_part.iter().all(|&p| (p as usize) < mesh.parts.len()));
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    assert!(used.iter().all(|u| *u), "unused vertices");
    assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
    for c in &mesh.channels {
        assert_eq!(c.corners.len(), 3 * mesh.triangles.len());
        assert!(c.values.iter().all(|v| v.is_finite()), "{:?}", c.semantic);
        assert!(c.corners.iter().all(|&k| k == gimage::mesh::NONE || (k as usize) < c.values.len() / c.width));
    }
    assert!(mesh.channels.windows(2).all(|w| w[0].semantic < w[1].semantic));
}

/// The folder of the shared garments, if it is there.
pub fn garments() -> Option<PathBuf> {
    let shared = match std::env::var_os("GIMAGE_SHARED") {
        Some(path) => PathBuf::from(path),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
    };
    Some(shared.join("garments")).filter(|p| p.is_dir())
}

/// The same, or a line that says that the test was skipped.
pub fn garments_or_skip(test: &str) -> Option<PathBuf> {
    let found = garments();
    if found.is_none() {
        skip::skip(&format!("{test}: no shared garments (set GIMAGE_SHARED to the folder that holds garments/)"));
    }
    found
}
