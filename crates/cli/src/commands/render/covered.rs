//! Parts of a body that clothes cover: near the borders of clothes they are drawn deeper within the body, and elsewhere not at all, so that
//! skin does not show where it bulges through cloth.
//!
//! Cloth rests on the colliders of the body, which are rigid, while the skin between two of them bulges as a joint bends: at the shoulders by
//! more than a centimetre.

use std::collections::HashMap;
use std::f64::consts::TAU;

use gimage::closest::Closest;
use gimage::mesh::Mesh;
use rayon::prelude::*;

use super::space::{Cells, Point, on_edge, on_triangle, squared, unit};
use crate::commands::character::cross;

/// How far \[m\] within its surface a body is drawn at least: cloth lies on colliders, which are that near to it at best.
const INSET: f64 = 0.004;
/// The same below clothes, at most.
pub const DEEP: f64 = 0.025;
/// How near \[m\] a garment covers, and how far from its borders it hides the body.
const NEAR: f64 = 0.05;
const BORDER: f64 = 0.06;
/// Points of a garment are that far apart \[m\] at most.
const SPACING: f64 = 0.015;
/// Directions in which a point of the body looks out, how far \[m\], and the share of them without cloth from which it is as if nothing were above it: a face in a
/// hood.
const RAYS: usize = 64;
const SIGHT: f64 = 10.0;
const OPEN: f64 = 0.25;

/// How far \[m\] within the surface each vertex of a mesh is drawn; infinite where cloth hides it from all sides. `normals` are those of the body around its
/// vertices, none longer than 1; `None` for vertices of cloth. O(vertices and points of cloth).
pub fn depths(mesh: &Mesh, is_cloth: impl Fn(u32) -> bool, normals: &[Option<Point>]) -> Vec<f64> {
    let worn: Vec<[u32; 3]> =
        mesh.triangles.iter().zip(&mesh.triangle_part).filter(|(_, part)| is_cloth(**part)).map(|(t, _)| *t).collect();
    let at = |v: u32| mesh.positions[v as usize];
    // Vertices of one position are one: a seam of a texture is not a border.
    let mut first: HashMap<[u64; 3], u32> = HashMap::new();
    let mut weld = |v: u32| *first.entry(at(v).map(f64::to_bits)).or_insert(v);
    let mut points = Cells::new(NEAR);
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    for t in &worn {
        on_triangle(t.map(at), SPACING).into_iter().for_each(|p| points.add(p));
        for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (p, q) = (weld(p), weld(q));
            *sides.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
    }
    let mut borders = Cells::new(BORDER);
    for ([p, q], _) in sides.iter().filter(|(_, count)| **count == 1) {
        on_edge(at(*p), at(*q), SPACING).for_each(|p| borders.add(p));
    }
    let cloth = Closest::new(&mesh.positions, &worn);
    let depth = |(p, normal): (&Point, &Option<Point>)| {
        let Some(normal) = normal.and_then(unit) else { return INSET };
        // The distance of cloth, and how much of it is along the normal.
        let seen = |q: &Point| {
            let along = (0..3).map(|k| (q[k] - p[k]) * normal[k]).sum::<f64>();
            (squared(q, p).sqrt(), along)
        };
        // Cloth above the skin, or, within twice the inset, anywhere.
        let above = |q: &Point| matches!(seen(q), (far, along) if far < 2.0 * INSET || along > 0.5 * far);
        if points.nearest(p, above).is_none() {
            return INSET;
        }
        let below = |q: &Point| matches!(seen(q), (far, along) if far < 2.0 * INSET && along <= 0.0);
        let start = if points.nearest(p, below).is_some() { 2.0 * INSET } else { 0.0 };
        // A closed shell, such as a jacket with a lining, has no border: through its openings the body looks out.
        let far = borders.nearest(p, |_| true).map_or(1.0, |d| d / BORDER);
        let open = open(&cloth, [0, 1, 2].map(|k| p[k] - start * normal[k]), &normal);
        if far >= 1.0 && open == 0.0 {
            return f64::INFINITY;
        }
        let cover = far.min(1.0 - open / OPEN).clamp(0.0, 1.0);
        INSET + (DEEP - INSET) * cover * cover * (3.0 - 2.0 * cover)
    };
    mesh.positions.par_iter().zip(normals).map(depth).collect()
}

