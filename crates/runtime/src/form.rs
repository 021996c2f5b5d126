//! What one dispatch runs: a pass apart, several passes of a step by tiles, or a whole frame.

use crate::fused::Fused;
use crate::passes::Pass;
use crate::tile::Tile;

/// The form in which passes run on the GPU. It describes a shader completely.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Form {
    /// A pass alone.
    Apart(Pass),
    /// Consecutive passes of a step, by tiles of the cloth.
    Tile(Tile),
    /// Whole frames of whole cloths.
    Whole(Fused),
}

impl From<Pass> for Form {
    fn from(pass: Pass) -> Self {
        Form::Apart(pass)
    }
}

impl Form {
    /// The pass, if it runs alone.
    pub fn pass(&self) -> Option<Pass> {
        if let Form::Apart(pass) = self { Some(*pass) } else { None }
    }
}
