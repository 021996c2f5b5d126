//! Closes a garment where strands were.

use super::Strand;
use crate::base::halfedge::{origin, sorted_edges};
use crate::base::mesh::Mesh;
use crate::base::vec3::{cross, distance, norm, sub};

/// Least quality of the triangles that close a root: twice the area over the square of the longest side. A flatter ring stays open.
const LEAST: f64 = 1e-3;

/// Adds a fan of triangles for each root, with the attributes of the garment there. `keep` tells which triangles are not of strands.
pub(super) fn close(mesh: &mut Mesh, keep: &[bool], strands: &[Strand]) {
    let edges = sorted_edges(&mesh.triangles);
    let is_kept = |a: u32, b: u32| {
        let first = edges.partition_point(|e| (e.0, e.1) < (a.min(b), a.max(b)));
        let same = edges[first..].iter().take_while(|e| (e.0, e.1) == (a.min(b), a.max(b)));
        same.into_iter().any(|e| keep[e.2 as usize / 3])
    };
    for Strand { ring, .. } in strands {
        let count = ring.len();
        let vertices: Vec<u32> = ring.iter().map(|h| origin(&mesh.triangles, *h)).collect();
        let fan = |first: usize| (1..count - 1).map(move |k| [first, (first + k + 1) % count, (first + k) % count]);
        // An edge has two triangles at most.
        let is_free = |first: &usize| (2..count - 1).all(|k| !is_kept(vertices[*first], vertices[(first + k) % count]));
        let quality = |first: usize| {
            let of = |t: [usize; 3]| shape(t.map(|k| mesh.positions[vertices[k] as usize]));
            fan(first).map(of).fold(f64::INFINITY, f64::min)
        };
        let best = (0..count).filter(is_free).map(|first| (quality(first), first));
        let best = best.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, first)) = best.filter(|(quality, _)| *quality >= LEAST) else { continue };
        for t in fan(first) {
            mesh.triangles.push(t.map(|k| vertices[k]));
            mesh.triangle_part.push(mesh.triangle_part[ring[t[2]] as usize / 3]);
            for channel in &mut mesh.channels {
                let corners = t.map(|k| channel.corners[ring[k] as usize]);
                channel.corners.extend(corners);
            }
        }
    }
}

/// Twice the area of a triangle over the square of its longest side; 0 without area.
fn shape([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    if longest > 0.0 { norm(cross(sub(b, a), sub(c, a))) / (longest * longest) } else { 0.0 }
}
