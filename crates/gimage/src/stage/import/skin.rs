//! The skeleton: the union of the skins of all kept nodes, and the nodes that move meshes rigidly.
//!
//! glTF places a vertex p of a skinned mesh at J B p, where J is the joint's world transform and B its inverse bind matrix,
//! and ignores the transform W of the mesh's node. The importer stores W p, so the stored inverse bind matrix is B W^-1. All
//! of it is in metres: with S the scale by the unit of the file, positions are S W p, worlds S J S^-1 and inverse binds
//! S B W^-1 S^-1, so that world * inverse_bind * position is S J B p, the glTF result in metres. A mesh without a skin follows the node that
//! moves it: with H the transform of that node, its inverse bind matrix is S H^-1 S^-1.

use std::collections::HashMap;

use super::accessor::Accessors;
use super::findings::Findings;
use super::matrix::{self, Matrix};
use super::nodes::Forest;
use super::shapes::{self, FileCollider, Given};
use crate::base::mesh::{Joint, Skeleton};
use crate::error::{Error, Result};

/// Most joints of a skeleton.
const MAX_JOINTS: usize = 1 << 14;
/// Inverse bind matrices closer than this, relative to their largest entry, are the same.
const SAME: f64 = 1e-6;
/// The same for a mesh that a node moves: the inverse of its transform differs from a stored matrix by the rounding of both.
const NEARLY: f64 = 1e-5;

/// A skeleton under construction.
pub(crate) struct Bones<'a> {
    accessors: &'a Accessors<'a>,
    forest: &'a Forest,
    unit: f64,
    joints: Vec<Joint>,
    nodes: Vec<usize>,
    of_node: HashMap<usize, Vec<u32>>,
    binds: HashMap<usize, Vec<Matrix>>,
}

impl<'a> Bones<'a> {
    pub fn new(accessors: &'a Accessors<'a>, forest: &'a Forest, unit: f64) -> Self {
        let (joints, nodes, of_node, binds) = Default::default();
        Self { accessors, forest, unit, joints, nodes, of_node, binds }
    }

    /// Adds a skin for a mesh placed by `world`; returns the skeleton's joint for each of the skin's. `None` if the placing
    /// has no inverse.
    pub fn add(&mut self, skin: usize, world: &Matrix) -> Result<Option<Vec<u32>>> {
        let doc = self.accessors.doc;
        let Some(back) = matrix::inverse(world) else { return Ok(None) };
        if !self.binds.contains_key(&skin) {
            let binds = inverse_binds(self.accessors, self.forest, skin)?;
            self.binds.insert(skin, binds);
        }
        let binds = self.binds[&skin].clone();
        let mut map = Vec::with_capacity(binds.len());
        for (joint, bind) in doc.root.skins[skin].joints.iter().zip(&binds) {
            map.push(self.joint(joint.value(), matrix::in_unit(&matrix::mul(bind, &back), self.unit), SAME)?);
        }
        Ok(Some(map))
    }

    /// The skeleton's joint for a mesh that a node moves rigidly, placed where the node is in the file's pose. `None` if the transform of
    /// the node has no inverse.
    pub fn hold(&mut self, node: usize) -> Result<Option<u32>> {
        let Some(back) = matrix::inverse(&self.forest.world[node]) else { return Ok(None) };
        self.joint(node, matrix::in_unit(&back, self.unit), NEARLY).map(Some)
    }

    /// The joint of a node with an inverse bind matrix, known to within a share of its largest entry, or new.
    fn joint(&mut self, node: usize, bind: Matrix, within: f64) -> Result<u32> {
        let doc = self.accessors.doc;
        let twins = self.of_node.entry(node).or_default();
        let known = twins.iter().find(|&&k| same(&self.joints[k as usize].inverse_bind, &bind, within));
        if let Some(&k) = known {
            return Ok(k);
        }
        let k = self.joints.len() as u32;
        twins.push(k);
        self.nodes.push(node);
        let world = matrix::in_unit(&self.forest.world[node], self.unit);
        self.joints.push(Joint { name: doc.node_name(node), parent: None, inverse_bind: bind, world });
        if self.joints.len() > MAX_JOINTS {
            return Err(Error::TooLarge {
                what: format!("{}: the skeleton", doc.path.display()),
                need: format!("more than {MAX_JOINTS} joints"),
                limit: MAX_JOINTS.to_string(),
                hint: "import fewer pieces".into(),
            });
        }
        Ok(k)
    }

    /// The colliders of the file, in its world.
    pub fn colliders(&self, findings: &mut Findings) -> Vec<FileCollider> {
        let doc = self.accessors.doc;
        let there: Vec<&Given> = doc.colliders.iter().filter(|g| g.node < self.forest.world.len()).collect();
        shapes::note_unread(&there, |n| doc.node_name(n), findings);
        let read = there.iter().filter_map(|g| {
            let ancestors = std::iter::successors(Some(g.node), |n| self.forest.parent[*n]);
            let joint = ancestors.into_iter().find_map(|n| self.of_node.get(&n)?.first().copied());
            let (node, world) = (doc.node_name(g.node), self.forest.world[g.node]);
            Some(FileCollider { source: g.source, node, joint, shape: g.shape.ok()?, world })
        });
        read.collect()
    }

    /// The skeleton, with each joint's nearest ancestor among the joints.
    pub fn finish(mut self) -> Skeleton {
        for k in 0..self.joints.len() {
            let mut node = self.forest.parent[self.nodes[k]];
            while let Some(n) = node {
                if let Some(twins) = self.of_node.get(&n) {
                    self.joints[k].parent = twins.first().copied();
                    break;
                }
                node = self.forest.parent[n];
            }
        }
        Skeleton { joints: self.joints }
    }
}

/// The inverse bind matrix of each joint of a skin.
pub(super) fn inverse_binds(accessors: &Accessors, forest: &Forest, skin: usize) -> Result<Vec<Matrix>> {
    let doc = accessors.doc;
    let bones = &doc.root.skins[skin];
    let bad = |problem: String| Err(doc.bad(format!("skin {skin}"), problem));
    if let Some(j) = bones.joints.iter().find(|j| j.value() >= forest.world.len()) {
        return bad(format!("its joint node {} does not exist", j.value()));
    }
    let Some(accessor) = bones.inverse_bind_matrices else {
        return Ok(vec![matrix::IDENTITY; bones.joints.len()]);
    };
    let floats = accessors.floats(accessor.value())?;
    let all: Vec<Matrix> = floats.values.as_chunks::<16>().0.iter().map(|m| m.map(f64::from)).collect();
    if floats.width != 16 || all.len() < bones.joints.len() {
        return bad(format!("it has {} inverse bind matrices for {} joints", all.len(), bones.joints.len()));
    }
    if all.iter().flatten().any(|x| !x.is_finite()) {
        return bad("its inverse bind matrices have entries that are not finite".into());
    }
    Ok(all)
}

fn same(a: &Matrix, b: &Matrix, within: f64) -> bool {
    let size = a.iter().fold(1.0f64, |s, x| s.max(x.abs()));
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= within * size)
}
