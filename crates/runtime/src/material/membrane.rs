//! Triangles of constant strain that stand for an elastic membrane.

use super::cell::{Cell, P2, cross, sub};

/// The triangles of a cell, divided along its shorter diagonal. `warp` is the direction of the warp in the cell's plane,
/// of length 1.
pub fn triangles(cell: &Cell, warp: P2) -> [[f32; 4]; 2] {
    let weft = [warp[1], -warp[0]];
    let square = |a: usize, b: usize| {
        let d = sub(cell.at[b], cell.at[a]);
        d[0] * d[0] + d[1] * d[1]
    };
    let up = match cell.there {
        [true, true, true, true] => square(1, 2) < square(0, 3),
        [first, _, _, last] => !(first && last),
    };
    let ring = if up { [1, 3, 2, 0] } else { [0, 1, 3, 2] };
    [[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]].map(|corners| {
        if corners.iter().any(|k| !cell.there[*k]) {
            return [0.0; 4];
        }
        let side = |k: usize| {
            let d = sub(cell.at[corners[k]], cell.at[corners[0]]);
            [d[0] * weft[0] + d[1] * weft[1], d[0] * warp[0] + d[1] * warp[1]]
        };
        let (e, h) = (side(1), side(2));
        let det = cross(e, h);
        if det.abs() < 1e-6 * (e[0] * e[0] + e[1] * e[1]).max(h[0] * h[0] + h[1] * h[1]) {
            return [0.0; 4];
        }
        // The warp may point either way.
        let way = if (det > 0.0) == up { -1.0 } else { 1.0 };
        [h[1] / det, -way * h[0] / det, -e[1] / det, way * e[0] / det].map(|x| x as f32)
    })
}

/// Area \[m^2\].
pub fn area(cell: &Cell) -> f64 {
    let around: Vec<P2> = cell.around().map(|k| cell.at[k]).collect();
    let next = around.iter().cycle().skip(1);
    0.5 * around.iter().zip(next).map(|(a, b)| cross(*a, *b)).sum::<f64>().abs()
}
