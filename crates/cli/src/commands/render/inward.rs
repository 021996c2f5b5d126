//! The way into a body, smooth over its details.
//!
//! Brows, eyelids and teeth are triangles of their own, millimetres above others, and a seam of a texture has vertices twice. Each moved along its own
//! normal would leave gaps and cross the others. So all that is near moves alike: along the mean normal of the surface around it, which is shorter where that
//! bends, and nearly zero within a finger.

use std::collections::HashMap;

use gimage::mesh::Mesh;

use super::space::{Point, cell, cells_around, face, on_triangle, squared};

/// The surface within this radius \[m\] counts.
const RADIUS: f64 = 0.03;
/// Points in a cell of that size \[m\] count as one.
const CELL: f64 = 0.012;

/// Means around points of space.
pub struct Around<const N: usize>(HashMap<[i64; 3], Sum<N>>);

/// A weighted sum of what is in a cell.
#[derive(Clone, Copy)]
struct Sum<const N: usize> {
    weight: f64,
    place: Point,
    value: [f64; N],
}

impl<const N: usize> Around<N> {
    pub fn new() -> Self {
        Around(HashMap::new())
    }

    /// Adds a value with a weight above 0.
    pub fn add(&mut self, p: &Point, weight: f64, value: [f64; N]) {
        let nothing = Sum { weight: 0.0, place: [0.0; 3], value: [0.0; N] };
        let sum = self.0.entry(cell(p, CELL)).or_insert(nothing);
        sum.weight += weight;
        (0..3).for_each(|k| sum.place[k] += weight * p[k]);
        (0..N).for_each(|k| sum.value[k] += weight * value[k]);
    }

    /// The mean around a point, in which what is near counts more; 0 where nothing is.
    pub fn mean(&self, p: &Point) -> [f64; N] {
        let (mut all, mut mean) = (0.0, [0.0; N]);
        for sum in cells_around(cell(p, CELL), (RADIUS / CELL).ceil() as i64).filter_map(|cell| self.0.get(&cell)) {
            let far2 = squared(&sum.place.map(|x| x / sum.weight), p) / (RADIUS * RADIUS);
            let share = (1.0 - far2).max(0.0).powi(2);
            all += share * sum.weight;
            (0..N).for_each(|k| mean[k] += share * sum.value[k]);
        }
        mean.map(|x| if all > 0.0 { x / all } else { 0.0 })
    }
}

/// Outward normals of at most unit length around the triangles of these parts. O(area and triangles).
pub fn normals(mesh: &Mesh, of_body: impl Fn(u32) -> bool) -> Around<3> {
    let mut around = Around::new();
    for (t, _) in mesh.triangle_part.iter().enumerate().filter(|(_, part)| of_body(**part)) {
        let corners = mesh.corners(t);
        let normal = face(corners);
        let twice = squared(&normal, &[0.0; 3]).sqrt();
        if twice <= 0.0 || !twice.is_finite() {
            continue;
        }
        let points = on_triangle(corners, CELL);
        let weight = twice / points.len() as f64;
        points.iter().for_each(|p| around.add(p, weight, normal.map(|x| x / twice)));
    }
    around
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of squares of 5 mm in the plane z = height, its first vertex of the number `first`.
    fn sheet(mesh: &mut Mesh, height: f64, n: u32) {
        let first = mesh.positions.len() as u32;
        let at = |k: u32| [0.005 * f64::from(k % n), 0.005 * f64::from(k / n), height];
        mesh.positions.extend((0..n * n).map(at));
        for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
            let k = first + j * n + i;
            mesh.triangles.extend([[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]);
        }
        mesh.triangle_part.resize(mesh.triangles.len(), 0);
    }

    #[test]
    fn what_lies_on_the_skin_moves_with_it() {
        let mut mesh = Mesh::default();
        sheet(&mut mesh, 0.0, 21);
        // A brow, of which only the upper side is there, in a corner of which the normal would be another.
        sheet(&mut mesh, 0.001, 3);
        mesh.positions[21 * 21][2] = 0.003;
        let around = normals(&mesh, |_| true);
        let on_skin = around.mean(&[0.05, 0.05, 0.0]);
        let above = around.mean(&[0.05, 0.05, 0.002]);
        assert!((on_skin[2] - 1.0).abs() < 1e-9 && squared(&on_skin, &above) < 1e-6, "{on_skin:?} {above:?}");
        let [corner, below] = [mesh.positions[21 * 21], [0.0, 0.0, 0.0]].map(|p| around.mean(&p));
        assert!(squared(&corner, &below).sqrt() < 0.02, "{corner:?} {below:?}");
    }

    #[test]
    fn a_finger_keeps_its_width() {
        let of_tube = |radius: f64| {
            let (around, rows) = (24u32, 60u32);
            let at = |k: u32| {
                let angle = std::f64::consts::TAU * f64::from(k % around) / f64::from(around);
                [radius * angle.cos(), radius * angle.sin(), 0.003 * f64::from(k / around)]
            };
            let positions: Vec<_> = (0..around * rows).map(at).collect();
            let next = |k: u32| k / around * around + (k + 1) % around;
            let triangles: Vec<_> = (0..around * (rows - 1))
                .flat_map(|k| [[k, next(k), next(k) + around], [k, next(k) + around, k + around]])
                .collect();
            let mesh = Mesh { triangle_part: vec![0; triangles.len()], positions, triangles, ..Mesh::default() };
            normals(&mesh, |_| true).mean(&[radius, 0.0, 0.09])[0]
        };
        assert!(of_tube(0.006) < 0.25, "{}", of_tube(0.006));
        assert!(of_tube(0.06) > 0.9, "{}", of_tube(0.06));
    }
}
