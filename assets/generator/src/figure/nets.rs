//! A closed mesh of a body, by surface nets: one vertex per cell that the surface passes, one quad per edge.

use std::collections::BTreeMap;

use crate::body::Body;
use crate::math::{V3, add, norm, scale, sub};

/// Vertices on the surface, and counter-clockwise triangles.
pub struct Mesh {
    /// Positions \[m\].
    pub points: Vec<V3>,
    /// Indices of three vertices.
    pub triangles: Vec<[usize; 3]>,
}

/// Rounds in which vertices slide towards the mean of their neighbours and return to the surface.
const ROUNDS: usize = 4;

/// Meshes the body in a box with cells of side `h` \[m\].
pub fn mesh(body: &Body, low: V3, high: V3, h: f64) -> Mesh {
    let count = [0, 1, 2].map(|c| ((high[c] - low[c]) / h).round() as usize + 1);
    let at = |i: [usize; 3]| [0, 1, 2].map(|c| low[c] + h * i[c] as f64);
    let index = |i: [usize; 3]| (i[2] * count[1] + i[1]) * count[0] + i[0];
    let mut inside = vec![false; count[0] * count[1] * count[2]];
    let all =
        || (0..count[2]).flat_map(move |z| (0..count[1]).flat_map(move |y| (0..count[0]).map(move |x| [x, y, z])));
    all().for_each(|i| inside[index(i)] = body.distance(at(i)) < 0.0);
    let (mut cells, mut points) = (BTreeMap::new(), Vec::new());
    let mut quads = Vec::new();
    for i in all() {
        for axis in 0..3 {
            let mut j = i;
            j[axis] += 1;
            if j[axis] >= count[axis] || inside[index(i)] == inside[index(j)] {
                continue;
            }
            // The four cells around the edge, seen against the axis: counter-clockwise.
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(du, dv)| {
                let mut cell = i;
                (cell[u], cell[v]) = (cell[u] - du, cell[v] - dv);
                *cells.entry(index(cell)).or_insert_with(|| {
                    points.push(add(at(cell), [h / 2.0; 3]));
                    points.len() - 1
                })
            });
            if !inside[index(i)] {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    settle(body, &mut points, &quads);
    let triangles = quads.iter().flat_map(|q| halves(&points, q)).collect();
    Mesh { points, triangles }
}

/// Puts vertices on the surface, evenly.
fn settle(body: &Body, points: &mut [V3], quads: &[[usize; 4]]) {
    for round in 0..=ROUNDS {
        if round > 0 {
            let mut sums = vec![([0.0; 3], 0.0); points.len()];
            for quad in quads {
                for k in 0..4 {
                    let (a, b) = (quad[k], quad[(k + 1) % 4]);
                    // Each edge belongs to two quads, in both directions.
                    sums[a] = (add(sums[a].0, points[b]), sums[a].1 + 1.0);
                }
            }
            points.iter_mut().zip(&sums).for_each(|(p, (sum, n))| *p = add(scale(*p, 0.4), scale(*sum, 0.6 / n)));
        }
        for p in points.iter_mut() {
            *p = on_surface(body, *p);
        }
    }
}

/// The point of the surface that is reached against the direction outwards.
pub fn on_surface(body: &Body, mut p: V3) -> V3 {
    for _ in 0..6 {
        // The distance is approximate where parts blend: shorter steps there.
        p = sub(p, scale(body.outward(p), 0.9 * body.distance(p)));
    }
    p
}

/// A quad as two triangles, along the shorter diagonal.
fn halves(points: &[V3], &[a, b, c, d]: &[usize; 4]) -> [[usize; 3]; 2] {
    let length = |i: usize, j: usize| norm(sub(points[i], points[j]));
    if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] }
}

/// Unit normals, from the body.
pub fn normals(body: &Body, mesh: &Mesh) -> Vec<V3> {
    mesh.points.iter().map(|p| body.outward(*p)).collect()
}
