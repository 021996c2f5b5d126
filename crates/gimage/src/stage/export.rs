//! A reconstruction as the text of an OBJ file or the bytes of a GLB file, and in motion.

mod draco;
pub mod glb;
pub mod motion;
mod packed;
mod split;

use crate::error::{Error, Result};
use crate::stage::export::glb::BinaryChunk;
use crate::stage::export::split::Split;
use crate::stage::reconstruct::{ReconstructedPiece, Reconstruction};
use serde_json::json;
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

/// A GLB file: a node and a mesh for each piece that has triangles.
pub fn glb(surface: &Reconstruction) -> Result<Vec<u8>> {
    let vertices = surface.positions.len();
    if surface.normals.len() != vertices || surface.triangles.iter().flatten().any(|&v| v as usize >= vertices) {
        return Err(Error::Internal("a reconstruction with indices out of range".into()));
    }
    let mut chunk = BinaryChunk::default();
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    for piece in surface.pieces.iter().filter(|p| !piece_triangles(surface, p).is_empty()) {
        let split = Split::new(surface, piece);
        let positions = split.of(&surface.positions);
        let mut attributes = json!({
            "POSITION": chunk.floats(&positions, glb::bounds(&positions)),
            "NORMAL": chunk.floats(&split.of(&surface.normals), json!({})),
        });
        if let Some(uv) = split.push_uv(&mut chunk) {
            attributes["TEXCOORD_0"] = uv.into();
        }
        let indices = split.push_indices(&mut chunk);
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
    }
    chunk.file(root)
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
