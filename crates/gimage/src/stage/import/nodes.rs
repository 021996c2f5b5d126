//! The node graph: what is placed where.

use super::document::Document;
use super::findings::Findings;
use super::matrix::{self, Matrix};
use crate::error::Result;
use crate::record::Severity;

/// A mesh placed by a node.
pub(crate) struct Placed {
    pub node: Option<usize>,
    pub mesh: usize,
    pub skin: Option<usize>,
    pub world: Matrix,
}

/// The nodes of a document, checked to be a forest.
pub(crate) struct Forest {
    pub parent: Vec<Option<usize>>,
    /// Transform of each node to world space.
    pub world: Vec<Matrix>,
    children: Vec<Vec<usize>>,
}

impl Forest {
    /// Checks that every node has at most one parent and that none is its own ancestor, then finds the transforms. Walks with
    /// a list, as a hierarchy may be deeper than the stack.
    pub fn new(doc: &Document) -> Result<Self> {
        let n = doc.root.nodes.len();
        let (mut parent, mut children) = (vec![None; n], Vec::with_capacity(n));
        let element = |i: usize| format!("node {i} `{}`", doc.node_name(i));
        for (i, node) in doc.root.nodes.iter().enumerate() {
            let list: Vec<usize> = node.children.iter().flatten().map(|c| c.value()).collect();
            for &c in &list {
                match parent.get_mut(c) {
                    None => return Err(doc.bad(element(i), format!("its child {c} does not exist"))),
                    Some(Some(first)) => {
                        let problem = format!("both node {first} and node {i} have it as a child");
                        return Err(doc.bad(element(c), problem));
                    }
                    Some(slot) => *slot = Some(i),
                }
            }
            children.push(list);
        }
        let mut world = doc.locals.clone();
        let mut queue: Vec<usize> = (0..n).filter(|&i| parent[i].is_none()).collect();
        let mut seen = vec![false; n];
        while let Some(i) = queue.pop() {
            seen[i] = true;
            for &c in &children[i] {
                world[c] = matrix::mul(&world[i], &doc.locals[c]);
                queue.push(c);
            }
        }
        if let Some(i) = seen.iter().position(|s| !s) {
            return Err(doc.bad(element(i), "it is its own ancestor (the node graph has a cycle)"));
        }
        Ok(Self { parent, world, children })
    }

    /// All nodes, parents before their children.
    pub fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.parent.len()).filter(|n| self.parent[*n].is_none()).collect();
        let mut at = 0;
        while at < order.len() {
            order.extend(&self.children[order[at]]);
            at += 1;
        }
        order
    }

    /// The meshes of the scene, in depth-first order: of the default scene, else of all scenes, else of all nodes. A scene
    /// without nodes is passed over, and reported.
    pub fn placed(&self, doc: &Document, findings: &mut Findings) -> Result<Vec<Placed>> {
        let scenes = &doc.root.scenes;
        let mut roots: Vec<usize> = Vec::new();
        let mut listed = vec![false; self.parent.len()];
        let mut take = |list: &mut dyn Iterator<Item = usize>, what: &str| -> Result<()> {
            for i in list {
                match listed.get_mut(i) {
                    None => return Err(doc.bad(what, format!("its node {i} does not exist"))),
                    Some(true) => {}
                    Some(new) => {
                        *new = true;
                        roots.push(i);
                    }
                }
            }
            Ok(())
        };
        let default = doc.root.scene.map(|s| s.value());
        if let Some(index) = default.filter(|&index| index >= scenes.len()) {
            return Err(doc.bad(format!("scene {index}"), "the default scene does not exist"));
        }
        let listing = |k: &usize| !scenes[*k].nodes.is_empty();
        let chosen: Vec<usize> = match default.filter(listing) {
            Some(index) => vec![index],
            None => (0..scenes.len()).filter(listing).collect(),
        };
        for &k in &chosen {
            take(&mut scenes[k].nodes.iter().map(|n| n.value()), &format!("scene {k}"))?;
        }
        if chosen.is_empty() {
            take(&mut (0..self.parent.len()).filter(|&i| self.parent[i].is_none()), "nodes")?;
        }
        let empty = default.map_or(!scenes.is_empty() && chosen.is_empty(), |index| scenes[index].nodes.is_empty());
        let message = "The scene lists no nodes; the nodes of the other scenes, or else all nodes, were placed.";
        let lost = usize::from(empty && !self.parent.is_empty());
        findings.add(Severity::Repair, "empty-scene", lost, message, || format!("scene {}", default.unwrap_or(0)));
        let mut placed = Vec::new();
        let mut seen = vec![false; self.parent.len()];
        let mut stack: Vec<usize> = roots.into_iter().rev().collect();
        while let Some(i) = stack.pop() {
            // A scene may list a node and also its ancestor.
            if std::mem::replace(&mut seen[i], true) {
                continue;
            }
            stack.extend(self.children[i].iter().rev());
            let node = &doc.root.nodes[i];
            let Some(mesh) = node.mesh.map(|m| m.value()) else { continue };
            let element = || format!("node {i} `{}`", doc.node_name(i));
            if mesh >= doc.root.meshes.len() {
                return Err(doc.bad(element(), format!("its mesh {mesh} does not exist")));
            }
            let skin = node.skin.map(|s| s.value());
            if let Some(s) = skin.filter(|&s| s >= doc.root.skins.len()) {
                return Err(doc.bad(element(), format!("its skin {s} does not exist")));
            }
            placed.push(Placed { node: Some(i), mesh, skin, world: self.world[i] });
        }
        if doc.root.nodes.is_empty() {
            // A library of meshes without a scene: each stands at the origin.
            let lone = |mesh| Placed { node: None, mesh, skin: None, world: matrix::IDENTITY };
            placed.extend((0..doc.root.meshes.len()).map(lone));
        }
        Ok(placed)
    }
}
