//! Twin of shaders/faces.wgsl: the features of each cell.
//!
//! Corners are counted around a cell from the upper left one downwards. Bits 0 and 1: its triangles; 2 to 5 and 6 to 9: their corners; 10 to 15: edges
//! that it owns, four around it from the one between corners 0 and 1, then the two across; 16 to 19: vertices that it owns. Every feature belongs
//! to one cell of its grid.

use super::{Lists, NOBODY, Patch};
use crate::number::real::Real;

/// Corners of the six edges of a cell.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]];

/// The corners of the triangles of a cell: those of two, of one, or none.
fn triangles<T: Real>(lists: &Lists<T>, patch: &Patch<T>, [i, j]: [i64; 2], holes: &[u32]) -> Vec<Option<[usize; 3]>> {
    if i < 0 || j < 0 || i + 1 >= patch.width as i64 || j + 1 >= patch.height as i64 {
        return Vec::new();
    }
    let corners = patch.corners([i as usize, j as usize]);
    let points = corners.map(|k| lists.point(k));
    let there = points.map(|point| point != NOBODY);
    let all: &[[usize; 3]] = match there {
        [true, true, true, true] => &[[0, 1, 2], [0, 2, 3]],
        [false, true, true, true] => &[[1, 2, 3]],
        [true, false, true, true] => &[[0, 2, 3]],
        [true, true, false, true] => &[[0, 1, 3]],
        [true, true, true, false] => &[[0, 1, 2]],
        _ => &[],
    };
    let removed = holes.get(corners[0]).copied().unwrap_or(0);
    let drawn = |(n, [a, b, c]): (usize, &[usize; 3])| {
        // A triangle with two corners at one point has no area; its edges are those of neighbours.
        let flat = points[*a] == points[*b] || points[*b] == points[*c] || points[*a] == points[*c];
        (removed >> n & 1 == 0 && !flat).then_some([*a, *b, *c])
    };
    all.iter().enumerate().map(drawn).collect()
}

/// Whether a cell has a triangle with some corners.
fn has<T: Real>(lists: &Lists<T>, patch: &Patch<T>, at: [i64; 2], holes: &[u32], corners: &[usize]) -> bool {
    let all = triangles(lists, patch, at, holes);
    all.iter().flatten().any(|triangle| corners.iter().all(|corner| triangle.contains(corner)))
}

/// The features of a cell. `holes`: triangles that are cut away, by particle of all cloths.
pub fn features<T: Real>(lists: &Lists<T>, patch: &Patch<T>, at: [usize; 2], holes: &[u32]) -> u32 {
    let [i, j] = at.map(|x| x as i64);
    let mut bits = 0;
    for (n, triangle) in triangles(lists, patch, [i, j], holes).into_iter().enumerate() {
        let Some(triangle) = triangle else { continue };
        bits |= 1 << n;
        triangle.iter().for_each(|corner| bits |= 1 << (2 + 4 * n + corner));
    }
    let own = |corners: &[usize]| has(lists, patch, [i, j], holes, corners);
    let before = |di: i64, dj: i64, corners: &[usize]| has(lists, patch, [i - di, j - dj], holes, corners);
    for (n, edge) in EDGES.iter().enumerate() {
        // Those to the left and above belong to the cell there, if it has them.
        let elsewhere = match n {
            0 => before(1, 0, &[2, 3]),
            3 => before(0, 1, &[1, 2]),
            _ => false,
        };
        bits |= u32::from(own(edge) && !elsewhere) << (10 + n);
    }
    let elsewhere = [
        before(1, 1, &[2]) || before(1, 0, &[3]) || before(0, 1, &[1]),
        before(1, 0, &[2]) || before(1, -1, &[3]),
        false,
        before(0, 1, &[2]),
    ];
    for (corner, elsewhere) in elsewhere.into_iter().enumerate() {
        bits |= u32::from(own(&[corner]) && !elsewhere) << (16 + corner);
    }
    bits
}
