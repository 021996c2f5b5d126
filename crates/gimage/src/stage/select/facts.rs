//! How the parts of a skinned mesh follow its joints.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::DisjointSets;

use super::words;
use crate::base::mesh::{Mesh, NONE, Semantic};

/// Weight from which a joint moves a corner of a triangle visibly.
const MOVES: f32 = 0.05;
/// Joints up to which a connected piece counts as solid: a plate of armour, with one at its hinge.
pub(super) const SOLID: usize = 2;

/// How one part follows the joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Following {
    /// Number of joints that move it.
    pub joints: usize,
    /// Share of its triangles on connected pieces that at most [`SOLID`] joints move, 0 to 1.
    pub solid: f64,
    /// The name of a joint that tells that hands and a face are among it.
    pub bare: Option<String>,
}

/// The joints that move the triangles of a part on one connected piece.
struct Moved {
    joints: BTreeSet<u32>,
    triangles: usize,
}

impl Moved {
    fn is_solid(&self) -> bool {
        self.joints.len() <= SOLID
    }
}

/// For each part of the mesh how it follows the joints. O(n log n) in the corners of triangles.
pub(crate) fn following(mesh: &Mesh) -> Vec<Following> {
    let mut out = vec![Following::default(); mesh.parts.len()];
    if !is_skinned(mesh) {
        return out;
    }
    let all = moved(mesh, &pieces(mesh));
    for (part, following) in out.iter_mut().enumerate() {
        let of = || all.range((part as u32, 0)..(part as u32 + 1, 0)).map(|(_, moved)| moved);
        let joints: BTreeSet<u32> = of().flat_map(|m| &m.joints).copied().collect();
        let count: usize = of().map(|m| m.triangles).sum();
        let solid: usize = of().filter(|m| m.is_solid()).map(|m| m.triangles).sum();
        let bare = words::bare(&names(mesh, &joints)).map(String::from);
        *following = Following { joints: joints.len(), solid: solid as f64 / f64::max(count as f64, 1.0), bare };
    }
    out
}

/// The joints that move the mesh, by number.
pub(super) fn joints(mesh: &Mesh) -> BTreeSet<u32> {
    if is_skinned(mesh) {
        moved(mesh, &pieces(mesh)).into_values().flat_map(|m| m.joints).collect()
    } else {
        BTreeSet::new()
    }
}

/// The names of joints.
pub(super) fn names<'a>(mesh: &'a Mesh, joints: &BTreeSet<u32>) -> Vec<&'a str> {
    joints.iter().filter_map(|joint| mesh.skeleton.joints.get(*joint as usize)).map(|joint| &*joint.name).collect()
}

/// For each triangle whether its part is solid on its connected piece.
pub(super) fn solid(mesh: &Mesh) -> Vec<bool> {
    let piece = pieces(mesh);
    let all = moved(mesh, &piece);
    let key = |(part, t): (&u32, &[u32; 3])| (*part, piece[t[0] as usize]);
    mesh.triangle_part.iter().zip(&mesh.triangles).map(|pair| all[&key(pair)].is_solid()).collect()
}

/// The joints that move the triangles of each part on each connected piece.
fn moved(mesh: &Mesh, piece: &[u32]) -> BTreeMap<(u32, u32), Moved> {
    let sets: Vec<_> = (0..)
        .map_while(|n| Some((mesh.channel(&Semantic::Joints(n))?, mesh.channel(&Semantic::Weights(n))?)))
        .collect();
    let mut all: BTreeMap<(u32, u32), Moved> = BTreeMap::new();
    for (t, &part) in mesh.triangle_part.iter().enumerate() {
        let key = (part, piece[mesh.triangles[t][0] as usize]);
        let moved = all.entry(key).or_insert(Moved { joints: BTreeSet::new(), triangles: 0 });
        moved.triangles += 1;
        for (of, weights) in &sets {
            for c in 0..3 {
                let (Some(of), Some(weights)) = (of.at(t, c), weights.at(t, c)) else { continue };
                moved.joints.extend(of.iter().zip(weights).filter(|(_, w)| **w >= MOVES).map(|(j, _)| *j as u32));
            }
        }
    }
    all
}

/// For each vertex the connected piece that it belongs to; vertices at equal positions are joined.
pub(super) fn pieces(mesh: &Mesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.positions.len());
    // Adding 0 turns -0 into 0.
    let place = |v: u32| mesh.positions[v as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.sort_by_key(|&v| place(v));
    for pair in order.windows(2).filter(|pair| place(pair[0]) == place(pair[1])) {
        sets.union(pair[0], pair[1]);
    }
    for &[a, b, c] in &mesh.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    sets.into_representatives()
}

/// Whether all triangles are of one part.
pub(super) fn is_single(mesh: &Mesh) -> bool {
    mesh.triangle_part.iter().all(|p| *p == mesh.triangle_part[0])
}

/// Whether any corner of the mesh follows a joint.
pub(super) fn is_skinned(mesh: &Mesh) -> bool {
    let joints = mesh.channel(&Semantic::Joints(0));
    !mesh.skeleton.joints.is_empty() && joints.is_some_and(|c| c.corners.iter().any(|&k| k != NONE))
}
