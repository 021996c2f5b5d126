//! Counts and boxes.

use serde::Serialize;

use crate::base::mesh::Mesh;

/// Counts, and the axis-aligned box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Size {
    /// Triangles after repair.
    pub triangles: usize,
    /// Vertices after repair: a vertex on a UV seam counts once.
    pub vertices: usize,
    /// Area \[m2\].
    pub area: f64,
    /// Lowest x, y, z \[m\].
    pub low: [f64; 3],
    /// Highest x, y, z \[m\].
    pub high: [f64; 3],
}

impl Size {
    /// Width, height and depth \[m\].
    pub fn extent(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.high[k] - self.low[k])
    }
}

/// A size that may be that of nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounded(pub(super) Option<Size>);

impl Bounded {
    /// Of both.
    pub fn joined(self, other: Self) -> Self {
        let (Some(a), Some(b)) = (self.0, other.0) else { return Self(self.0.or(other.0)) };
        Self(Some(Size {
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
            area: a.area + b.area,
            low: std::array::from_fn(|k| a.low[k].min(b.low[k])),
            high: std::array::from_fn(|k| a.high[k].max(b.high[k])),
        }))
    }

    pub fn finish(self) -> Size {
        self.0.unwrap_or_default()
    }
}

/// The size of some triangles. O(n log n) in their number.
pub(super) fn bounded(mesh: &Mesh, triangles: &[u32]) -> Bounded {
    let mut used: Vec<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    used.sort_unstable();
    used.dedup();
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in used.iter().map(|&v| mesh.positions[v as usize]) {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let area = triangles.iter().map(|&t| mesh.triangle_area(t as usize)).sum();
    Bounded((!used.is_empty()).then_some(Size { triangles: triangles.len(), vertices: used.len(), area, low, high }))
}
