//! A reconstruction as the text of an OBJ file or the bytes of a GLB file.

use crate::error::{Error, Result};
use crate::stage::reconstruct::{ReconstructedPiece, Reconstruction};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fmt::Write;

/// An OBJ file: shared positions and normals, texture coordinates turned to OBJ's convention (v up). Numbers are the
/// shortest that read back as the same f32.
pub fn obj(surface: &Reconstruction) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let mut line = |args: std::fmt::Arguments| out.write_fmt(args).unwrap_or_default();
    for p in &surface.positions {
        line(format_args!("v {} {} {}\n", p[0], p[1], p[2]));
    }
    for n in &surface.normals {
        line(format_args!("vn {} {} {}\n", n[0], n[1], n[2]));
    }
    let mut next_uv = 1;
    for piece in &surface.pieces {
        let name: String = piece.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        line(format_args!("o {}\n", if name.trim().is_empty() { "piece" } else { name.trim() }));
        let mut index: HashMap<[u32; 2], usize> = HashMap::new();
        let mut corner_uv = Vec::new();
        for uv in piece.uv.iter().flatten().flatten() {
            corner_uv.push(*index.entry(uv.map(f32::to_bits)).or_insert_with(|| {
                line(format_args!("vt {} {}\n", uv[0], 1.0 - uv[1]));
                next_uv += 1;
                next_uv - 1
            }));
        }
        for (t, corners) in piece_triangles(surface, piece).iter().enumerate() {
            line(format_args!("f"));
            for (c, v) in corners.iter().map(|v| v + 1).enumerate() {
                match corner_uv.get(3 * t + c) {
                    Some(uv) => line(format_args!(" {v}/{uv}/{v}")),
                    None => line(format_args!(" {v}//{v}")),
                }
            }
            line(format_args!("\n"));
        }
    }
    out
}

fn piece_triangles<'a>(surface: &'a Reconstruction, piece: &ReconstructedPiece) -> &'a [[u32; 3]] {
    surface.triangles.get(piece.triangles.clone()).unwrap_or_default()
}

