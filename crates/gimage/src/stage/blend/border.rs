//! The edges that cloth shares with other parts of a file.

use std::collections::HashSet;

use crate::base::mesh::Mesh;
use crate::base::vec3::{add, distance, dot, scale, sub};
use crate::error::Result;
use crate::stage::hold::sheet::Sheet;
use crate::stage::select::{Role, SelectOptions, roles};

/// The ends of an edge \[m\].
pub type Edge = [[f64; 3]; 2];

/// The bits of the ends of an edge in order; the two zeros are one.
fn key(edge: Edge) -> [[u64; 3]; 2] {
    let [a, b] = edge.map(|p| p.map(|x| (x + 0.0).to_bits()));
    if a <= b { [a, b] } else { [b, a] }
}

/// The edges of triangles that are cloth whose ends are those of an edge of a triangle that is not, bit for bit. O(n log n) in the
/// triangles.
///
/// Errors: those of [`roles`].
pub fn border(mesh: &Mesh, options: &SelectOptions) -> Result<Vec<Edge>> {
    let is_cloth: Vec<bool> = roles(mesh, options)?.iter().map(|verdict| verdict.role == Role::Cloth).collect();
    if !is_cloth.contains(&false) || !is_cloth.contains(&true) {
        return Ok(Vec::new());
    }
    let edges = |cloth: bool| {
        let is_cloth = &is_cloth;
        let of_part = move |t: &usize| {
            let part = mesh.triangle_part.get(*t).and_then(|part| is_cloth.get(*part as usize));
            part == Some(&cloth)
        };
        (0..mesh.triangles.len()).filter(of_part).flat_map(|t| {
            let [a, b, c] = mesh.corners(t);
            [[a, b], [b, c], [c, a]]
        })
    };
    let others: HashSet<[[u64; 3]; 2]> = edges(false).map(key).collect();
    let mut shared: Vec<[[u64; 3]; 2]> =
        edges(true).map(key).filter(|[a, b]| a != b).filter(|edge| others.contains(edge)).collect();
    shared.sort_unstable();
    shared.dedup();
    Ok(shared.iter().map(|edge| edge.map(|p| p.map(f64::from_bits))).collect())
}

/// The points on borders of a garment within half a texel of an edge, in ascending order.
pub(super) fn on_border(sheet: &Sheet, edges: &[Edge]) -> Vec<u32> {
    let is_near = |p: &u32| {
        let at = sheet.positions[*p as usize];
        let within = 0.5 * sheet.spacing(*p);
        edges.iter().any(|edge| to_edge(at, edge) <= within)
    };
    let mut points: Vec<u32> = sheet.borders.iter().flatten().copied().filter(is_near).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// Distance \[m\] of a point from an edge.
fn to_edge(p: [f64; 3], [a, b]: &Edge) -> f64 {
    let along = sub(*b, *a);
    let share = (dot(sub(p, *a), along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    distance(p, add(*a, scale(along, share)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Part;

    #[test]
    fn an_edge_is_shared_where_both_ends_are_equal() {
        // Two quads side by side, one of which is cloth, with vertices of their own; and a third that touches at a corner.
        let quad = |x: f64, y: f64| [[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]];
        let mesh = Mesh {
            positions: [quad(0.0, 0.0), quad(1.0, -0.0), quad(-1.0, 1.0)].concat(),
            triangles: [0, 4, 8].into_iter().flat_map(|k| [[k, k + 1, k + 2], [k, k + 2, k + 3]]).collect(),
            triangle_part: vec![0, 0, 1, 1, 1, 1],
            parts: ["skirt", "body"].map(|node| Part { node: node.into(), ..Part::default() }).to_vec(),
            ..Mesh::default()
        };
        let options = |cloth: &str| SelectOptions { cloth: vec![cloth.parse().unwrap()], ..SelectOptions::default() };
        assert_eq!(border(&mesh, &options("skirt")).unwrap(), [[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]);
        assert_eq!(border(&mesh, &options("*")).unwrap(), [] as [Edge; 0]);
        assert!(border(&mesh, &options("hat")).is_err());
    }

    #[test]
    fn distances_end_at_the_ends_of_an_edge() {
        let edge = [[0.0; 3], [2.0, 0.0, 0.0]];
        assert_eq!(to_edge([1.0, 3.0, 0.0], &edge), 3.0);
        assert_eq!(to_edge([5.0, 4.0, 0.0], &edge), 5.0);
        assert_eq!(to_edge([0.0, 1.0, 0.0], &[[0.0; 3]; 2]), 1.0);
    }
}
