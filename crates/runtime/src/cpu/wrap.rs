//! Twin of shaders/wrap.wgsl: the vertices of a mesh that is bound to the cloth.

use gimage_bundle::Frame;

use super::rows::Threads;
use crate::layout::{BoundRow, JumpRow, RenderVertex};
use crate::number::real::xyz;

/// The triangle of a vertex that is not bound.
pub const UNBOUND: u32 = u32::MAX;

/// The cloth as the pass reads it: positions now and one step before, normals, and how far from those before to those now.
#[derive(Clone, Copy)]
pub struct Sheet<'a> {
    pub now: &'a [[f32; 4]],
    pub before: &'a [[f32; 4]],
    pub normals: &'a [[f32; 4]],
    pub fraction: f32,
}

/// How far the vertices would have jumped as the cloth changed its level, a row per vertex, and the share of that which is left.
#[derive(Clone, Copy)]
pub struct Jumps<'a> {
    pub rows: &'a [JumpRow],
    pub share: f32,
}

impl Sheet<'_> {
    fn at(&self, k: u32) -> [f32; 3] {
        let [n, b] = [self.now, self.before].map(|list| xyz(list[k as usize]));
        if self.fraction == 1.0 { n } else { std::array::from_fn(|c| b[c] + (n[c] - b[c]) * self.fraction) }
    }

    /// The frame of a vertex that is bound, and the corners of its triangle.
    pub fn frame(&self, row: &BoundRow) -> (Frame, [[f32; 3]; 3]) {
        let corners = row.corners.map(|k| self.at(k));
        let normals = row.corners.map(|k| xyz(self.normals[k as usize]));
        (Frame::new(corners, normals, row.weights), corners)
    }
}

/// Vertices that a thread moves at a time.
const CHUNK: usize = 1024;

/// Moves all vertices. The corners of every bound one must be particles of the sheet.
pub fn run(threads: &Threads, sheet: Sheet, bound: &[BoundRow], jumps: Option<Jumps>, out: &mut [RenderVertex]) {
    threads.chunks(out, CHUNK, |chunk, vertices| {
        let first = chunk * CHUNK;
        for (n, (vertex, row)) in (first..).zip(vertices.iter_mut().zip(&bound[first..])) {
            *vertex = moved(&sheet, row, jumps.map(|jumps| (&jumps.rows[n], jumps.share)));
        }
    });
}

/// One vertex.
fn moved(sheet: &Sheet, row: &BoundRow, jump: Option<(&JumpRow, f32)>) -> RenderVertex {
    let (normal, tangent, sign) = (xyz(row.normal), xyz(row.tangent), row.tangent[3]);
    if row.corners[0] == UNBOUND {
        let ([x, y, z], [nx, ny, nz]) = (row.offset, normal);
        return RenderVertex { position: [x, y, z, 1.0], normal: [nx, ny, nz, 0.0], tangent: row.tangent };
    }
    let (frame, corners) = sheet.frame(row);
    let turn = |own: [f32; 3], jump: [f32; 4], share: f32| {
        let v = frame.outward([0, 1, 2].map(|c| own[c] + jump[c] * share));
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        if length > 0.0 { v.map(|x| x * (1.0 / length)) } else { [0.0; 3] }
    };
    let (offset, n, t) = match jump {
        None => (row.offset, frame.outward(normal), frame.outward(tangent)),
        Some((jump, share)) => {
            let offset = [0, 1, 2].map(|c| row.offset[c] + jump.position[c] * share);
            (offset, turn(normal, jump.normal, share), turn(tangent, jump.tangent, share))
        }
    };
    let [x, y, z] = frame.place(corners, row.weights, offset);
    RenderVertex { position: [x, y, z, 1.0], normal: [n[0], n[1], n[2], 0.0], tangent: [t[0], t[1], t[2], sign] }
}
