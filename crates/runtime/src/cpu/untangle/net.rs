//! Edges, faces and neighbours of the points of a surface.

use std::collections::HashMap;
use std::ops::Range;

use crate::cpu::truncation::surface::Surface;
use crate::memory::Tally;

/// No face.
pub const NONE: u32 = u32::MAX;

/// The mesh of a [`Surface`]. Edges and faces are in the order of its cells.
pub struct Net {
    pub edges: Vec<[u32; 2]>,
    pub faces: Vec<[u32; 3]>,
    /// The faces at each edge, [`NONE`] where there is one only. Of an edge that three panels share, the first two.
    pub beside: Vec<[u32; 2]>,
    /// The first edge and the first face of each cell, and one past the last.
    firsts: Vec<[u32; 2]>,
    /// The first neighbour of each point, and one past the last.
    starts: Vec<u32>,
    /// A neighbour, and the edge to it.
    neighbours: Vec<[u32; 2]>,
}

impl Net {
    /// Takes time linear in the points.
    pub fn new(surface: &Surface) -> Self {
        let (mut edges, mut faces, mut firsts) = (Vec::new(), Vec::new(), vec![[0; 2]]);
        for cell in 0..surface.corners.len() {
            edges.extend_from_slice(surface.edges(cell));
            faces.extend_from_slice(surface.triangles(cell));
            firsts.push([edges.len() as u32, faces.len() as u32]);
        }
        let known: HashMap<[u32; 2], usize> = edges.iter().enumerate().map(|(n, edge)| (*edge, n)).collect();
        let mut beside = vec![[NONE; 2]; edges.len()];
        for (face, [a, b, c]) in faces.iter().enumerate() {
            for [p, q] in [[*a, *b], [*b, *c], [*a, *c]] {
                let Some(edge) = known.get(&[p.min(q), p.max(q)]) else { continue };
                if let Some(free) = beside[*edge].iter_mut().find(|slot| **slot == NONE) {
                    *free = face as u32;
                }
            }
        }
        let (starts, neighbours) = around(surface.count(), &edges);
        Net { edges, faces, beside, firsts, starts, neighbours }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.edges);
        tally.state(&self.faces);
        tally.state(&self.beside);
        tally.state(&self.firsts);
        tally.state(&self.starts);
        tally.state(&self.neighbours);
    }

    /// Numbers of the edges of a cell.
    pub fn edges_of(&self, cell: usize) -> Range<usize> {
        self.firsts[cell][0] as usize..self.firsts[cell + 1][0] as usize
    }

    /// Numbers of the faces of a cell.
    pub fn faces_of(&self, cell: usize) -> Range<usize> {
        self.firsts[cell][1] as usize..self.firsts[cell + 1][1] as usize
    }

    /// Neighbours of a point, each with the edge to it.
    pub fn around(&self, point: u32) -> &[[u32; 2]] {
        &self.neighbours[self.starts[point as usize] as usize..self.starts[point as usize + 1] as usize]
    }

    /// The faces at an edge, one or two.
    pub fn faces_at(&self, edge: usize) -> impl Iterator<Item = u32> {
        self.beside[edge].into_iter().filter(|face| *face != NONE)
    }
}

/// Neighbours of `count` points, by points, with the edge to each.
fn around(count: usize, edges: &[[u32; 2]]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut starts = vec![0u32; count + 1];
    edges.iter().flatten().for_each(|point| starts[*point as usize + 1] += 1);
    (1..=count).for_each(|n| starts[n] += starts[n - 1]);
    let mut ends = starts.clone();
    let mut neighbours = vec![[0; 2]; 2 * edges.len()];
    for (edge, [a, b]) in edges.iter().enumerate() {
        for (point, other) in [(*a, *b), (*b, *a)] {
            let end = &mut ends[point as usize];
            neighbours[*end as usize] = [other, edge as u32];
            *end += 1;
        }
    }
    (starts, neighbours)
}
