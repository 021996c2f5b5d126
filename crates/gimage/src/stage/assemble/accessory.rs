//! Attaches accessories to the nearest point of the nearest piece.

use gimage_bundle::manifest::Accessory;

use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, dot, normalize, scale, sub};
use crate::stage::component::Component;
use crate::stage::image::PieceImage;

/// A component that gets no image, and why.
pub(crate) struct Rider<'a> {
    pub component: &'a Component,
    pub reason: String,
}

/// Anchors every rider on the pieces. O((riders + triangles) log triangles).
pub(crate) fn anchor(mesh: &Mesh, riders: &[Rider<'_>], pieces: &[&PieceImage]) -> Vec<Accessory> {
    if riders.is_empty() {
        return Vec::new();
    }
    let (mut positions, mut triangles, mut owner) = (Vec::new(), Vec::new(), Vec::new());
    for (k, piece) in pieces.iter().enumerate() {
        let base = positions.len() as u32;
        positions.extend_from_slice(&piece.disk.positions);
        triangles.extend(piece.disk.triangles.iter().map(|t| t.map(|v| v + base)));
        owner.extend((0..piece.disk.triangles.len()).map(|t| (k, t)));
    }
    let surface = Closest::new(&positions, &triangles);
    riders
        .iter()
        .map(|rider| {
            let c = rider.component;
            // The area-weighted centre; a part without area has the centre of its box.
            let (mut centre, mut total) = ([0.0; 3], 0.0);
            for &t in &c.triangles {
                let (area, [p, q, r]) = (mesh.triangle_area(t as usize), mesh.corners(t as usize));
                centre = add(centre, scale(add(p, add(q, r)), area / 3.0));
                total += area;
            }
            let (lo, hi) = c.bounds;
            let centre = if total > 0.0 { scale(centre, 1.0 / total) } else { scale(add(lo, hi), 0.5) };
            let mut out = Accessory {
                name: c.name.clone(),
                triangles: c.triangles.len() as u32,
                area: c.area,
                center: centre,
                reason: rider.reason.clone(),
                ..Accessory::default()
            };
            if let Some(near) = surface.project(centre) {
                let (k, t) = owner[near.triangle as usize];
                let piece = pieces[k];
                let tri = piece.disk.triangles[t];
                let [p, q, r] = tri.map(|v| piece.disk.positions[v as usize]);
                let normal = normalize(cross(sub(q, p), sub(r, p)));
                let place = |c: usize, cells: u32| {
                    let at: f64 = (0..3).map(|k| near.barycentric[k] * piece.uv[tri[k] as usize][c]).sum();
                    (at / f64::from(cells)).clamp(0.0, 1.0)
                };
                out.piece = k as u32;
                (out.u, out.v) = (place(0, piece.width - 1), place(1, piece.height - 1));
                out.normal_offset = dot(sub(centre, near.point), normal);
            }
            out
        })
        .collect()
}