/// The vertices of one piece as glTF wants them: one for each pair of position and texture coordinate.
#[derive(Default)]
struct Primitive {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl Primitive {
    fn new(surface: &Reconstruction, piece: &ReconstructedPiece) -> Self {
        let mut out = Self::default();
        let mut index: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        for (t, corners) in piece_triangles(surface, piece).iter().enumerate() {
            for (c, &v) in corners.iter().enumerate() {
                let uv = piece.uv.as_ref().and_then(|uv| uv.get(t)).map(|uv| uv[c]);
                let key = (v, uv.unwrap_or_default().map(f32::to_bits));
                let k = *index.entry(key).or_insert_with(|| {
                    out.positions.push(surface.positions[v as usize]);
                    out.normals.push(surface.normals[v as usize]);
                    out.uv.extend(uv);
                    out.positions.len() as u32 - 1
                });
                out.indices.push(k);
            }
        }
        out
    }
}

/// The binary chunk and the descriptions that point into it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends an array and returns its accessor; `kind` is glTF's name for `width` components.
    fn push<T: bytemuck::NoUninit>(
        &mut self,
        values: &[T],
        kind: &str,
        component: u32,
        bounds: Option<Value>,
    ) -> usize {
        let raw: &[u8] = bytemuck::cast_slice(values);
        let target = if kind == "SCALAR" { 34963 } else { 34962 };
        self.views
            .push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": raw.len(), "target": target}));
        self.bytes.extend_from_slice(raw);
        let view = self.views.len() - 1;
        let mut accessor = json!({"bufferView": view, "componentType": component, "count": values.len(), "type": kind});
        if let (Some(bounds), Some(fields)) = (bounds, accessor.as_object_mut()) {
            fields.insert("min".into(), bounds["min"].clone());
            fields.insert("max".into(), bounds["max"].clone());
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// A GLB file: a node and a mesh for each piece that has triangles.
pub fn glb(surface: &Reconstruction) -> Result<Vec<u8>> {
    const FLOAT: u32 = 5126;
    const UNSIGNED_INT: u32 = 5125;
    let vertices = surface.positions.len();
    if surface.normals.len() != vertices || surface.triangles.iter().flatten().any(|&v| v as usize >= vertices) {
        return Err(Error::Internal("a reconstruction with indices out of range".into()));
    }
    let mut buffer = Buffer::default();
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    for piece in surface.pieces.iter().filter(|p| !piece_triangles(surface, p).is_empty()) {
        let p = Primitive::new(surface, piece);
        let side =
            |f: fn(f32, f32) -> f32, from: f32| [0, 1, 2].map(|k| p.positions.iter().map(|p| p[k]).fold(from, f));
        let bounds = json!({"min": side(f32::min, f32::INFINITY), "max": side(f32::max, f32::NEG_INFINITY)});
        let mut attributes = json!({
            "POSITION": buffer.push(&p.positions, "VEC3", FLOAT, Some(bounds)),
            "NORMAL": buffer.push(&p.normals, "VEC3", FLOAT, None),
        });
        if p.uv.len() == p.positions.len() {
            attributes["TEXCOORD_0"] = buffer.push(&p.uv, "VEC2", FLOAT, None).into();
        }
        let indices = buffer.push(&p.indices, "SCALAR", UNSIGNED_INT, None);
        nodes.push(json!({"name": piece.name, "mesh": meshes.len()}));
        meshes.push(json!({"name": piece.name, "primitives": [{"attributes": attributes, "indices": indices}]}));
    }
    let mut root = json!({"asset": {"version": "2.0", "generator": "gimage"}});
    // glTF has no empty arrays: a surface without triangles is a file without a scene.
    if !nodes.is_empty() {
        root["scene"] = 0.into();
        root["scenes"] = json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]);
        root["nodes"] = nodes.into();
        root["meshes"] = meshes.into();
        root["buffers"] = json!([{"byteLength": buffer.bytes.len()}]);
        root["bufferViews"] = buffer.views.into();
        root["accessors"] = buffer.accessors.into();
    }
    container(root.to_string().into_bytes(), buffer.bytes)
}

/// The GLB header and its chunks.
fn container(mut text: Vec<u8>, binary: Vec<u8>) -> Result<Vec<u8>> {
    text.resize(text.len().next_multiple_of(4), b' ');
    // Every array holds whole 4-byte numbers: the binary chunk needs no padding.
    let chunks: &[(&[u8], &[u8; 4])] = &[(&text, b"JSON"), (&binary, b"BIN\0")];
    let chunks = &chunks[..if binary.is_empty() { 1 } else { 2 }];
    let total = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
    let length = u32::try_from(total).map_err(|_| Error::TooLarge {
        what: "the GLB file".into(),
        need: format!("{total} bytes"),
        limit: format!("{} bytes", u32::MAX),
        hint: "write an OBJ file instead".into(),
    })?;
    let mut out = Vec::with_capacity(total);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length.to_le_bytes());
    for (bytes, kind) in chunks {
        out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        out.extend_from_slice(*kind);
        out.extend_from_slice(bytes);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::grid::samples::cylinder;
    use crate::stage::reconstruct::{PieceView, reconstruct, samples::encode};

    fn sample() -> Reconstruction {
        let g = cylinder(9, 5, 0.1, 2.0);
        let (position, second) = (encode(&g, 0), encode(&g, 45));
        let uv: Vec<[f32; 2]> = (0..45).map(|k| [(k % 9) as f32 / 8.0, (k / 9) as f32 / 4.0]).collect();
        let (width, height) = (9, 5);
        reconstruct(&[
            PieceView { name: "a \"b\"\nc", width, height, first_particle: 0, position: &position, uv: Some(&uv) },
            PieceView { name: "", width, height, first_particle: 45, position: &second, uv: None },
        ])
        .unwrap()
    }

    #[test]
    fn obj_reads_back_bit_equal() {
        let r = sample();
        let options = tobj::LoadOptions::default();
        let (models, _) = tobj::load_obj_buf(&mut obj(&r).as_bytes(), &options, |_| Ok(Default::default())).unwrap();
        assert_eq!(models.len(), 2);
        let text = obj(&r);
        let positions: Vec<[f32; 3]> = text
            .lines()
            .filter_map(|l| l.strip_prefix("v "))
            .map(|l| {
                let n: Vec<f32> = l.split(' ').map(|x| x.parse().unwrap()).collect();
                [n[0], n[1], n[2]]
            })
            .collect();
        assert_eq!(positions, r.positions);
        assert_eq!(text.lines().filter(|l| l.starts_with("f ")).count(), r.triangles.len());
        assert_eq!(text.lines().filter(|l| l.starts_with("vt ")).count(), 45);
        assert!(text.contains("o a \"b\" c\n") && text.contains("o piece\n"));
        assert!(text.contains("vt 0 1\n"), "v points up");
    }

    #[test]
    fn glb_reads_back_bit_equal() {
        let r = sample();
        let file = gltf::Gltf::from_slice(&glb(&r).unwrap()).unwrap();
        let (document, blob) = (file.document, file.blob.unwrap());
        assert_eq!(document.nodes().next().unwrap().name(), Some("a \"b\"\nc"));
        let mut triangles = 0;
        for (mesh, piece) in document.meshes().zip(&r.pieces) {
            let primitive = mesh.primitives().next().unwrap();
            let reader = primitive.reader(|_| Some(&blob));
            let positions: Vec<_> = reader.read_positions().unwrap().collect();
            let indices: Vec<_> = reader.read_indices().unwrap().into_u32().collect();
            let expected = r.triangles[piece.triangles.clone()].iter().flatten();
            assert!(indices.iter().zip(expected).all(|(&k, &v)| positions[k as usize] == r.positions[v as usize]));
            let uv = reader.read_tex_coords(0).map(|t| t.into_f32().count());
            assert_eq!(uv, piece.uv.as_ref().map(|_| 45));
            assert_eq!(reader.read_normals().unwrap().count(), positions.len());
            let min = primitive.bounding_box().min;
            assert!(
                (0..3).all(|k| positions.iter().any(|p| p[k] == min[k]) && positions.iter().all(|p| p[k] >= min[k]))
            );
            triangles += indices.len() / 3;
        }
        assert_eq!(triangles, r.triangles.len());
    }

    #[test]
    fn an_empty_surface_is_a_valid_file() {
        let bytes = glb(&Reconstruction::default()).unwrap();
        assert!(gltf::Gltf::from_slice(&bytes).is_ok());
        assert_eq!(obj(&Reconstruction::default()), "");
    }
}
