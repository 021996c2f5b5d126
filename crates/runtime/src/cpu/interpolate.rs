//! Displacements of a coarser grid, carried to the one below it, as shaders/part/level.wgsl does.

use crate::levels::links::ALL;
use crate::levels::{around, span};
use crate::number::real::Real;

/// How far the nodes of a level have moved.
pub struct Field<'a, T> {
    /// The three coordinates, row by row.
    pub moved: [Vec<T>; 3],
    /// Nodes in a row.
    pub nodes: usize,
    /// Particles that do not follow all nodes around them.
    pub parted: &'a Parted,
}

/// The particles of a grid that a cut has parted from nodes around them: for each row that has any, columns and the nodes
/// that are left, as [`crate::levels::links`] has them.
#[derive(Default)]
pub struct Parted {
    rows: Vec<Vec<(usize, u8)>>,
}

impl Parted {
    /// From the links of a grid of `width` columns.
    pub fn new(links: &[u8], width: usize) -> Self {
        if links.iter().all(|l| *l == ALL) {
            return Parted::default();
        }
        let row = |row: &[u8]| row.iter().copied().enumerate().filter(|(_, l)| *l != ALL).collect();
        Parted { rows: links.chunks(width).map(row).collect() }
    }
}

/// For every row of a finer grid the displacement of its even and odd columns, by means of the nodes around that they
/// follow.
pub fn interpolate<T: Real>(
    [width, height]: [usize; 2],
    half: usize,
    field: &Field<T>,
    mut each: impl FnMut(usize, &[Vec<T>; 3], &[Vec<T>; 3]),
) {
    let Field { moved, nodes, parted } = field;
    let (nodes, half_of) = (*nodes, T::of(0.5));
    let mut even = [0; 3].map(|_| vec![T::of(0.0); half]);
    let mut odd = even.clone();
    for j in 0..height {
        let (a, b) = span(j, height);
        for c in 0..3 {
            let (above, below) = (&moved[c][a * nodes..(a + 1) * nodes], &moved[c][b * nodes..(b + 1) * nodes]);
            let means = &mut even[c][..nodes];
            for ((mean, a), b) in means.iter_mut().zip(above).zip(below) {
                *mean = half_of * (*a + *b);
            }
            let between = odd[c].iter_mut().zip(means.windows(2)).take((width - 1) / 2);
            between.for_each(|(x, ends)| *x = half_of * (ends[0] + ends[1]));
            if width % 2 == 0 {
                // The last column is a node, although it is odd.
                odd[c][width / 2 - 1] = means[nodes - 1];
                means[nodes - 1] = T::of(0.0);
            }
        }
        for &(i, follows) in parted.rows.get(j).map_or(&[][..], Vec::as_slice) {
            let to = if i % 2 == 0 { &mut even } else { &mut odd };
            let share = T::of(1.0) / T::of(f64::from(follows.count_ones().max(1)));
            for c in 0..3 {
                let mut sum = T::of(0.0);
                for (n, (x, y)) in around(i, j, width, height).into_iter().enumerate() {
                    sum = sum + if follows >> n & 1 == 1 { moved[c][y * nodes + x] } else { T::of(0.0) };
                }
                to[c][i / 2] = sum * share;
            }
        }
        each(j, &even, &odd);
    }
}

/// Adds displacements to a row of particles that are not pinned.
pub fn add<T: Real>(row: &mut [T], w: &[T], half: usize, even: &[Vec<T>; 3], odd: &[Vec<T>; 3], share: T) {
    for c in 0..3 {
        for (side, from) in [even, odd].into_iter().enumerate() {
            let row = &mut row[(c * 2 + side) * half..][..half];
            let w = &w[side * half..][..half];
            for ((x, w), more) in row.iter_mut().zip(w).zip(&from[c]) {
                *x = *x + if *w > T::of(0.0) { *more * share } else { T::of(0.0) };
            }
        }
    }
}
