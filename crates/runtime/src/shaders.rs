//! Shaders: which files make the shader of a form, and what it binds.
//!
//! A pass is declared once, by its [`rule`](rule()). Each form adds a loop to it: over a whole cloth apart, over a
//! workgroup's cloth in a whole frame, over a part of a grid in a tile. A shader is its files, in order.

use crate::cloth::Cloth;
use crate::form::{Form, TileShape};

/// How elements are given to threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    Particles,
    Rings,
    /// Vertices of the surface of a body.
    Vertices,
    /// Patches of it.
    Patches,
    /// Every texel of every grid.
    Texels,
    /// Half the texels: `true` every other column, `false` every other row.
    Half(bool),
    /// A quarter of the texels: every other column of every other row.
    Quarter,
    /// One workgroup.
    One,
    /// A workgroup a grid.
    Grids,
    /// A workgroup a cloth.
    Cloth,
    /// The same, a layer of workgroups each.
    Layers,
    /// A workgroup a tile of a grid.
    Tiles(TileShape),
    /// A workgroup a tile of the nodes of a level, from 1 for the finest.
    Nodes(u32),
}

/// A shader.
pub struct Source {
    pub stem: &'static str,
    pub files: Vec<&'static str>,
    /// Loops, in which `each` stands for the rule named beside.
    pub loops: Vec<(&'static str, &'static str)>,
    /// Code that is made from the schedule.
    pub program: String,
    pub bindings: Vec<Bound>,
    pub constants: Vec<(&'static str, f64)>,
    pub threads: Threads,
    /// Lists that lie in [`Slot::Scratch`].
    pub scratch: usize,
}

macro_rules! part {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/part/", $name, ".wgsl"))
    };
}
macro_rules! pass {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name, ".wgsl"))
    };
}
macro_rules! turn {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/loop/", $name, ".wgsl"))
    };
}

// Below the macros, which they use.
mod apart;
mod chain;
mod constants;
mod lists;
mod parts;
mod program;
mod rare;
mod rule;
mod slot;
mod tile;
mod together;
mod whole;

pub use chain::{chain, tail};
pub use lists::HEAD;
#[cfg(feature = "gpu")]
pub use lists::{LASTING, SCRATCH};
pub use parts::Bound;
pub use rule::{Over, over};
#[cfg(feature = "gpu")]
pub use slot::{HINT_BYTES, PLANE_BYTES, VERTEX_BYTES};
pub use slot::{LISTED, Slot, listed};
pub use tile::{Stages, stages, tile};
pub use together::is_shared;
pub use whole::{is_whole, whole};

/// The shader of a form.
pub fn source(form: &Form) -> Source {
    match form {
        Form::Apart(pass) => apart::apart(*pass),
        Form::Together(pass) => together::together(*pass),
        Form::Chain(of) => chain(of),
        Form::Tile(of) => tile(of),
        Form::Whole(of) => whole(of),
    }
}

/// Workgroups in a row of a list; x is limited to 65,535.
const ROW: u32 = 32_768;

/// Workgroups for a list of elements.
pub fn list(count: usize) -> [u32; 3] {
    let groups = (count as u32).div_ceil(64);
    [groups.min(ROW), groups.div_ceil(ROW), 1]
}

impl Source {
    /// The whole text.
    pub fn text(&self) -> String {
        let mut text = [&[constants::text()], &self.files[..]].concat().concat();
        for (turn, call) in &self.loops {
            // Only the names of functions: comments may say `each`.
            let named = |turn: String, end: &&str| turn.replace(&format!("each{end}"), &format!("{call}{end}"));
            text += &["(", "_all(", "_own("].iter().fold(turn.to_string(), named);
        }
        text + &self.program
    }

    /// Workgroups to dispatch for a cloth.
    pub fn workgroups(&self, cloth: &Cloth) -> [u32; 3] {
        self.workgroups_of(&Extent::of(cloth), 1)
    }

    /// The same for several cloths, none of which is larger than an extent.
    pub fn workgroups_of(&self, most: &Extent, cloths: u32) -> [u32; 3] {
        let sides = |half_x: bool, half_y: bool| {
            let [w, h] = most.sides;
            let (w, h) = (if half_x { w.div_ceil(2) } else { w }, if half_y { h.div_ceil(2) } else { h });
            [w.div_ceil(16), h.div_ceil(4), cloths * most.grids]
        };
        let list = |count: usize| {
            let [x, y, _] = list(count);
            [x, y, cloths]
        };
        match self.threads {
            Threads::Particles => list(most.particles),
            Threads::Rings => list(most.rings),
            Threads::Vertices => list(most.surface[0]),
            Threads::Patches => list(most.surface[1]),
            Threads::Texels => sides(false, false),
            Threads::Quarter => sides(true, true),
            Threads::One => [1; 3],
            Threads::Cloth => [cloths, 1, 1],
            Threads::Layers => [1, 1, cloths],
            Threads::Grids => [1, 1, cloths * most.grids],
            Threads::Half(columns) => sides(columns, !columns),
            Threads::Nodes(level) => {
                let nodes = |side| (0..level).fold(side, |side, _| crate::levels::nodes(side));
                let [x, y] = most.sides.map(|side| (nodes(side) + 1).div_ceil(crate::levels::NODE_TILE as u32));
                [x, y, cloths * most.grids]
            }
            Threads::Tiles(shape) => {
                let [x, y] = shape.tiles(most.sides);
                [x, y, cloths * most.grids]
            }
        }
    }
}

/// The sizes of a cloth that dispatches depend on, or the largest of several cloths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    pub particles: usize,
    pub rings: usize,
    pub grids: u32,
    /// The most columns and the most rows of a grid.
    pub sides: [u32; 2],
    /// Vertices and patches of the surface of a body that it is worn on.
    pub surface: [usize; 2],
}

impl Extent {
    /// That of a cloth.
    pub fn of(cloth: &Cloth) -> Self {
        let each = cloth.grids().iter().map(|g| [g.width, g.height]);
        let sides = each.fold([0; 2], |most, side| [most[0].max(side[0]), most[1].max(side[1])]);
        let surface = cloth.body().map_or([0; 2], |s| [s.vertices(), s.patches()]);
        Extent { particles: cloth.len(), rings: cloth.ring_count(), grids: cloth.grids().len() as u32, sides, surface }
    }

    /// Room for both.
    pub fn with(self, other: Extent) -> Self {
        Extent {
            particles: self.particles.max(other.particles),
            rings: self.rings.max(other.rings),
            grids: self.grids.max(other.grids),
            sides: [0, 1].map(|d| self.sides[d].max(other.sides[d])),
            surface: [0, 1].map(|d| self.surface[d].max(other.surface[d])),
        }
    }
}

#[cfg(test)]
mod facts_tests;
#[cfg(test)]
mod loops_tests;
#[cfg(test)]
#[path = "shaders_tests.rs"]
mod tests;
