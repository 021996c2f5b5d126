//! Where the bind shape of a skinned mesh stands: as its joints pose it.
//!
//! Viewers draw a vertex p at J B p and ignore the node of the mesh. Exporters write any transform there: the mesh of a character in metres may
//! hang below a node that scales by 0.01, or lie on its back. A garment would be cut, sized and weighed as that node has it, and its joints would then
//! stretch it to what is drawn. So where J B of the joint at the top of a skin is not the transform W of the node, the mesh is placed by
//! J B, or by the similarity that is nearest to it. The other joints then are as they are bound to that one, as at the start of animations (`bound.rs`).

use std::collections::{HashMap, HashSet};

use gltf::json::mesh::Semantic as Name;
use gltf::json::validation::Checked;
use nalgebra::Matrix3;

use super::accessor::Accessors;
use super::matrix::{self, Matrix};
use super::nodes::{Forest, Placed};
use super::roots::{SIZE, size_of, without_odd_roots};
use super::skin::inverse_binds;
use crate::base::vec3::distance;

/// A node stands as its joints pose the mesh if both agree in size ([`SIZE`]), to this angle \[rad\], and in place to this share of the skeleton:
/// files are exported in any frame of an animation.
const TURN: f64 = 0.25;
const PLACE: f64 = 0.25;
/// Share of the volume that a transform of its longest axis would have, up to which it flattens.
const FLAT: f64 = 1e-9;

/// A skin as it is bound and posed.
struct Skin {
    /// Inverse bind matrices by joint.
    binds: HashMap<usize, Matrix>,
    /// The joint above most others.
    top: usize,
    /// Ancestors of it.
    depth: usize,
    /// The similarity that stands for J B.
    stands: Matrix,
    /// The first of the skins that it shares joints with, directly or not.
    group: usize,
}

/// The transforms of nodes with skinned meshes that do not stand as their joints pose them, in place of their own.
pub(super) fn standing(accessors: &Accessors, forest: &Forest, placed: &[Placed]) -> HashMap<usize, Matrix> {
    let root = &accessors.doc.root;
    let weighted = |mesh: usize| {
        let primitives = root.meshes.get(mesh).into_iter().flat_map(|mesh| &mesh.primitives);
        primitives.flat_map(|p| p.attributes.keys()).any(|name| matches!(name, Checked::Valid(Name::Weights(_))))
    };
    let of = |p: &Placed| Some((p.node?, p.skin.filter(|_| weighted(p.mesh))?, p.world));
    let nodes: Vec<(usize, usize, Matrix)> = placed.iter().filter_map(of).collect();
    let skins = skins(accessors, forest, &nodes.iter().map(|(_, skin, _)| *skin).collect());
    let moved = nodes.iter().filter(|(_, skin, world)| skins.get(skin).is_some_and(|skin| departs(skin, world)));
    let groups: HashSet<usize> = moved.map(|(_, skin, _)| skins[skin].group).collect();
    let stands = |(node, skin, _): &(usize, usize, Matrix)| {
        let skin = skins.get(skin).filter(|skin| groups.contains(&skin.group))?;
        Some((*node, skin.stands))
    };
    nodes.iter().filter_map(stands).collect()
}

