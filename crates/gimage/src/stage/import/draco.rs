//! Primitives compressed with `KHR_draco_mesh_compression`.

use std::panic::catch_unwind;

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

/// A decoded primitive.
pub(crate) struct Decoded(Mesh);

/// Decodes a stream within limits, or says what is wrong with it.
pub(crate) fn decode(data: &[u8], max_vertices: usize, max_triangles: usize) -> Result<Decoded, String> {
    let limits = DecodeLimits::default()
        .with_max_points(max_vertices as u64)
        .with_max_faces(max_triangles as u64)
        .with_max_decoded_bytes((max_vertices as u64).saturating_mul(64));
    let attempt = || {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(data).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh).map_err(|e| e.to_string())
    };
    catch_unwind(attempt).unwrap_or_else(|_| Err("the decoder gave up".into())).map(Decoded)
}

impl Decoded {
    pub fn vertex_count(&self) -> usize {
        self.0.num_points()
    }

    /// All vertex indices, three a triangle.
    pub fn indices(&self) -> Vec<u32> {
        self.0.faces().iter().flatten().map(|p| p.0).collect()
    }

    /// The values of an attribute as (width, values), integers as they are.
    pub fn attribute(&self, unique_id: u32) -> Option<(usize, Vec<f32>)> {
        let attribute = self.0.attribute_by_unique_id(unique_id)?;
        let width = attribute.num_components() as usize;
        Some((width, attribute.read_f32s(self.0.num_points(), width)))
    }
}
