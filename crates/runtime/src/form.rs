//! Work of one dispatch: a pass apart, several passes of a step by tiles, or a whole frame.

use std::sync::Arc;

use crate::passes::{Pass, Schedule};

/// The form in which passes run on the GPU. It describes a shader completely.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Form {
    /// A pass alone.
    Apart(Pass),
    /// A pass alone, over several cloths.
    Together(Pass),
    /// Seams of several cloths, and passes of particles that follow them.
    Chain(Chain),
    /// Consecutive passes of a step, by tiles of a cloth or of several.
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
        if let Form::Apart(pass) | Form::Together(pass) = self { Some(*pass) } else { None }
    }
}

/// Seams and passes of particles that follow them in one dispatch, in place.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Chain {
    /// The passes, in order.
    pub passes: Vec<Pass>,
}

/// Consecutive passes of a step in one dispatch, described by what is compiled into its shader.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// The passes, in order.
    pub passes: Vec<Pass>,
    /// Sizes.
    pub shape: TileShape,
    /// Threads of a workgroup.
    pub threads: u32,
    /// Whether several cloths may share the dispatch.
    pub shared: bool,
    /// Its share of the steps of a frame.
    pub span: TileSpan,
}

/// The share of the steps of a frame that a tile makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TileSpan {
    /// Some passes of a step.
    #[default]
    Part,
    /// A whole step. Between the steps of a frame, previous positions are three numbers per particle.
    Step,
    /// A whole step, but for its start, which was made by the tile of the step before: each begins the next step for what it owns.
    Ahead,
}

impl Tile {
    /// Whether the multipliers of the last step end here.
    pub(crate) fn forgets(&self) -> bool {
        self.passes.contains(&Pass::Forget)
    }
}

/// Sizes of tiles, in columns and rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TileShape {
    /// Columns and rows that a tile owns; both even.
    pub inner: [u32; 2],
    /// How many it has on every side beside these, where the grid has any.
    pub around: [u32; 2],
    /// 1 where the first tile lacks a column or row, so that tiles begin at odd ones.
    pub lacks: [u32; 2],
    /// Columns and rows that there is room for.
    pub room: [u32; 2],
}

impl TileShape {
    /// Tiles along the sides of a grid.
    pub(crate) fn tiles(&self, sides: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|d| (sides[d] + self.lacks[d]).div_ceil(self.inner[d]))
    }
}

/// Whole frames in one dispatch, described by what is compiled into its shader.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fused {
    /// The passes, which cloths share whose frames are alike.
    pub(crate) schedule: Arc<Schedule>,
    /// Whether positions leave no room in the memory of a workgroup for a list of the colliders that are near.
    pub full: bool,
    /// Where positions are during the frame.
    pub hold: Hold,
    /// Particles that the memory of a workgroup has room for.
    pub places: u32,
    /// Threads of a workgroup.
    pub threads: u32,
}

/// Where a workgroup stores the positions of its cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hold {
    /// In its memory, with inverse masses and, unless registers have them, previous positions: 28 bytes per particle.
    Both,
    /// In its memory, with inverse masses: 16 bytes per particle.
    Wide,
    /// In its memory, alone: 12 bytes per particle.
    Narrow,
}