/// The skins in use. Meshes of one character stay together: skins that share joints stand as the one of them does whose top joint is highest.
fn skins(accessors: &Accessors, forest: &Forest, used: &HashSet<usize>) -> HashMap<usize, Skin> {
    let order = forest.order();
    let read = |index: &usize| {
        let skin = &accessors.doc.root.skins[*index];
        skin.inverse_bind_matrices?;
        let binds = inverse_binds(accessors, forest, *index).ok()?;
        let binds = without_odd_roots(forest, skin.joints.iter().map(|j| j.value()).zip(binds).collect());
        // For each node the highest joint among it and its ancestors, and how many joints that is for.
        let mut highest: Vec<Option<usize>> = vec![None; forest.parent.len()];
        let mut below: HashMap<usize, usize> = HashMap::new();
        for &n in &order {
            let is_joint = binds.contains_key(&n);
            highest[n] = forest.parent[n].and_then(|parent| highest[parent]).or(is_joint.then_some(n));
            highest[n].filter(|_| is_joint).into_iter().for_each(|top| *below.entry(top).or_default() += 1);
        }
        let top = below.into_iter().max_by_key(|(joint, count)| (*count, std::cmp::Reverse(*joint)))?.0;
        let stands = similar(&matrix::mul(&forest.world[top], &binds[&top]), bound(&binds[&top])?)?;
        let depth = std::iter::successors(forest.parent[top], |n| forest.parent[*n]).count();
        Some((*index, Skin { top, depth, binds, stands, group: *index }))
    };
    let mut all: Vec<(usize, Skin)> = used.iter().filter_map(read).collect();
    all.sort_by_key(|(index, skin)| (skin.depth, std::cmp::Reverse(skin.binds.len()), *index));
    // By joint, where its first skin has it: the group, and the transform that stands for the joint's place in the bind shape.
    let mut known: HashMap<usize, (usize, Matrix)> = HashMap::new();
    let mut out = HashMap::new();
    for (index, mut skin) in all {
        let mut joints: Vec<usize> = skin.binds.keys().copied().collect();
        joints.sort_unstable_by_key(|joint| (*joint != skin.top, *joint));
        let shared = joints.iter().find_map(|joint| Some((&skin.binds[joint], known.get(joint)?)));
        if let Some((bind, (group, place))) = shared {
            let stands = bound(bind).and_then(|about| similar(&matrix::mul(place, bind), about));
            (skin.group, skin.stands) = (*group, stands.unwrap_or(skin.stands));
        }
        for joint in joints {
            let Some(bound) = matrix::inverse(&skin.binds[&joint]) else { continue };
            known.entry(joint).or_insert_with(|| (skin.group, matrix::mul(&skin.stands, &bound)));
        }
        out.insert(index, skin);
    }
    out
}

/// Whether a node puts the bind shape of a skin elsewhere than its joints do.
fn departs(skin: &Skin, world: &Matrix) -> bool {
    let place = |joint: &usize| bound(&skin.binds[joint]);
    let Some(top) = place(&skin.top) else { return false };
    let Some(node) = similar(world, top) else { return true };
    let ratio = size_of(&node) / size_of(&skin.stands);
    let [a, b] = [&node, &skin.stands].map(|m| Matrix3::from_fn(|i, j| m[4 * j + i] / size_of(m)));
    let turn = (0.5 * ((a.transpose() * b).trace() - 1.0)).clamp(-1.0, 1.0).acos();
    let at = |p: [f64; 3]| matrix::point(&skin.stands, p);
    let far = |joint| place(joint).map(|p| distance(at(p), at(top)));
    let extent = skin.binds.keys().filter_map(far).fold(0.0, f64::max);
    let gap = distance(matrix::point(&node, top), at(top));
    (ratio - 1.0).abs() > SIZE || turn > TURN || gap > PLACE * extent && extent > 0.0
}

/// The similarity nearest to a transform, which takes a point to the same place; `None` of one that flattens.
fn similar(m: &Matrix, about: [f64; 3]) -> Option<Matrix> {
    let linear = Matrix3::from_fn(|i, j| m[4 * j + i]);
    let determinant = linear.determinant();
    if !(determinant.is_finite() && determinant.abs() > FLAT * linear.amax().powi(3)) {
        return None;
    }
    let svd = linear.svd(true, true);
    let turned = svd.u? * svd.v_t? * determinant.abs().cbrt();
    let mut out = matrix::IDENTITY;
    (0..9).for_each(|k| out[4 * (k / 3) + k % 3] = turned[(k % 3, k / 3)]);
    let (to, from) = (matrix::point(m, about), matrix::point(&out, about));
    (0..3).for_each(|k| out[12 + k] = to[k] - from[k]);
    out.iter().all(|x| x.is_finite()).then_some(out)
}

/// Where a joint is in the bind shape.
fn bound(bind: &Matrix) -> Option<[f64; 3]> {
    matrix::inverse(bind).map(|m| [m[12], m[13], m[14]])
}
