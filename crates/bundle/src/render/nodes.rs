//! The nodes of the scene and their transforms.

use serde_json::Value;

use super::matrix::{IDENTITY, Matrix, from_parts, mul};
use super::{RenderFile, damaged};
use crate::error::Result;

/// A mesh in the scene.
pub(super) struct Placed {
    pub node: Option<usize>,
    pub mesh: usize,
    pub world: Matrix,
}

impl RenderFile<'_> {
    pub(super) fn list(&self, name: &str) -> &[Value] {
        self.json[name].as_array().map_or(&[], Vec::as_slice)
    }

    /// The meshes of the scene, each with the transform of its node to world space, depth first: of the default scene, else of all scenes,
    /// else of all nodes, else every mesh at the origin. Errors on cycles and on nodes that do not exist.
    pub(super) fn placed(&self) -> Result<Vec<Placed>> {
        let (nodes, scenes) = (self.list("nodes"), self.list("scenes"));
        if nodes.is_empty() {
            let lone = |mesh| Placed { node: None, mesh, world: IDENTITY };
            return Ok((0..self.list("meshes").len()).map(lone).collect());
        }
        let numbers = |value: &Value| -> Vec<usize> {
            value.as_array().into_iter().flatten().filter_map(Value::as_u64).map(|n| n as usize).collect()
        };
        let default = self.json["scene"].as_u64().and_then(|s| scenes.get(s as usize));
        let chosen = default.filter(|s| !numbers(&s["nodes"]).is_empty());
        let mut roots: Vec<usize> = match chosen {
            Some(scene) => numbers(&scene["nodes"]),
            None => scenes.iter().flat_map(|s| numbers(&s["nodes"])).collect(),
        };
        if roots.is_empty() {
            let mut child = vec![false; nodes.len()];
            let children = nodes.iter().flat_map(|n| numbers(&n["children"]));
            children.filter(|&c| c < nodes.len()).for_each(|c| child[c] = true);
            roots = (0..nodes.len()).filter(|&n| !child[n]).collect();
        }
        let parents = self.parents(&numbers)?;
        let mut out = Vec::new();
        let mut seen = vec![false; nodes.len()];
        let mut stack: Vec<usize> = roots.into_iter().rev().collect();
        while let Some(n) = stack.pop() {
            let node = nodes.get(n).ok_or_else(|| damaged(format!("node {n}"), "it does not exist"))?;
            if std::mem::replace(&mut seen[n], true) {
                continue;
            }
            stack.extend(numbers(&node["children"]).iter().rev());
            if let Some(mesh) = node["mesh"].as_u64() {
                out.push(Placed { node: Some(n), mesh: mesh as usize, world: self.world(n, &parents)? });
            }
        }
        Ok(out)
    }

    fn parents(&self, numbers: &dyn Fn(&Value) -> Vec<usize>) -> Result<Vec<Option<usize>>> {
        let nodes = self.list("nodes");
        let mut parents = vec![None; nodes.len()];
        for (n, node) in nodes.iter().enumerate() {
            for child in numbers(&node["children"]) {
                match parents.get_mut(child) {
                    Some(slot @ None) => *slot = Some(n),
                    Some(Some(_)) => return Err(damaged(format!("node {child}"), "it has two parents")),
                    None => return Err(damaged(format!("node {n}"), format!("its child {child} does not exist"))),
                }
            }
        }
        Ok(parents)
    }

    fn world(&self, node: usize, parents: &[Option<usize>]) -> Result<Matrix> {
        let (mut world, mut at, mut steps) = (IDENTITY, Some(node), 0);
        while let Some(n) = at {
            steps += 1;
            if steps > parents.len() {
                return Err(damaged(format!("node {node}"), "it is its own ancestor"));
            }
            world = mul(&self.local(n), &world);
            at = parents[n];
        }
        Ok(world)
    }

    fn local(&self, n: usize) -> Matrix {
        let node = &self.list("nodes")[n];
        let given = |key: &str, k: usize, default: f64| node[key][k].as_f64().unwrap_or(default);
        if node.get("matrix").is_some() {
            return std::array::from_fn(|k| given("matrix", k, IDENTITY[k]));
        }
        let translation = std::array::from_fn(|k| given("translation", k, 0.0));
        let rotation = std::array::from_fn(|k| given("rotation", k, if k == 3 { 1.0 } else { 0.0 }));
        from_parts(translation, rotation, std::array::from_fn(|k| given("scale", k, 1.0)))
    }
}
