//! What shaders bind.

use crate::cloth::Cloth;
use crate::layout::{FAULT_BYTES, FrameRow, JobRow, LinkRow};

/// What can be bound. The number is the binding in every shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    Step = 0,
    Grids,
    Now,
    Before,
    Rest,
    Starts,
    Members,
    Solids,
    Normals,
    Field,
    Holes,
    Action,
    Chosen,
    Candidates,
    Found,
    Partial,
    Fastest,
    Soft,
    Sums,
    Tethers,
    Levels,
    Nodes,
    Limits,
    Faults,
    Good,
    Weights,
    Bends,
    Moments,
    Lost,
    Cells,
    Yielding,
    Frame,
    Jobs,
    Strain,
    Next,
    Passed,
    Losing,
    Summing,
    Supports,
    Holding,
    Changes,
    Mates,
    Links,
    Ties,
}

impl Slot {
    pub fn name(self) -> &'static str {
        const NAMES: [&str; 44] = [
            "step",
            "grids",
            "now",
            "before",
            "rest",
            "starts",
            "members",
            "solids",
            "normals",
            "field",
            "holes",
            "action",
            "chosen",
            "candidates",
            "found",
            "partial",
            "fastest",
            "soft",
            "sums",
            "tethers",
            "levels",
            "nodes",
            "limits",
            "faults",
            "good",
            "weights",
            "bends",
            "moments",
            "lost",
            "cells",
            "yielding",
            "frame",
            "jobs",
            "strain",
            "next",
            "passed",
            "losing",
            "summing",
            "supports",
            "holding",
            "changes",
            "mates",
            "links",
            "ties",
        ];
        NAMES[self as usize]
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
            // Made for one action; no frame binds them.
            Slot::Action | Slot::Chosen | Slot::Candidates | Slot::Found => 0,
            Slot::Supports | Slot::Holding | Slot::Changes | Slot::Mates => 0,
        };
        bytes as u64
    }
}
