//! Accessors: typed arrays in buffer views, every range checked before a byte is read or reserved.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;

use super::buffers::Buffers;
use super::document::Document;
use crate::error::{Error, Result};

/// An attribute: `width` floats an element.
pub(crate) struct Floats {
    pub width: usize,
    pub values: Vec<f32>,
}

/// How the elements of an accessor lie.
#[derive(Clone, Copy)]
struct Layout {
    component: ComponentType,
    normalized: bool,
    rows: usize,
    columns: usize,
    /// Bytes from one column of a matrix to the next; columns start on whole words.
    column_bytes: usize,
}

impl Layout {
    fn width(&self) -> usize {
        self.rows * self.columns
    }

    fn size(&self) -> usize {
        self.column_bytes * (self.columns - 1) + self.rows * self.component.size()
    }
}

/// The accessors of a document.
pub(crate) struct Accessors<'a> {
    pub doc: &'a Document<'a>,
    pub buffers: &'a Buffers<'a>,
    /// Most elements an accessor may have.
    pub max_count: usize,
}

impl Accessors<'_> {
    fn get(&self, index: usize) -> Result<(&Accessor, Layout)> {
        let element = || format!("accessor {index}");
        let Some(accessor) = self.doc.root.accessors.get(index) else {
            return Err(self.doc.bad(element(), "there is no such accessor"));
        };
        let (Checked::Valid(kind), Checked::Valid(component)) = (accessor.type_, accessor.component_type) else {
            return Err(self.doc.bad(element(), "glTF does not define its type or component type"));
        };
        let (rows, columns) = match kind {
            Type::Scalar => (1, 1),
            Type::Vec2 => (2, 1),
            Type::Vec3 => (3, 1),
            Type::Vec4 => (4, 1),
            Type::Mat2 => (2, 2),
            Type::Mat3 => (3, 3),
            Type::Mat4 => (4, 4),
        };
        let component = component.0;
        let column_bytes = if columns > 1 { (rows * component.size()).next_multiple_of(4) } else { 0 };
        if accessor.count.0 > self.max_count as u64 {
            return Err(Error::TooLarge {
                what: format!("{}: {}", self.doc.path.display(), element()),
                need: format!("{} elements", accessor.count.0),
                limit: format!("{} elements", self.max_count),
                hint: "the count is damaged, or the limits of the import must be raised".into(),
            });
        }
        Ok((accessor, Layout { component, normalized: accessor.normalized, rows, columns, column_bytes }))
    }

    /// Divisor of the accessor's integers, if they are normalised; 0 if not.
    pub fn normalizer(&self, index: usize) -> Result<f32> {
        let (_, layout) = self.get(index)?;
        Ok(if layout.normalized { largest(layout.component) } else { 0.0 })
    }

    /// The distance of two numbers of an accessor of integers; none of floats.
    pub fn integer_step(&self, index: usize) -> Result<Option<f64>> {
        let (_, layout) = self.get(index)?;
        let step = if layout.normalized { 1.0 / f64::from(largest(layout.component)) } else { 1.0 };
        Ok((layout.component != ComponentType::F32).then_some(step))
    }

    /// Elements as floats; normalised integers go to -1..1 or 0..1.
    pub fn floats(&self, index: usize) -> Result<Floats> {
        let (accessor, layout) = self.get(index)?;
        let (count, width) = (accessor.count.0 as usize, layout.width());
        let mut values = match accessor.buffer_view {
            None => {
                self.buffers.spend(4 * (count * width) as u64, &format!("accessor {index}"))?;
                vec![0.0; count * width]
            }
            Some(view) => {
                let mut values = Vec::with_capacity(0);
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                self.read(index, view.value(), offset, count, layout, &mut values)?;
                values
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let bad = |problem: String| self.doc.bad(format!("accessor {index}, sparse"), problem);
            let Checked::Valid(component) = sparse.indices.component_type else {
                return Err(bad("its indices have no unsigned type".into()));
            };
            let n = sparse.count.0;
            if n > count as u64 {
                return Err(bad(format!("it replaces {n} of {count} elements")));
            }
            let scalar = Layout { component: component.0, normalized: false, rows: 1, columns: 1, column_bytes: 0 };
            let places =
                self.indices(index, sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, n, scalar)?;
            let mut with = Vec::new();
            let view = sparse.values.buffer_view.value();
            self.read(index, view, sparse.values.byte_offset.0, n as usize, layout, &mut with)?;
            for (place, new) in places.iter().zip(with.chunks_exact(width)) {
                let at = *place as usize * width;
                let Some(old) = values.get_mut(at..at + width) else {
                    return Err(bad(format!("it replaces element {place} of {count}")));
                };
                old.copy_from_slice(new);
            }
        }
        Ok(Floats { width, values })
    }

    /// Elements as vertex indices.
    pub fn vertex_indices(&self, index: usize) -> Result<Vec<u32>> {
        let (accessor, layout) = self.get(index)?;
        let bad = |problem: &str| self.doc.bad(format!("accessor {index}"), problem);
        if layout.width() != 1 {
            return Err(bad("vertex indices must be scalars"));
        }
        if accessor.sparse.is_some() {
            // Rare enough to go through floats, which are exact for this number of vertices.
            let floats = self.floats(index)?;
            let exact = |v: &f32| (0.0..16_777_216.0).contains(v) && v.fract() == 0.0;
            if !floats.values.iter().all(exact) {
                return Err(bad("its sparse vertex indices are too large"));
            }
            return Ok(floats.values.iter().map(|&v| v as u32).collect());
        }
        let view = accessor.buffer_view.ok_or_else(|| bad("vertex indices must have a buffer view"))?;
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        self.indices(index, view.value(), offset, accessor.count.0, layout)
    }

    fn indices(&self, index: usize, view: usize, offset: u64, count: u64, layout: Layout) -> Result<Vec<u32>> {
        let (bytes, stride) = self.span(index, view, offset, count, layout)?;
        self.buffers.pass(4 * count)?;
        let elements = bytes.chunks(stride);
        Ok(match layout.component {
            ComponentType::U8 => elements.map(|b| b[0].into()).collect(),
            ComponentType::U16 => elements.map(|b| u16::from_le_bytes([b[0], b[1]]).into()).collect(),
            ComponentType::U32 => elements.map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
            _ => return Err(self.doc.bad(format!("accessor {index}"), "indices must be unsigned integers")),
        })
    }

    /// The bytes from the first to the last element, and the stride.
    fn span(&self, index: usize, view: usize, offset: u64, count: u64, layout: Layout) -> Result<(&[u8], usize)> {
        let view_index = view;
        let view = self.buffers.view(view)?;
        let size = layout.size();
        let stride = view.stride.filter(|&s| s != 0).unwrap_or(size);
        if stride < size {
            let problem = format!("its elements have {size} bytes, and its view has one every {stride}");
            return Err(self.doc.bad(format!("accessor {index}"), problem));
        }
        if count == 0 {
            return Ok((&[], stride));
        }
        let end = (stride as u64).checked_mul(count - 1).and_then(|n| n.checked_add(size as u64)?.checked_add(offset));
        match end.filter(|&end| end <= view.bytes.len() as u64) {
            Some(end) => Ok((&view.bytes[offset as usize..end as usize], stride)),
            None => {
                let problem = format!(
                    "its {count} elements of {size} bytes do not fit in buffer view {view_index} of {} bytes",
                    view.bytes.len()
                );
                Err(self.doc.bad(format!("accessor {index}"), problem))
            }
        }
    }

    fn read(
        &self,
        index: usize,
        view: usize,
        offset: u64,
        count: usize,
        layout: Layout,
        out: &mut Vec<f32>,
    ) -> Result<()> {
        let (bytes, stride) = self.span(index, view, offset, count as u64, layout)?;
        self.buffers.pass(4 * (count * layout.width()) as u64)?;
        out.reserve_exact(count * layout.width());
        let top = largest(layout.component);
        macro_rules! read {
            ($type:ty, $to:expr) => {
                for element in bytes.chunks(stride) {
                    for column in 0..layout.columns {
                        let start = column * layout.column_bytes;
                        let column = &element[start..start + layout.rows * size_of::<$type>()];
                        for c in column.as_chunks::<{ size_of::<$type>() }>().0 {
                            out.push($to(<$type>::from_le_bytes(*c)));
                        }
                    }
                }
            };
        }
        match (layout.component, layout.normalized) {
            (ComponentType::F32, _) => read!(f32, |v| v),
            (ComponentType::I8, false) => read!(i8, f32::from),
            (ComponentType::U8, false) => read!(u8, f32::from),
            (ComponentType::I16, false) => read!(i16, f32::from),
            (ComponentType::U16, false) => read!(u16, f32::from),
            (ComponentType::U32, false) => read!(u32, |v| v as f32),
            (ComponentType::I8, true) => read!(i8, |v| (f32::from(v) / top).max(-1.0)),
            (ComponentType::U8, true) => read!(u8, |v| f32::from(v) / top),
            (ComponentType::I16, true) => read!(i16, |v| (f32::from(v) / top).max(-1.0)),
            (ComponentType::U16, true) => read!(u16, |v| f32::from(v) / top),
            (ComponentType::U32, true) => read!(u32, |v| v as f32 / top),
        }
        Ok(())
    }
}

/// The largest integer of a type, which stands for 1.
fn largest(component: ComponentType) -> f32 {
    match component {
        ComponentType::I8 => i8::MAX.into(),
        ComponentType::U8 => u8::MAX.into(),
        ComponentType::I16 => i16::MAX.into(),
        ComponentType::U16 => u16::MAX.into(),
        ComponentType::U32 => u32::MAX as f32,
        ComponentType::F32 => 1.0,
    }
}
