//! Twin of shaders/jump.wgsl: how far the vertices of a bound mesh would jump as the cloth changes its level.

use super::wrap::{Sheet, UNBOUND};
use crate::layout::{BoundRow, JumpRow, RenderVertex};
use crate::number::real::{V3, dot, sub, with_w, xyz};

/// The way from where the vertices are on the new level to `old`, where they were on the last one, in their frames on the new one; 0 for
/// vertices that are not bound.
pub fn run(sheet: Sheet, bound: &[BoundRow], old: &[RenderVertex]) -> Vec<JumpRow> {
    let jump = |(row, old): (&BoundRow, &RenderVertex)| {
        if row.corners[0] == UNBOUND {
            return JumpRow::default();
        }
        let (frame, corners) = sheet.frame(row);
        let inward = |v: V3<f32>| [dot(frame.tangent, v), dot(frame.bitangent, v), dot(frame.normal, v)];
        let way = inward(sub(xyz(old.position), frame.place(corners, row.weights, row.offset)));
        let turn = |old: [f32; 4], own: [f32; 4]| with_w(sub(inward(xyz(old)), xyz(own)), 0.0);
        let (normal, tangent) = (turn(old.normal, row.normal), turn(old.tangent, row.tangent));
        JumpRow { position: with_w(way, 0.0), normal, tangent }
    };
    bound.iter().zip(old).map(jump).collect()
}
