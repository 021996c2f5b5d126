//! A disk's boundary laid on the border of a rectangle, and the texels on it.

use std::collections::{HashMap, HashSet};

use super::Border;
use crate::base::surface::Surface;
use crate::base::vec3::lerp;
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::layout::Layout;

/// Which surface point a border texel is: texels with equal keys are duplicates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Key {
    /// A vertex of the surface.
    Node(u32),
    /// Step `.1` of the path `.0`.
    Inner(u32, u32),
    /// Some point of the boundary of a disk that needed no cut.
    Free(u32),
}

/// One texel on the border of the image.
#[derive(Clone, Copy, Debug)]
pub struct BorderTexel {
    /// Identity of the texel's surface point.
    pub key: Key,
    /// Where it is \[m\]; bit-identical for equal keys.
    pub position: [f64; 3],
    /// The disk triangle it lies on the edge of.
    pub triangle: u32,
    /// Barycentric coordinates in that triangle.
    pub bary: [f64; 3],
    /// A vertex of the surface's boundary loop that it lies on, if it lies on one.
    pub rim: Option<u32>,
}

/// A disk whose boundary has been laid on the border of a `w` x `h` cell rectangle.
pub(crate) struct Placed {
    /// The disk, with a vertex on each corner and no inner edge between boundary vertices.
    pub disk: Disk,
    /// Places of the boundary vertices, in cells; zero elsewhere.
    pub uv: Vec<[f64; 2]>,
    /// The border texels counter-clockwise from (0, 0).
    pub texels: Vec<BorderTexel>,
}

/// Where step `p` of the perimeter of a `w` x `h` rectangle is, counter-clockwise from (0, 0).
pub(crate) fn on_rectangle(p: f64, w: u32, h: u32) -> [f64; 2] {
    let (w, h) = (f64::from(w), f64::from(h));
    let p = p.rem_euclid(2.0 * (w + h));
    if p <= w {
        [p, 0.0]
    } else if p <= w + h {
        [w, p - w]
    } else if p <= 2.0 * w + h {
        [2.0 * w + h - p, h]
    } else {
        [0.0, 2.0 * (w + h) - p]
    }
}

impl Border {
    /// Lays the boundary on the rectangle of a layout.
    pub(crate) fn place(
        &self,
        disk: &Disk,
        surface: &Surface,
        surface_boundary: &dyn Fn(u32) -> bool,
        layout: &Layout,
    ) -> Option<Placed> {
        let Layout { w, h, shift, ref count, .. } = *layout;
        let perimeter = f64::from(2 * (w + h));
        let mut along = self.along(disk, count);
        let mut disk = disk.clone();
        let mut splits = Vec::new();
        let mut extra = Vec::new();
        for corner in [0, w, w + h, 2 * w + h] {
            let at = (f64::from(corner) - shift).rem_euclid(perimeter);
            let i = along.partition_point(|&x| x <= at).saturating_sub(1);
            let next = along.get(i + 1).copied().unwrap_or(perimeter);
            if at - along[i] < 1e-6 {
                along[i] = at;
            } else if next - at < 1e-6 && i + 1 < along.len() {
                along[i + 1] = at;
            } else {
                splits.push((i, (at - along[i]) / (next - along[i])));
                extra.push(at);
            }
        }
        // Node places are whole numbers: a corner within rounding of one is that one.
        disk.split_boundary(&splits);
        along.extend(extra);
        along.sort_by(f64::total_cmp);
        disk.split_chords();
        let mut uv = vec![[0.0; 2]; disk.positions.len()];
        for (v, a) in disk.boundary.iter().zip(&along) {
            uv[*v as usize] = on_rectangle(a + shift, w, h);
        }
        let texels = self.texels(&disk, surface, surface_boundary, &along, layout)?;
        Some(Placed { disk, uv, texels })
    }

    fn texels(
        &self,
        disk: &Disk,
        surface: &Surface,
        surface_boundary: &dyn Fn(u32) -> bool,
        along: &[f64],
        layout: &Layout,
    ) -> Option<Vec<BorderTexel>> {
        let Layout { w, h, shift, ref count, .. } = *layout;
        let perimeter = f64::from(2 * (w + h));
        let mut face_of: HashMap<[u32; 2], (u32, usize)> = HashMap::new();
        let n = disk.boundary.len();
        let wanted: HashSet<[u32; 2]> = (0..n).map(|i| [disk.boundary[i], disk.boundary[(i + 1) % n]]).collect();
        for (f, t) in disk.triangles.iter().enumerate() {
            for k in 0..3 {
                let e = [t[k], t[(k + 1) % 3]];
                if wanted.contains(&e) {
                    face_of.insert(e, (f as u32, k));
                }
            }
        }
        let steps = perimeter as u32;
        let mut keys = Vec::with_capacity(steps as usize);
        if self.free {
            keys.extend((0..steps).map(|p| (Key::Free(p), (f64::from(p) - shift).rem_euclid(perimeter))));
        } else {
            let mut base = 0u32;
            for s in &self.segments {
                let n = count[s.group];
                for k in 0..n {
                    let key = if k == 0 {
                        // Splits only append: the loop still has the node at its whole step.
                        let i = along.partition_point(|&x| x < f64::from(base) - 1e-9);
                        Key::Node(disk.origin[disk.boundary[i] as usize])
                    } else {
                        Key::Inner(s.group as u32, if s.reversed { n - k } else { k })
                    };
                    keys.push((key, f64::from(base + k)));
                }
                base += n;
            }
        }
        let mut texels = Vec::with_capacity(keys.len());
        let mut known: HashMap<Key, [f64; 3]> = HashMap::new();
        for (key, at) in keys {
            let mut i = along.partition_point(|&x| x <= at + 1e-9).saturating_sub(1);
            let next = along.get(i + 1).copied().unwrap_or(perimeter);
            let mut t = if next > along[i] { ((at - along[i]) / (next - along[i])).clamp(0.0, 1.0) } else { 0.0 };
            if t > 1.0 - 1e-12 {
                (i, t) = ((i + 1) % n, 0.0);
            }
            let (a, b) = (disk.boundary[i], disk.boundary[(i + 1) % n]);
            let &(triangle, corner) = face_of.get(&[a, b])?;
            let mut bary = [0.0; 3];
            bary[corner] = 1.0 - t;
            bary[(corner + 1) % 3] = t;
            let here = lerp(disk.positions[a as usize], disk.positions[b as usize], t);
            let position = match key {
                Key::Node(v) if v != NONE => surface.positions[v as usize],
                _ => *known.entry(key).or_insert(here),
            };
            let rim = match key {
                Key::Node(v) => surface_boundary(v).then_some(v),
                Key::Inner(g, _) => self.groups[g as usize].rim,
                Key::Free(_) => self.groups[0].rim,
            };
            texels.push(BorderTexel { key, position, triangle, bary, rim });
        }
        if !self.free {
            // Texel p of the image is step p - shift of the loop.
            texels.rotate_right(shift as usize % steps as usize);
        }
        Some(texels)
    }
}
