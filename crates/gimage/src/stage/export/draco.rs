//! Primitives compressed with `KHR_draco_mesh_compression`.

use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
};
use serde_json::{Map, Value, json};

use super::glb::{BinaryChunk, bounds};
use crate::stage::import::draco::decode;

/// The name of the extension.
pub(crate) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// Bits of positions and texture coordinates over the box of each, of normals and of colours.
const POSITION_BITS: i32 = 16;
const NORMAL_BITS: i32 = 12;
const UV_BITS: i32 = 16;
const COLOR_BITS: i32 = 10;
/// How hard the encoder tries: edgebreaker with valences, which is the smallest on most meshes.
const LEVEL: i32 = 4;

/// The vertices of a primitive; lists that are there are as long as `positions`.
pub(crate) struct Vertices<'a> {
    pub positions: &'a [[f32; 3]],
    pub normals: &'a [[f32; 3]],
    pub uv: Option<&'a [[f32; 2]]>,
    pub colors: Option<&'a [[f32; 4]]>,
}

/// The primitive of some vertices and triangles, without its material, with its compressed data in a chunk. The data is decoded again for the counts
/// and bounds that the file states: the encoder orders vertices and triangles, and leaves out triangles of equal corners. Errors with what went
/// wrong.
pub(crate) fn primitive(vertices: &Vertices, indices: &[u32], chunk: &mut BinaryChunk) -> Result<Value, String> {
    let (bytes, ids) = catch_unwind(AssertUnwindSafe(|| encode(vertices, indices)))
        .unwrap_or_else(|_| Err("the encoder gave up".into()))?;
    // Vertices at which surfaces only touch become one per surface.
    let decoded = decode(&bytes, indices.len(), indices.len() / 3)?;
    let (count, corners) = (decoded.vertex_count(), decoded.indices().len());
    if corners == 0 {
        return Err("no triangle has three different corners".into());
    }
    let view = chunk.view(&bytes, None);
    let (mut attributes, mut of) = (Map::new(), Map::new());
    for (name, kind, id) in ids {
        let mut accessor = json!({"componentType": 5126, "count": count, "type": kind});
        if name == "POSITION" {
            let (_, values) = decoded.attribute(id).ok_or("positions are lost")?;
            let limits = bounds(values.as_chunks().0);
            (accessor["max"], accessor["min"]) = (limits["max"].clone(), limits["min"].clone());
        }
        attributes.insert(name.into(), chunk.bare(accessor).into());
        of.insert(name.into(), id.into());
    }
    let indices = chunk.bare(json!({"componentType": 5125, "count": corners, "type": "SCALAR"}));
    let extension = json!({EXTENSION: {"attributes": of, "bufferView": view}});
    Ok(json!({"attributes": attributes, "extensions": extension, "indices": indices}))
}

/// Names of glTF for an attribute and its elements, and its number in the stream.
type Id = (&'static str, &'static str, u32);

fn encode(vertices: &Vertices, indices: &[u32]) -> Result<(Vec<u8>, Vec<Id>), String> {
    use GeometryAttributeType::{Color, Normal, Position, TexCoord};
    let mut mesh = Mesh::new();
    mesh.set_num_points(vertices.positions.len());
    let mut options = EncoderOptions::new();
    options.set_compression_level(LEVEL);
    let mut names = Vec::new();
    let mut add = |kind, name: (&'static str, &'static str), width: usize, bits: i32, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, width as u8, DataType::Float32, false, values.len() / width);
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        attribute.buffer_mut().write(0, &bytes);
        let id = mesh.add_attribute(attribute);
        options.set_attribute_quantization(id, bits);
        names.push((id, name));
    };
    add(Position, ("POSITION", "VEC3"), 3, POSITION_BITS, vertices.positions.as_flattened());
    add(Normal, ("NORMAL", "VEC3"), 3, NORMAL_BITS, vertices.normals.as_flattened());
    if let Some(uv) = vertices.uv {
        add(TexCoord, ("TEXCOORD_0", "VEC2"), 2, UV_BITS, uv.as_flattened());
    }
    if let Some(colors) = vertices.colors {
        add(Color, ("COLOR_0", "VEC4"), 4, COLOR_BITS, colors.as_flattened());
    }
    mesh.set_num_faces(indices.len() / 3);
    for (face, t) in (0..).zip(indices.as_chunks::<3>().0) {
        mesh.set_face(FaceIndex(face), t.map(Into::into));
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut buffer = EncoderBuffer::new();
    let info = encoder.encode_with_info(&options, &mut buffer).map_err(|e| e.to_string())?;
    let id = |(source, (name, kind)): (i32, (&'static str, &'static str))| {
        let found = info.attributes.iter().find(|a| a.source_attribute_id == source);
        found.map(|a| (name, kind, a.unique_id)).ok_or_else(|| format!("{name} is lost"))
    };
    let ids = names.into_iter().map(id).collect::<Result<_, _>>()?;
    Ok((buffer.data().to_vec(), ids))
}
