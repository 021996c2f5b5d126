//! What shaders bind.

use bytemuck::cast_slice;

use crate::cloth::{Cloth, Compliance, Rest, Tethers};
use crate::layout::{FAULT_BYTES, FrameRow, JobRow, LinkRow};

macro_rules! slots {
    ($($slot:ident $name:literal,)*) => {
        /// What can be bound. The number is the binding in every shader.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Slot { $($slot,)* }

        impl Slot {
            /// All of them.
            pub const ALL: &[Slot] = &[$(Slot::$slot,)*];

            pub fn name(self) -> &'static str {
                match self { $(Slot::$slot => $name,)* }
            }
        }
    };
}

slots! {
    Step "step",
    Grids "grids",
    Now "now",
    Before "before",
    Rest "rest",
    Starts "starts",
    Members "members",
    Solids "solids",
    Normals "normals",
    Field "field",
    Holes "holes",
    Action "action",
    Chosen "chosen",
    Candidates "candidates",
    Found "found",
    Partial "partial",
    Fastest "fastest",
    Soft "soft",
    Sums "sums",
    Tethers "tethers",
    Levels "levels",
    Nodes "nodes",
    Limits "limits",
    Faults "faults",
    Good "good",
    Weights "weights",
    Bends "bends",
    Moments "moments",
    Lost "lost",
    Cells "cells",
    Yielding "yielding",
    Frame "frame",
    Jobs "jobs",
    Strain "strain",
    Next "next",
    Passed "passed",
    Losing "losing",
    Summing "summing",
    Supports "supports",
    Holding "holding",
    Changes "changes",
    Mates "mates",
    Links "links",
    Ties "ties",
    Targets "targets",
    Bounds "bounds",
    Indices "indices",
    Tangents "tangents",
    Charts "charts",
}

impl Slot {
    /// The entries that each texel of a cloth has in a list that shaders only read: their number, their bytes together, and the list,
    /// whose texels begin at `first`. None for other slots, and where the cloth has no such list.
    pub fn texels(self, cloth: &Cloth, held: &Tethers, first: u32) -> Option<(usize, Vec<u8>)> {
        let list = |data: &[[f32; 4]]| cast_slice(data).to_vec();
        match self {
            Slot::Rest => {
                if let Rest::Image(rest) = cloth.rest() {
                    Some((16, list(rest)))
                } else {
                    None
                }
            }
            Slot::Soft => {
                if let Compliance::Image(soft) = &cloth.compliance {
                    Some((16, list(soft)))
                } else {
                    None
                }
            }
            Slot::Cells => cloth.membrane().map(|m| (32, list(&m.cells))),
            Slot::Weights => cloth.bending().map(|b| (16, list(&b.weights))),
            Slot::Bends => cloth.bending().map(|b| {
                let rows: Vec<_> = b.compliance.iter().zip(b.bounds(cloth)).map(|(c, bound)| [*c, bound]).collect();
                (8, cast_slice(&rows).to_vec())
            }),
            Slot::Tethers if held.per_particle > 0 => {
                let end = |a: &crate::Anchor| if a.exists() { a.particle + first } else { u32::MAX };
                let rows: Vec<_> = held.anchors.iter().map(|a| [end(a), a.distance.to_bits()]).collect();
                Some((8 * held.per_particle, cast_slice(&rows).to_vec()))
            }
            Slot::Targets => cloth.limits.as_ref().map(|limits| {
                let rows: Vec<_> =
                    cloth.positions().iter().zip(limits).map(|([x, y, z], l)| [*x, *y, *z, *l]).collect();
                (16, list(&rows))
            }),
            _ => None,
        }
    }

    /// Bytes of the buffer for a cloth.
    pub fn bytes(self, cloth: &Cloth, tethers: usize, colliders: usize) -> u64 {
        let (starts, members) = cloth.rings();
        let bytes = match self {
            Slot::Step => 64 + 16,
            Slot::Grids => cloth.grids().len() * 32,
            Slot::Now | Slot::Before | Slot::Rest | Slot::Normals | Slot::Field | Slot::Soft | Slot::Sums => {
                cloth.len() * 16
            }
            Slot::Tethers => cloth.len() * tethers * 8,
            Slot::Holes => cloth.len() * 4,
            Slot::Starts => starts.len() * 4,
            Slot::Members => members.len() * 4,
            Slot::Solids => colliders * 80,
            // Of which a pass of its own uses the first 16 bytes.
            Slot::Faults => FAULT_BYTES,
            Slot::Frame => size_of::<FrameRow>(),
            Slot::Jobs => size_of::<JobRow>(),
            Slot::Good | Slot::Weights | Slot::Moments | Slot::Lost => cloth.len() * 16,
            Slot::Next | Slot::Passed | Slot::Losing | Slot::Summing => cloth.len() * 16,
            Slot::Targets => cloth.len() * 16,
            Slot::Bends => cloth.len() * 8,
            Slot::Cells => cloth.len() * 32,
            Slot::Yielding => 16,
            Slot::Levels => crate::levels::rows(cloth).0 * 16,
            Slot::Nodes => crate::levels::rows(cloth).1 * 32,
            Slot::Limits => crate::levels::rows(cloth).1 * 16,
            Slot::Links => (cloth.len() + crate::levels::rows(cloth).1) * size_of::<LinkRow>(),
            Slot::Ties => crate::levels::ties::rows(&crate::levels::ties::ties(cloth), |_, _| 0).len() * 16,
            Slot::Partial => cloth.len().div_ceil(64) * 4,
            Slot::Fastest | Slot::Strain => 4,
            // Made when they are asked for; no frame binds them.
            Slot::Action | Slot::Chosen | Slot::Candidates | Slot::Found => 0,
            Slot::Bounds | Slot::Indices | Slot::Tangents | Slot::Charts => 0,
            Slot::Supports | Slot::Holding | Slot::Changes | Slot::Mates => 0,
        };
        bytes as u64
    }
}
