//! The change of units that keeps tiny, huge and far-away meshes accurate: centre to the origin, longest side to 1.

/// Centre and size of a box of points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) centre: [f64; 3],
    pub(crate) size: f64,
}

/// Coordinates beyond this overflow when squared.
const LARGEST: f64 = 1e150;

/// Whether arithmetic on a point stays finite.
pub(crate) fn is_usable(p: [f64; 3]) -> bool {
    p.iter().all(|x| x.abs() <= LARGEST)
}

impl Frame {
    /// The frame of the usable ones among some points.
    pub(crate) fn around(points: impl Iterator<Item = [f64; 3]>) -> Self {
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points.filter(|&p| is_usable(p)) {
            for k in 0..3 {
                lo[k] = lo[k].min(p[k]);
                hi[k] = hi[k].max(p[k]);
            }
        }
        if lo[0] > hi[0] {
            return Self { centre: [0.0; 3], size: 1.0 };
        }
        let size = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f64::max);
        let size = if (1.0 / size).is_finite() { size } else { 1.0 };
        Self { centre: [0, 1, 2].map(|k| 0.5 * (lo[k] + hi[k])), size }
    }

    /// A point in the frame's units.
    pub(crate) fn inward(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (p[k] - self.centre[k]) / self.size)
    }

    /// A point of the frame in metres.
    pub(crate) fn outward(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| p[k] * self.size + self.centre[k])
    }
}

/// The corners of the triangles that can be computed with, in units of `frame`, with their indices.
pub(crate) fn usable_corners(
    frame: &Frame,
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> (Vec<[[f64; 3]; 3]>, Vec<u32>) {
    let at = |v: u32| positions.get(v as usize).copied();
    usable_of(frame, triangles.iter().map(|t| t.map(at)))
}

/// As [`usable_corners`], for triangles given by the positions of their corners; `None` for a vertex that does not exist.
pub(crate) fn usable_of(
    frame: &Frame,
    triangles: impl ExactSizeIterator<Item = [Option<[f64; 3]>; 3]>,
) -> (Vec<[[f64; 3]; 3]>, Vec<u32>) {
    let usable = |p: Option<[f64; 3]>| p.filter(|&p| is_usable(p)).map(|p| frame.inward(p));
    let mut corners = Vec::with_capacity(triangles.len());
    let mut ids = Vec::with_capacity(triangles.len());
    for (id, triangle) in triangles.enumerate() {
        if let [Some(a), Some(b), Some(c)] = triangle.map(usable) {
            corners.push([a, b, c]);
            ids.push(id as u32);
        }
    }
    (corners, ids)
}

/// The positions of the vertices that triangles use.
pub(crate) fn used_positions<'a>(
    positions: &'a [[f64; 3]],
    triangles: &'a [[u32; 3]],
) -> impl Iterator<Item = [f64; 3]> + 'a {
    triangles.iter().flatten().filter_map(|&v| positions.get(v as usize).copied())
}
