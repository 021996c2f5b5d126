//! Data of buffer views, compressed with `EXT_meshopt_compression`.

use meshopt::{EncodeExpMode, decode_filter_exp, encode_filter_exp, encode_index_buffer, encode_index_sequence};
use serde_json::{Value, json};

/// The name of the extension.
pub(super) const EXTENSION: &str = "EXT_meshopt_compression";

/// Bits of the numbers of vectors that are rounded, with the sign: the largest component of a vector has a whole number from 2^16 to 2^17, so
/// that the error is at most 2^-17 of it.
const BITS: i32 = 18;
/// The version of the vertex codec that the extension has, and how hard it tries.
const VERTEX_VERSION: i32 = 0;
const LEVEL: i32 = 2;

/// The bytes of a view, and how a reader unpacks them.
pub(super) struct Packed {
    pub bytes: Vec<u8>,
    stride: usize,
    count: usize,
    mode: &'static str,
    filter: Option<&'static str>,
}

macro_rules! by_words {
    ($data:expr, $words:expr, $($n:literal)*) => {
        match $words {
            $($n => vertices(words::<$n>($data)),)*
            _ => None,
        }
    };
}

impl Packed {
    /// Elements of `stride` bytes, 4 to 16, exactly as they are; `None` for other strides, and without any.
    pub fn elements(data: &[u8], stride: usize) -> Option<Self> {
        if stride == 0 || !stride.is_multiple_of(4) || !data.len().is_multiple_of(stride) || data.is_empty() {
            return None;
        }
        let bytes = by_words!(data, stride / 4, 1 2 3 4)?;
        Some(Packed { bytes, stride, count: data.len() / stride, mode: "ATTRIBUTES", filter: None })
    }

    /// Vectors, rounded to [`BITS`] bits, and the rounded vectors.
    pub fn floats<const N: usize>(data: &[[f32; N]]) -> Option<(Self, Vec<[f32; N]>)> {
        let mut filtered = encode_filter_exp(data, BITS, EncodeExpMode::SharedVector);
        let bytes = vertices(filtered.clone())?;
        decode_filter_exp(&mut filtered);
        let rounded = filtered.into_iter().map(|v| v.map(f32::from_bits)).collect();
        let packed =
            Packed { bytes, stride: 4 * N, count: data.len(), mode: "ATTRIBUTES", filter: Some("EXPONENTIAL") };
        Some((packed, rounded))
    }

    /// Indices of triangles, of `width` bytes in the file; corners of a triangle may be turned.
    pub fn triangles(indices: &[u32], width: usize) -> Option<Self> {
        if indices.is_empty() || !indices.len().is_multiple_of(3) {
            return None;
        }
        let bytes = encode_index_buffer(indices, count(indices)).ok()?;
        Some(Packed { bytes, stride: width, count: indices.len(), mode: "TRIANGLES", filter: None })
    }

    /// Indices of anything, of `width` bytes in the file.
    pub fn sequence(indices: &[u32], width: usize) -> Option<Self> {
        if indices.is_empty() {
            return None;
        }
        let bytes = encode_index_sequence(indices, count(indices)).ok()?;
        Some(Packed { bytes, stride: width, count: indices.len(), mode: "INDICES", filter: None })
    }

    /// The bytes that a reader makes of it.
    pub fn length(&self) -> usize {
        self.stride * self.count
    }

    /// The extension of a view whose compressed bytes lie in buffer 0.
    pub fn extension(&self, offset: usize) -> Value {
        let mut of = json!({
            "buffer": 0,
            "byteLength": self.bytes.len(),
            "byteOffset": offset,
            "byteStride": self.stride,
            "count": self.count,
            "mode": self.mode,
        });
        if let Some(filter) = self.filter {
            of["filter"] = filter.into();
        }
        json!({ EXTENSION: of })
    }
}

/// One more than the largest index.
fn count(indices: &[u32]) -> usize {
    indices.iter().max().map_or(0, |k| *k as usize + 1)
}

/// Elements of words.
fn words<const N: usize>(data: &[u8]) -> Vec<[u32; N]> {
    let word = |b: &[u8]| b.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
    data.chunks_exact(4 * N).map(|e| std::array::from_fn(|k| word(&e[4 * k..]))).collect()
}

fn vertices<const N: usize>(data: Vec<[u32; N]>) -> Option<Vec<u8>> {
    meshopt::encode_vertex_buffer_level(&data, LEVEL, Some(VERTEX_VERSION)).ok()
}
