//! Moves a sheet of a shell halfway towards the other one.

use crate::base::closest::Closest;
use crate::base::halfedge::sorted_edges;
use crate::base::vec3::{add, cross, dot, norm, normalize, scale, sub};

/// Largest distance over the median; beyond it, the other sheet has a hole.
const FARTHEST: f64 = 3.0;
/// Cosine between the way to the other sheet and the normal, below which that way leads past a border.
const STEEP: f64 = 0.6;
/// Rounds of smoothing that fill places without an opposite sheet.
const ROUNDS: usize = 200;

/// The places of the vertices of a sheet halfway to the `facing` triangles. `triangles` index `positions` and are wound so that
/// their normals point out of the fabric. Returns (vertex, place) in the order of the vertices.
///
/// A vertex goes half the way to the nearest point of the other sheet, so that neighbours keep at least half of their distance. Where
/// there is none across, the distance is that of the surroundings, along the normal. O(n log n).
pub(super) fn middle(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    facing: &[[[f64; 3]; 3]],
    thickness: f64,
) -> Vec<(u32, [f64; 3])> {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let local = |v: u32| vertices.partition_point(|&x| x < v);
    let corners: Vec<[usize; 3]> = triangles.iter().map(|t| t.map(local)).collect();
    let points: Vec<[f64; 3]> = vertices.iter().map(|&v| positions[v as usize]).collect();
    let normals: Vec<[f64; 3]> = normals(&points, &corners);
    let nearest = Closest::of(facing).project_all(&points);
    let way = |k: usize| {
        let way = sub(nearest[k]?.point, points[k]);
        let length = norm(way);
        let across = -dot(way, normals[k]);
        // Sheets that cross are the wrong way round by a little.
        let is_across = across > STEEP * length || length < 0.25 * thickness;
        (is_across && length < FARTHEST * thickness).then_some(way)
    };
    let ways: Vec<Option<[f64; 3]>> = (0..points.len()).map(way).collect();
    let depths = filled(&ways, &corners, thickness);
    let place = |k: usize| {
        let way = ways[k].unwrap_or_else(|| scale(normals[k], -depths[k]));
        add(points[k], scale(way, 0.5))
    };
    vertices.iter().enumerate().map(|(k, &v)| (v, place(k))).collect()
}

/// Unit normals at the vertices, weighted by the angles of the triangles.
fn normals(points: &[[f64; 3]], corners: &[[usize; 3]]) -> Vec<[f64; 3]> {
    let mut out = vec![[0.0; 3]; points.len()];
    for t in corners {
        let [a, b, c] = t.map(|v| points[v]);
        let normal = normalize(cross(sub(b, a), sub(c, a)));
        for k in 0..3 {
            let at = points[t[k]];
            let (x, y) = (normalize(sub(points[t[(k + 1) % 3]], at)), normalize(sub(points[t[(k + 2) % 3]], at)));
            out[t[k]] = add(out[t[k]], scale(normal, dot(x, y).clamp(-1.0, 1.0).acos()));
        }
    }
    out.into_iter().map(normalize).collect()
}

/// The distance to the other sheet at every vertex: where there is none, the mean of the neighbours.
fn filled(ways: &[Option<[f64; 3]>], corners: &[[usize; 3]], thickness: f64) -> Vec<f64> {
    let mut depths: Vec<f64> = ways.iter().map(|w| w.map_or(thickness, norm)).collect();
    let triangles: Vec<[u32; 3]> = corners.iter().map(|t| t.map(|v| v as u32)).collect();
    let mut edges: Vec<[usize; 2]> = sorted_edges(&triangles).iter().map(|e| [e.0 as usize, e.1 as usize]).collect();
    edges.dedup();
    edges.retain(|&[a, b]| ways[a].is_none() || ways[b].is_none());
    if edges.is_empty() {
        return depths;
    }
    for _ in 0..ROUNDS {
        let (mut sums, mut counts) = (vec![0.0; depths.len()], vec![0u32; depths.len()]);
        for &[a, b] in &edges {
            (sums[a], counts[a]) = (sums[a] + depths[b], counts[a] + 1);
            (sums[b], counts[b]) = (sums[b] + depths[a], counts[b] + 1);
        }
        for k in (0..depths.len()).filter(|&k| ways[k].is_none() && counts[k] > 0) {
            depths[k] = sums[k] / f64::from(counts[k]);
        }
    }
    depths
}
