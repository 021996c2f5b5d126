//! Nodes that move as a character moves: joints of skins, and nodes that animations have for targets.

use super::document::Document;
use super::nodes::Forest;

/// Which nodes of a document move.
pub(crate) struct Moving(Vec<bool>);

impl Moving {
    pub fn new(doc: &Document) -> Self {
        let mut moves = vec![false; doc.root.nodes.len()];
        let mut mark = |node: usize| moves.get_mut(node).into_iter().for_each(|m| *m = true);
        doc.root.skins.iter().flat_map(|s| &s.joints).for_each(|joint| mark(joint.value()));
        let channels = doc.clips.iter().flat_map(|clip| clip["channels"].as_array().into_iter().flatten());
        let of_nodes =
            channels.filter(|c| ["translation", "rotation", "scale"].iter().any(|p| c["target"]["path"] == **p));
        of_nodes.filter_map(|c| usize::try_from(c["target"]["node"].as_u64()?).ok()).for_each(mark);
        Moving(moves)
    }

    /// The nearest node that moves among a node and its ancestors.
    pub fn holder(&self, forest: &Forest, node: usize) -> Option<usize> {
        let mut at = Some(node);
        while let Some(n) = at.filter(|n| !self.0.get(*n).copied().unwrap_or(false)) {
            at = forest.parent.get(n).copied().flatten();
        }
        at
    }
}
