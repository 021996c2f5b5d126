//! Accessors: every range is checked before a byte is read or memory is reserved.

use serde_json::Value;

use super::{RenderFile, damaged};
use crate::error::Result;

/// Numbers of an accessor: `width` floats per element.
pub(super) struct Floats {
    pub width: usize,
    pub values: Vec<f32>,
}

/// How elements lie in a view.
struct Layout {
    component: u64,
    normalized: bool,
    width: usize,
}

impl Layout {
    fn component_bytes(&self) -> usize {
        match self.component {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        }
    }

    /// One component as a number; integers are divided by their largest value if they are normalised.
    fn read(&self, bytes: &[u8]) -> f32 {
        let (value, most) = match (self.component, bytes) {
            (5120, &[a, ..]) => (f32::from(a as i8), 127.0),
            (5121, &[a, ..]) => (f32::from(a), 255.0),
            (5122, &[a, b, ..]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (5123, &[a, b, ..]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (5125, &[a, b, c, d, ..]) => return u32::from_le_bytes([a, b, c, d]) as f32,
            (_, &[a, b, c, d, ..]) => return f32::from_le_bytes([a, b, c, d]),
            _ => return 0.0,
        };
        if self.normalized { f32::max(value / most, -1.0) } else { value }
    }
}

fn number(value: &Value, key: &str, default: u64) -> usize {
    value[key].as_u64().unwrap_or(default) as usize
}

impl<'a> RenderFile<'a> {
    /// The bytes of a buffer view and their stride, if it states one.
    pub(super) fn view(&self, index: usize) -> Result<(&'a [u8], Option<usize>)> {
        let bad = |problem: &str| damaged(format!("buffer view {index}"), problem);
        let view = self.list("bufferViews").get(index).ok_or_else(|| bad("it does not exist"))?;
        if number(view, "buffer", 0) != 0 {
            return Err(bad("its buffer is not the one of the file"));
        }
        let start = number(view, "byteOffset", 0);
        let end = start.checked_add(number(view, "byteLength", 0));
        let bytes = end.and_then(|end| self.bin.get(start..end)).ok_or_else(|| bad("it leaves the binary chunk"))?;
        Ok((bytes, view["byteStride"].as_u64().map(|s| s as usize)))
    }

    fn layout(&self, index: usize) -> Result<(&Value, Layout)> {
        let bad = |problem: &str| damaged(format!("accessor {index}"), problem);
        let accessor = self.list("accessors").get(index).ok_or_else(|| bad("it does not exist"))?;
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            _ => return Err(bad("it is not of scalars or vectors")),
        };
        let component = accessor["componentType"].as_u64().unwrap_or(0);
        if !matches!(component, 5120..=5123 | 5125 | 5126) {
            return Err(bad("its component type does not exist"));
        }
        let normalized = accessor["normalized"].as_bool().unwrap_or(false);
        Ok((accessor, Layout { component, normalized, width }))
    }

    /// The bytes of each element.
    fn elements(&self, view: usize, offset: usize, count: usize, layout: &Layout) -> Result<Vec<&'a [u8]>> {
        let (bytes, stride) = self.view(view)?;
        let size = layout.width * layout.component_bytes();
        let stride = stride.unwrap_or(size).max(1);
        let end = count.saturating_sub(1).saturating_mul(stride).saturating_add(offset).saturating_add(size);
        if count > 0 && end > bytes.len() {
            return Err(damaged(format!("buffer view {view}"), format!("{count} elements do not fit")));
        }
        Ok((0..count).map(|k| &bytes[offset + k * stride..offset + k * stride + size]).collect())
    }

    /// The elements of an accessor as floats, sparse ones replaced.
    pub(super) fn floats(&self, index: usize) -> Result<Floats> {
        let (accessor, layout) = self.layout(index)?;
        let (count, width) = (number(accessor, "count", 0), layout.width);
        let read = |element: &[u8]| -> Vec<f32> {
            element.chunks_exact(layout.component_bytes()).map(|c| layout.read(c)).collect()
        };
        let mut values = match accessor["bufferView"].as_u64() {
            Some(view) => {
                let elements = self.elements(view as usize, number(accessor, "byteOffset", 0), count, &layout)?;
                elements.into_iter().flat_map(read).collect()
            }
            // Zeros need no bytes in the file: more than its size are not believed.
            None if count > self.bin.len() => {
                return Err(damaged(format!("accessor {index}"), "it has more zeros than the file has bytes"));
            }
            None => vec![0.0; count * width],
        };
        let sparse = &accessor["sparse"];
        if sparse.is_object() {
            let n = number(sparse, "count", 0);
            let (places, with) = (&sparse["indices"], &sparse["values"]);
            let scalar = Layout { component: number(places, "componentType", 0) as u64, normalized: false, width: 1 };
            let offset = |v: &Value| number(v, "byteOffset", 0);
            let view = |v: &Value| number(v, "bufferView", u64::MAX);
            let places: Vec<usize> = (self.elements(view(places), offset(places), n, &scalar)?.into_iter())
                .map(|e| scalar.read(e) as usize)
                .collect();
            for (place, new) in places.into_iter().zip(self.elements(view(with), offset(with), n, &layout)?) {
                let at = values.get_mut(place.saturating_mul(width)..place.saturating_add(1).saturating_mul(width));
                let at = at.ok_or_else(|| damaged(format!("accessor {index}"), "a sparse index is out of range"))?;
                at.copy_from_slice(&read(new));
            }
        }
        Ok(Floats { width, values })
    }

    /// The elements of an accessor of vertex indices.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>> {
        let (accessor, layout) = self.layout(index)?;
        let bad = |problem: &str| damaged(format!("accessor {index}"), problem);
        if layout.width != 1 || !matches!(layout.component, 5121 | 5123 | 5125) {
            return Err(bad("vertex indices are unsigned scalars"));
        }
        if accessor["sparse"].is_object() {
            return Ok(self.floats(index)?.values.iter().map(|&x| x as u32).collect());
        }
        let view = accessor["bufferView"].as_u64().ok_or_else(|| bad("it has no buffer view"))?;
        let (offset, count) = (number(accessor, "byteOffset", 0), number(accessor, "count", 0));
        let whole = |b: &[u8]| b.iter().rev().fold(0u32, |sum, &byte| sum << 8 | u32::from(byte));
        Ok(self.elements(view as usize, offset, count, &layout)?.into_iter().map(whole).collect())
    }
}
