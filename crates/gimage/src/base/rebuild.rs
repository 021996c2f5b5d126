//! A mesh without some of its triangles.

use gimage_bundle::DisjointSets;

use crate::base::halfedge::{next, origin, sorted_edges};
use crate::base::mesh::{Mesh, NONE};

/// Keeps some triangles; all keep their order. Where the kept ones touch in a vertex only, each fan gets a vertex of its own.
/// Returns the mesh and, for each of its triangles, that of the old mesh. O(n log n).
pub(crate) fn rebuild(mut mesh: Mesh, keep: &[bool]) -> (Mesh, Vec<u32>) {
    let kept: Vec<u32> = (0..keep.len() as u32).filter(|&t| keep[t as usize]).collect();
    mesh.triangles = kept.iter().map(|&t| mesh.triangles[t as usize]).collect();
    mesh.triangle_part = kept.iter().map(|&t| mesh.triangle_part[t as usize]).collect();
    for channel in &mut mesh.channels {
        let corners = |&t: &u32| (0..3).map(move |c| 3 * t as usize + c);
        channel.corners = kept.iter().flat_map(corners).map(|k| channel.corners[k]).collect();
    }
    mesh.channels.retain(|c| c.corners.iter().any(|&k| k != NONE));
    split_fans(&mut mesh);
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut number = vec![0u32; used.len()];
    let mut count = 0;
    for v in (0..used.len()).filter(|&v| used[v]) {
        mesh.positions[count] = mesh.positions[v];
        number[v] = count as u32;
        count += 1;
    }
    mesh.positions.truncate(count);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
    (mesh, kept)
}

/// Gives each fan of triangles around a vertex a vertex of its own; the first keeps the old one.
fn split_fans(mesh: &mut Mesh) {
    let tri = &mesh.triangles;
    let mut fans = DisjointSets::new(3 * tri.len());
    for run in sorted_edges(tri).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let &[(_, _, h), (_, _, g)] = run else { continue };
        let same = origin(tri, h) == origin(tri, g);
        let (start, end) = if same { (g, next(g)) } else { (next(g), g) };
        fans.union(h, start);
        fans.union(next(h), end);
    }
    let mut owner = vec![NONE; mesh.positions.len()];
    let mut name = vec![NONE; 3 * tri.len()];
    for c in 0..3 * mesh.triangles.len() {
        let (fan, v) = (fans.find(c as u32) as usize, mesh.triangles[c / 3][c % 3] as usize);
        if name[fan] == NONE {
            name[fan] = v as u32;
            if owner[v] == NONE {
                owner[v] = fan as u32;
            } else {
                name[fan] = mesh.positions.len() as u32;
                mesh.positions.push(mesh.positions[v]);
            }
        }
        mesh.triangles[c / 3][c % 3] = name[fan];
    }
}
