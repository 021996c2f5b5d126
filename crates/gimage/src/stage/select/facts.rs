//! How the parts of a skinned mesh follow its joints.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::DisjointSets;

use crate::base::mesh::{Mesh, NONE, Semantic};

/// Weight from which a joint moves a corner of a triangle visibly.
const MOVES: f32 = 0.05;
/// Joints up to which a connected piece counts as solid: a plate of armour, with one at its hinge.
const SOLID: usize = 2;

/// How one part follows the joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Following {
    /// Number of joints that move it.
    pub joints: usize,
    /// Share of its triangles on connected pieces that at most [`SOLID`] joints move, 0 to 1.
    pub solid: f64,
}

/// For each part of the mesh how it follows the joints. O(n log n) in the corners of triangles.
pub(crate) fn following(mesh: &Mesh) -> Vec<Following> {
    let mut out = vec![Following::default(); mesh.parts.len()];
    if !is_skinned(mesh) {
        return out;
    }
    let sets: Vec<_> = (0..)
        .map_while(|n| Some((mesh.channel(&Semantic::Joints(n))?, mesh.channel(&Semantic::Weights(n))?)))
        .collect();
    let piece = pieces(mesh);
    let mut joints: BTreeMap<(u32, u32), BTreeSet<u32>> = BTreeMap::new();
    let mut triangles: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (t, &part) in mesh.triangle_part.iter().enumerate() {
        let key = (part, piece[mesh.triangles[t][0] as usize]);
        *triangles.entry(key).or_default() += 1;
        let joints = joints.entry(key).or_default();
        for (of, weights) in &sets {
            for c in 0..3 {
                let (Some(of), Some(weights)) = (of.at(t, c), weights.at(t, c)) else { continue };
                joints.extend(of.iter().zip(weights).filter(|(_, w)| **w >= MOVES).map(|(j, _)| *j as u32));
            }
        }
    }
    for (part, following) in out.iter_mut().enumerate() {
        let range = (part as u32, 0)..(part as u32 + 1, 0);
        let all: BTreeSet<u32> = joints.range(range.clone()).flat_map(|(_, set)| set).copied().collect();
        let (mut solid, mut count) = (0, 0);
        for (key, n) in triangles.range(range) {
            count += n;
            solid += if joints.get(key).is_some_and(|set| set.len() <= SOLID) { *n } else { 0 };
        }
        *following = Following { joints: all.len(), solid: solid as f64 / f64::max(count as f64, 1.0) };
    }
    out
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

/// Whether any corner of the mesh follows a joint.
pub(super) fn is_skinned(mesh: &Mesh) -> bool {
    let joints = mesh.channel(&Semantic::Joints(0));
    !mesh.skeleton.joints.is_empty() && joints.is_some_and(|c| c.corners.iter().any(|&k| k != NONE))
}
