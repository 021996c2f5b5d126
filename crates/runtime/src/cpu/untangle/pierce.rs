//! Finds the edges that pierce faces, by exact signs.

use robust::{Coord3D, orient3d};

use super::net::Net;
use crate::cpu::truncation::boxes::{Bound, Boxes};
use crate::cpu::truncation::spread::Spread;
use crate::cpu::truncation::surface::Surface;
use crate::memory::Tally;
use crate::number::real::{V3, cross, dot, scale, sub};

/// An edge that pierces a face, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    pub edge: u32,
    pub face: u32,
    /// Which end of the edge, 0 or 1, is in front of the face, where its corners turn counter-clockwise.
    pub front: usize,
}

/// Two cells beside each other do not cross if the cosines of all angles between their normals are larger than this.
const ALIKE: f32 = 0.5;

/// Boxes around cells and features.
pub struct Finder {
    boxes: Boxes,
    edges: Vec<Bound>,
    faces: Vec<Bound>,
    /// The unit normal of each face.
    normals: Vec<V3<f32>>,
    /// Whether cells beside each other are compared even if their normals are alike.
    pub thorough: bool,
}

impl Finder {
    /// That of a surface.
    pub fn new(surface: &Surface) -> Self {
        let mut boxes = Boxes::new(surface);
        // No part is left out as even.
        boxes.spreads.fill(Spread::WIDE);
        Finder { boxes, edges: Vec::new(), faces: Vec::new(), normals: Vec::new(), thorough: false }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.boxes.bounds);
        tally.state(&self.boxes.spreads);
        tally.state(&self.edges);
        tally.state(&self.faces);
        tally.state(&self.normals);
    }

    /// All edges that pierce faces with points at `at` \[m\], which are f32 values, always in the same order. An edge with an end that is not finite
    /// pierces nothing.
    pub fn find(&mut self, surface: &Surface, net: &Net, at: &[V3<f64>]) -> Vec<Hit> {
        self.bound(surface, net, at);
        let mut hits = Vec::new();
        self.boxes.pairs(|pair| {
            let beside = pair.apart.is_some_and(|[right, down]| right.abs() <= 1 && down.abs() <= 1);
            let [a, b] = pair.cells.map(|cell| net.faces_of(cell));
            if !beside || self.thorough || !are_alike(&self.normals, a.chain(b)) {
                self.compare(net, at, pair.cells, &mut hits);
            }
        });
        hits.sort_unstable_by_key(|hit| (hit.edge, hit.face));
        hits
    }

    /// The same in and between some cells, in ascending order and without duplicates; the points of others may be anywhere. Compares all features.
    pub fn find_among(&mut self, net: &Net, at: &[V3<f64>], cells: &[u32]) -> Vec<Hit> {
        self.edges.resize(net.edges.len(), Bound::NONE);
        self.faces.resize(net.faces.len(), Bound::NONE);
        for cell in cells.iter().map(|cell| *cell as usize) {
            net.edges_of(cell).for_each(|edge| self.edges[edge] = around(at, &net.edges[edge]));
            net.faces_of(cell).for_each(|face| self.faces[face] = around(at, &net.faces[face]));
            self.bound_cell(net, cell);
        }
        // From the left to the right: each cell meets those that begin before it ends.
        let bounds = &self.boxes.bounds;
        let mut order: Vec<usize> = cells.iter().map(|cell| *cell as usize).collect();
        order.sort_by(|a, b| bounds[*a].low[0].total_cmp(&bounds[*b].low[0]));
        let mut hits = Vec::new();
        for (n, a) in order.iter().enumerate() {
            let beside = order[n..].iter().take_while(|b| bounds[**b].low[0] <= bounds[*a].high[0]);
            for b in beside.filter(|b| bounds[*a].meets(&bounds[**b])) {
                self.compare(net, at, [*a, *b], &mut hits);
            }
        }
        hits.sort_unstable_by_key(|hit| (hit.edge, hit.face));
        hits
    }

    /// Adds the edges of two cells that pierce faces of the other one, or of one cell that pierce its own.
    fn compare(&self, net: &Net, at: &[V3<f64>], [a, b]: [usize; 2], hits: &mut Vec<Hit>) {
        let Finder { boxes, edges, faces, .. } = self;
        for (one, other) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
            for edge in net.edges_of(one).filter(|edge| edges[*edge].meets(&boxes.bounds[other])) {
                let ends = net.edges[edge];
                for face in net.faces_of(other).filter(|face| edges[edge].meets(&faces[*face])) {
                    let corners = &net.faces[face];
                    if corners.contains(&ends[0]) || corners.contains(&ends[1]) {
                        continue;
                    }
                    if let Some(front) = pierces(ends.map(|k| at[k as usize]), corners.map(|k| at[k as usize])) {
                        hits.push(Hit { edge: edge as u32, face: face as u32, front });
                    }
                }
            }
        }
    }

    /// The box of a cell, from those of its faces.
    fn bound_cell(&mut self, net: &Net, cell: usize) {
        let faces = self.faces[net.faces_of(cell)].iter();
        self.boxes.bounds[cell] = faces.fold(Bound::NONE, |bound, face| bound.with(face));
    }

    /// Makes all boxes, and normals.
    fn bound(&mut self, surface: &Surface, net: &Net, at: &[V3<f64>]) {
        self.edges.clear();
        self.edges.extend(net.edges.iter().map(|ends| around(at, ends)));
        self.faces.clear();
        self.faces.extend(net.faces.iter().map(|corners| around(at, corners)));
        self.normals.clear();
        self.normals.extend(net.faces.iter().map(|corners| {
            let [a, b, c] = corners.map(|k| at[k as usize]);
            let area = cross(sub(b, a), sub(c, a)).map(|x| x as f32);
            scale(area, 1.0 / dot(area, area).sqrt())
        }));
        for cell in 0..surface.corners.len() {
            self.bound_cell(net, cell);
        }
        self.boxes.refit();
    }
}

