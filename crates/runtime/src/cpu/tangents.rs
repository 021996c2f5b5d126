//! Twin of shaders/tangents.wgsl: the direction in which u of the texture grows along the cloth.

use super::neighbours::View;
use super::normals::unit;
use super::rows::Threads;
use crate::number::real::{Real, V3, add, dot, scale, sub, with_w, xyz};

/// Writes the tangents of one grid, across its normals. `charts` are those of [`crate::cloth::Cloth::charts`].
pub fn run<T: Real>(
    threads: &Threads,
    view: View<T>,
    (normals, charts): (&[[T; 4]], &[[f32; 4]]),
    tangents: &mut [[T; 4]],
) {
    threads.chunks(tangents, view.width, |j, row| {
        for (i, tangent) in row.iter_mut().enumerate() {
            let k = j * view.width + i;
            *tangent = [T::of(0.0); 4];
            if view.now[k][3] >= T::of(0.0) {
                let (n, chart) = (xyz(normals[k]), charts[k].map(|x| T::of(x.into())));
                let [row, column] = steps(view, i, j);
                let t = add(scale(row, chart[0]), scale(column, chart[1]));
                let across = sub(t, scale(n, dot(n, t)));
                *tangent = with_w(xyz(unit(across)), chart[2]);
            }
        }
    });
}

/// The ways along the row and the column of a particle, per texel.
fn steps<T: Real>(view: View<T>, i: usize, j: usize) -> [V3<T>; 2] {
    let (w, height) = (view.width, view.now.len() / view.width);
    let k = j * w + i;
    let here = gone(view, i, j);
    let back = [i > 0 && !gone(view, i.max(1) - 1, j)[0], j > 0 && !gone(view, i, j.max(1) - 1)[1]];
    [along(view, k, 1, back[0], i + 1 < w && !here[0]), along(view, k, w, back[1], j + 1 < height && !here[1])]
}

/// The way from one neighbour in a line to the other. A neighbour that is not there, or behind a cut, does not count.
fn along<T: Real>(view: View<T>, k: usize, by: usize, back: bool, on: bool) -> V3<T> {
    let there = |k: usize| view.now[k][3] >= T::of(0.0);
    let (behind, ahead) = (back && there(k - by), on && there(k + by));
    let from = if behind { k - by } else { k };
    let to = if ahead { k + by } else { k };
    scale(sub(view.at(to), view.at(from)), T::of(if behind && ahead { 0.5 } else { 1.0 }))
}

/// Whether the edges of a texel to the right and down are gone: those at no triangle that is left.
fn gone<T: Real>(view: View<T>, i: usize, j: usize) -> [bool; 2] {
    let here = view.sides(Some(i), Some(j))[0];
    let left = view.sides(i.checked_sub(1), Some(j))[0];
    let above = view.sides(Some(i), j.checked_sub(1))[0];
    [here & 2 | above & 1, here & 1 | left & 2].map(|left| left == 0)
}