/// The share of what a point of the body sees that is not cloth: directions are the denser, the nearer they are to the normal.
fn open(cloth: &Closest, from: Point, normal: &Point) -> f64 {
    let least = (0..3).min_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(0);
    let mut side = [0.0; 3];
    side[least] = 1.0;
    let Some(u) = unit(cross(*normal, side)) else { return 1.0 };
    let v = cross(*normal, u);
    let is_free = |n: &usize| {
        let share = (*n as f64 + 0.5) / RAYS as f64;
        // The golden angle spreads them.
        let (out, turn) = (share.sqrt(), *n as f64 * TAU * 0.381_966);
        let (x, y, z) = (out * turn.cos(), out * turn.sin(), (1.0 - share).sqrt());
        let way = [0, 1, 2].map(|k| x * u[k] + y * v[k] + z * normal[k]);
        cloth.along(from, way, SIGHT, |_, _| true).is_none()
    };
    (0..RAYS).filter(is_free).count() as f64 / RAYS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds a box without some of its six sides (-x, +x, -y, +y, -z, +z), each of `n` x `n` squares with vertices of its own.
    fn add_box(mesh: &mut Mesh, part: u32, half: Point, n: u32, without: &[usize]) {
        for side in (0..6).filter(|side| !without.contains(side)) {
            let (axis, sign) = (side / 2, if side % 2 == 1 { 1.0 } else { -1.0 });
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = mesh.positions.len() as u32;
            for k in 0..(n + 1) * (n + 1) {
                let share = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
                let mut p = [0.0; 3];
                (p[axis], p[u], p[v]) = (sign * half[axis], share(k % (n + 1)) * half[u], share(k / (n + 1)) * half[v]);
                mesh.positions.push(p);
            }
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let k = first + j * (n + 1) + i;
                let (right, down) = (k + 1, k + n + 1);
                let both = [[k, right, down + 1], [k, down + 1, down]];
                mesh.triangles.extend(both.map(|[a, b, c]| if sign > 0.0 { [a, b, c] } else { [a, c, b] }));
            }
        }
        mesh.triangle_part.resize(mesh.triangles.len(), part);
    }

    /// Depths of a head, a box of 16 cm, in a garment of two sheets 1 cm thick, without these sides.
    fn in_shell(without: &[usize]) -> (Mesh, Vec<f64>) {
        let mut mesh = Mesh::default();
        add_box(&mut mesh, 0, [0.08; 3], 8, &[]);
        let body = mesh.positions.len();
        add_box(&mut mesh, 1, [0.10; 3], 8, without);
        add_box(&mut mesh, 1, [0.11; 3], 8, without);
        let normals: Vec<_> = mesh.positions.iter().map(|p| unit(*p)).collect();
        let mut depths = depths(&mesh, |part| part == 1, &normals);
        depths.truncate(body);
        (mesh, depths)
    }

    #[test]
    fn a_face_that_looks_out_of_a_hood_is_drawn_where_it_is() {
        let (mesh, depths) = in_shell(&[5]);
        for (p, depth) in mesh.positions.iter().zip(&depths) {
            // The face, but for its rim, and the back of the head.
            let is_front = p[2] >= 0.08 && p[0].abs() < 0.07 && p[1].abs() < 0.07;
            let is_back = p[2] <= -0.08 && p[0].abs() < 0.05 && p[1].abs() < 0.05;
            assert!(!is_front || *depth < 0.006, "{p:?}: {depth}");
            assert!(!is_back || depth.is_infinite(), "{p:?}: {depth}");
        }
    }

    #[test]
    fn what_nothing_opens_is_hidden_and_what_nothing_covers_is_not() {
        assert!(in_shell(&[]).1.iter().all(|depth| depth.is_infinite()));
        assert!(in_shell(&[0, 1, 2, 3, 4, 5]).1.iter().all(|depth| *depth == INSET));
    }
}
