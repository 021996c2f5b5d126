//! Where the elements of an accessor lie in the buffer of a document, and their numbers.

use serde_json::Value;

pub(super) const FLOAT: u64 = 5126;
/// The mode of primitives that are lists of triangles, which is also the default.
pub(super) const TRIANGLES: u64 = 4;

/// An accessor of a document that is not sparse: where its elements lie.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub start: usize,
    pub stride: usize,
    pub count: usize,
    pub components: usize,
    pub kind: u64,
}

impl Layout {
    /// Of an accessor whose elements all lie in the buffer.
    pub fn of(json: &Value, bin: &[u8], accessor: u64) -> Option<Self> {
        let a = json["accessors"].get(accessor as usize)?;
        let view = json["bufferViews"].get(a["bufferView"].as_u64()? as usize)?;
        if a.get("sparse").is_some() || view.get("extensions").is_some() {
            return None;
        }
        let components = match a["type"].as_str()? {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => return None,
        };
        let kind = a["componentType"].as_u64()?;
        let size = match kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | FLOAT => 4,
            _ => return None,
        };
        let number = |of: &Value, key: &str| of[key].as_u64().unwrap_or(0) as usize;
        let stride = Some(number(view, "byteStride")).filter(|s| *s > 0).unwrap_or(components * size);
        let start = number(view, "byteOffset").checked_add(number(a, "byteOffset"))?;
        let count = number(a, "count");
        let end = count.checked_sub(1)?.checked_mul(stride)?.checked_add(start)?.checked_add(components * size)?;
        (end <= bin.len()).then_some(Layout { start, stride, count, components, kind })
    }

    pub fn is_finite(self, bin: &[u8], element: usize) -> bool {
        let at = self.start + element * self.stride;
        bin[at..at + 4 * self.components].as_chunks().0.iter().all(|b| f32::from_le_bytes(*b).is_finite())
    }

    pub fn floats(self, bin: &[u8], element: usize) -> Vec<f32> {
        let at = self.start + element * self.stride;
        bin[at..at + 4 * self.components].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
    }

    pub fn put(self, bin: &mut [u8], element: usize, values: &[f32]) {
        let at = self.start + element * self.stride;
        bin[at..at + 4 * self.components]
            .iter_mut()
            .zip(values.iter().flat_map(|v| v.to_le_bytes()))
            .for_each(|(to, b)| *to = b);
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self.kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        }
    }

    /// The numbers of all elements, as they are stored.
    pub fn numbers(self, bin: &[u8]) -> Vec<f64> {
        let elements = (0..self.count).map(|n| self.start + n * self.stride);
        let places = elements.flat_map(|at| (0..self.components).map(move |c| at + c * self.size()));
        places.map(|at| self.number(&bin[at..at + self.size()])).collect()
    }

    fn number(self, bytes: &[u8]) -> f64 {
        match (self.kind, bytes) {
            (5120, &[a]) => f64::from(a as i8),
            (5121, &[a]) => f64::from(a),
            (5122, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
            (5123, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (FLOAT, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (_, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }

    /// The bytes of a number; one that is not whole is rounded where the accessor has whole numbers.
    pub fn bytes(self, x: f64) -> Vec<u8> {
        match self.kind {
            5120 => vec![x.round() as i8 as u8],
            5121 => vec![x.round() as u8],
            5122 => (x.round() as i16).to_le_bytes().to_vec(),
            5123 => (x.round() as u16).to_le_bytes().to_vec(),
            FLOAT => (x as f32).to_le_bytes().to_vec(),
            _ => (x.round() as u32).to_le_bytes().to_vec(),
        }
    }
}
