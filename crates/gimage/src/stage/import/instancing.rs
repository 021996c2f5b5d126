//! `EXT_mesh_gpu_instancing`: one node, many placings.

use super::accessor::Accessors;
use super::matrix::{self, Matrix};
use crate::error::Result;

/// The transforms of the instances of a node, each to be applied before the node's own; `None` without the extension.
pub(crate) fn instances(accessors: &Accessors, node: usize) -> Result<Option<Vec<Matrix>>> {
    let doc = accessors.doc;
    let extensions = doc.root.nodes.get(node).and_then(|n| n.extensions.as_ref());
    let Some(extension) = extensions.and_then(|e| e.others.get("EXT_mesh_gpu_instancing")) else { return Ok(None) };
    let element = || format!("node {node} `{}`, EXT_mesh_gpu_instancing", doc.node_name(node));
    let read = |name: &str, width: usize| -> Result<Option<Vec<f32>>> {
        let Some(index) = extension["attributes"].get(name) else { return Ok(None) };
        let index = index.as_u64().ok_or_else(|| doc.bad(element(), format!("{name} is not an accessor index")))?;
        let floats = accessors.floats(index as usize)?;
        if floats.width != width {
            return Err(doc.bad(element(), format!("{name} has {} components, not {width}", floats.width)));
        }
        if floats.values.iter().any(|v| !v.is_finite()) {
            return Err(doc.bad(element(), format!("{name} has values that are not finite")));
        }
        Ok(Some(floats.values))
    };
    let (t, r, s) = (read("TRANSLATION", 3)?, read("ROTATION", 4)?, read("SCALE", 3)?);
    let counts = [t.as_ref().map(|t| t.len() / 3), r.as_ref().map(|r| r.len() / 4), s.as_ref().map(|s| s.len() / 3)];
    let Some(count) = counts.iter().flatten().copied().next() else {
        return Err(doc.bad(element(), "it has no TRANSLATION, ROTATION or SCALE"));
    };
    if counts.iter().flatten().any(|&c| c != count) {
        return Err(doc.bad(element(), "its attributes have different counts"));
    }
    fn at<const N: usize>(values: &Option<Vec<f32>>, i: usize, default: [f64; N]) -> [f64; N] {
        values.as_ref().map_or(default, |v| std::array::from_fn(|k| v[N * i + k].into()))
    }
    let one = |i| matrix::from_trs(at(&t, i, [0.0; 3]), at(&r, i, [0.0, 0.0, 0.0, 1.0]), at(&s, i, [1.0; 3]));
    Ok(Some((0..count).map(one).collect()))
}
