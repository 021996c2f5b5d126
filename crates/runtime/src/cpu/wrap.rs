//! Twin of shaders/wrap.wgsl: the vertices of a mesh that is bound to the cloth.

use gimage_bundle::Frame;

use super::rows::Threads;
use crate::layout::{BoundRow, RenderVertex};

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

impl Sheet<'_> {
    fn at(&self, k: u32) -> [f32; 3] {
        let [n, b] = [self.now, self.before].map(|list| xyz(list[k as usize]));
        if self.fraction == 1.0 { n } else { std::array::from_fn(|c| b[c] + (n[c] - b[c]) * self.fraction) }
    }
}

fn xyz([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    [x, y, z]
}

/// Vertices that a thread moves at a time.
const CHUNK: usize = 1024;

/// Moves all vertices. The corners of every bound one must be particles of the sheet.
pub fn run(threads: &Threads, sheet: Sheet, bound: &[BoundRow], out: &mut [RenderVertex]) {
    threads.chunks(out, CHUNK, |chunk, vertices| {
        let first = chunk * CHUNK;
        for (vertex, row) in vertices.iter_mut().zip(&bound[first..]) {
            *vertex = moved(&sheet, row);
        }
    });
}

/// One vertex.
fn moved(sheet: &Sheet, row: &BoundRow) -> RenderVertex {
    let ([nx, ny, nz, _], [tx, ty, tz, sign]) = (row.normal, row.tangent);
    if row.corners[0] == UNBOUND {
        let [x, y, z] = row.offset;
        return RenderVertex { position: [x, y, z, 1.0], normal: [nx, ny, nz, 0.0], tangent: row.tangent };
    }
    let corners = row.corners.map(|k| sheet.at(k));
    let normals = row.corners.map(|k| xyz(sheet.normals[k as usize]));
    let frame = Frame::new(corners, normals, row.weights);
    let [x, y, z] = frame.place(corners, row.weights, row.offset);
    let (n, t) = (frame.outward([nx, ny, nz]), frame.outward([tx, ty, tz]));
    RenderVertex { position: [x, y, z, 1.0], normal: [n[0], n[1], n[2], 0.0], tangent: [t[0], t[1], t[2], sign] }
}