/// Whether the normals of some faces are nearly parallel. Comparisons with NaN are false.
fn are_alike(normals: &[V3<f32>], faces: impl Iterator<Item = usize> + Clone) -> bool {
    faces
        .clone()
        .enumerate()
        .all(|(n, one)| faces.clone().skip(n + 1).all(|other| dot(normals[one], normals[other]) > ALIKE))
}

/// The box around some points.
fn around(at: &[V3<f64>], points: &[u32]) -> Bound {
    points.iter().fold(Bound::NONE, |bound, point| {
        let p = at[*point as usize].map(|x| x as f32);
        bound.with(&Bound { low: p, high: p })
    })
}

/// Which end of an edge that pierces a triangle is in front of it; none if it does not pierce it. A point in the plane of the triangle counts
/// as one in front.
pub fn pierces([p, q]: [V3<f64>; 2], [a, b, c]: [V3<f64>; 3]) -> Option<usize> {
    if !p.iter().chain(&q).chain(&a).chain(&b).chain(&c).all(|x| x.is_finite()) {
        return None;
    }
    let point = |p: V3<f64>| Coord3D { x: p[0], y: p[1], z: p[2] };
    // Positive below a triangle that turns counter-clockwise seen from above.
    let side = |a, b, c, d| -orient3d(point(a), point(b), point(c), point(d));
    let front = [p, q].map(|end| side(a, b, c, end) >= 0.0);
    if front[0] == front[1] {
        return None;
    }
    let around = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    let both = around.iter().any(|s| *s > 0.0) && around.iter().any(|s| *s < 0.0);
    (!both).then_some(if front[0] { 0 } else { 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_pierces_a_triangle_between_its_corners_only() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let (above, below) = ([0.2, 0.2, 1.0], [0.2, 0.2, -1.0]);
        assert_eq!(pierces([above, below], triangle), Some(0), "its corners turn counter-clockwise seen from above");
        assert_eq!(pierces([below, above], triangle), Some(1));
        let beside = [[0.9, 0.9, 1.0], [0.9, 0.9, -1.0]];
        assert_eq!(pierces(beside, triangle), None);
        assert_eq!(pierces([above, [0.2, 0.2, 0.5]], triangle), None);
        assert_eq!(pierces([above, [f64::NAN; 3]], triangle), None);
    }
}
