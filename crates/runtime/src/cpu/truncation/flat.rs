//! Where cloth is so even that no two of its features that are near on the surface can come into contact.
//!
//! The nine points of a block are compared with a plane grid of parallelograms, seen along the normal of that plane. Features of such a grid
//! that share no point are at least as far apart as the least height of its triangles; each end of a way between two features is at most as
//! far off as the farthest point is. Heights above the plane only add to distances.

use super::Way;
use super::surface::Patch;
use crate::number::real::{add, cross, dot, scale, sub};

/// Of the least height of the triangles of a plane grid a little less, for rounding.
const HEIGHT_SHARE: f64 = 0.999;

/// Whether the features of the four cells around a texel that share no point are farther apart than twice `reach`, plus `floor` \[m\].
/// `at` has the way of a cell's point, NaN for gaps.
pub fn is_even(patch: &Patch, [i, j]: [usize; 2], floor: f64, at: impl Fn(usize) -> Way) -> bool {
    let (mut block, mut ways) = ([[0.0; 3]; 9], [[0.0; 3]; 9]);
    let mut reach = 0.0f64;
    for (n, to) in block.iter_mut().enumerate() {
        let cell = patch.first + (j + n / 3 - 1) * patch.width + i + n % 3 - 1;
        let way = at(cell);
        if !way.from[0].is_finite() {
            return false;
        }
        (*to, ways[n], reach) = (way.from, sub(way.to, way.from), reach.max(way.reach));
    }
    // The rest of each drift beside that of the middle point.
    let apart2 = ways.iter().map(|way| sub(*way, ways[4])).map(|way| dot(way, way)).fold(0.0f64, f64::max);
    let center = block[4];
    let right = scale(sub(block[5], block[3]), 0.5);
    let down = scale(sub(block[7], block[1]), 0.5);
    let normal = cross(right, down);
    let area2 = dot(normal, normal);
    let diagonal = add(right, down);
    let longest2 = dot(right, right).max(dot(down, down)).max(dot(diagonal, diagonal));
    // Comparisons with NaN are false.
    let mut off2 = 0.0f64;
    for (n, p) in block.iter().enumerate() {
        let (m, k) = (n as f64 % 3.0 - 1.0, (n / 3) as f64 - 1.0);
        let off = sub(sub(*p, center), add(scale(right, m), scale(down, k)));
        let above = dot(off, normal);
        off2 = off2.max(dot(off, off) - above * above / area2);
    }
    let room = HEIGHT_SHARE * (area2 / longest2).sqrt() - 2.0 * (reach + apart2.sqrt()) - floor;
    room > 0.0 && 4.0 * off2 < room * room
}

/// The texel in whose block two cells lie that are at most one column and one row apart; none in grids of less than three rows or columns.
pub fn shared(patch: &Patch, cell: usize, [right, down]: [isize; 2]) -> Option<[usize; 2]> {
    let (i, j) = ((cell - patch.first) % patch.width, (cell - patch.first) / patch.width);
    let along = |at: usize, step: isize, count: usize| {
        // The line of texels between both, or one beside a single one.
        let line = if step < 0 { at } else { at + 1 };
        let line = if step == 0 { line.min(count.saturating_sub(2)) } else { line };
        (count > 2 && (1..count - 1).contains(&line)).then_some(line)
    };
    (right.abs() <= 1 && down.abs() <= 1).then_some(())?;
    Some([along(i, right, patch.width)?, along(j, down, patch.height)?])
}
