//! Twin of shaders/part/laplacian.wgsl: weighted differences to the eight texels around, summed in the shader's order.

use crate::cpu::sheet::{Sheet, planes_ref};
use crate::number::lanes::Machine;
use crate::number::real::Real;

/// Weights of the springs right, down, down-right and up-right of a sheet, in the layout of [`Sheet::w`].
pub struct Weights<T> {
    lists: [Vec<T>; 4],
    /// Half a row of one coordinate.
    pub half: usize,
    /// Columns.
    pub width: usize,
    none: Vec<T>,
}

/// Three rows of a list of vectors in the layout of [`Sheet::now`], and the weights between them.
#[derive(Clone, Copy)]
struct Around<'a, T> {
    rows: [[&'a [T]; 3]; 3],
    /// Right, down, down-right, up-right of the row; down and down-right of the one above; up-right of the one below.
    weights: [&'a [T]; 7],
    half: usize,
}

impl<T: Real> Weights<T> {
    /// Those of a sheet by texels.
    pub fn new(sheet: &Sheet<T>, of: impl Fn(usize) -> [f32; 4]) -> Self {
        let list = |d: usize| sheet.list(T::of(0.0), |k| T::of(of(k)[d].into()));
        let none = vec![T::of(0.0); 2 * sheet.half];
        Weights { lists: [0, 1, 2, 3].map(list), half: sheet.half, width: sheet.width, none }
    }

    /// The lists of the four directions.
    pub fn lists(&self) -> &[Vec<T>; 4] {
        &self.lists
    }

    /// A weight by its place in a list.
    pub fn of(&self, single: usize, direction: usize) -> T {
        self.lists[direction][single]
    }

    /// Calls `each` with the place in a row and the Laplacian of `from` there, for all of row `j` of `height`. A place
    /// counts as in a row of [`Sheet::w`]; vectors reach past the last column, where they are 0.
    #[inline(always)]
    pub fn row<K: Machine<T>>(
        &self,
        k: K,
        (j, height): (usize, usize),
        from: &[T],
        mut each: impl FnMut(usize, [K::V; 3]),
        mut first: impl FnMut([T; 3]),
    ) {
        let Weights { half, width, .. } = *self;
        let around = self.around(j, height, from);
        first(around.first_column());
        for side in 0..2 {
            let count = if side == 1 { width / 2 } else { (width - 1) / 2 };
            for at in (0..count).step_by(K::WIDE) {
                each(side * half + at + 1 - side, around.lanes(k, side, at));
            }
        }
    }

    fn around<'a>(&'a self, j: usize, height: usize, from: &'a [T]) -> Around<'a, T> {
        let half = self.half;
        let row = |j: usize| planes_ref(&from[j * 6 * half..(j + 1) * 6 * half], half);
        let of = |d: usize, j: usize| &self.lists[d][j * 2 * half..(j + 1) * 2 * half];
        let none = &self.none[..];
        let (above, below) = (j.saturating_sub(1), (j + 1).min(height - 1));
        let (up, up_left) = if j > 0 { (of(1, above), of(2, above)) } else { (none, none) };
        let down_left = if j + 1 < height { of(3, below) } else { none };
        Around {
            rows: [row(above), row(j), row(below)],
            weights: [of(0, j), of(1, j), of(2, j), of(3, j), up, up_left, down_left],
            half,
        }
    }
}

impl<T: Real> Around<'_, T> {
    /// Odd columns from `2 at + 1` on (side 1), or even ones from `2 at + 2` on (side 0): in the list of the other side
    /// `at` is to the left and `at + 1` to the right.
    #[inline(always)]
    fn lanes<K: Machine<T>>(&self, k: K, side: usize, at: usize) -> [K::V; 3] {
        let here = side * self.half + at + 1 - side;
        let left = (1 - side) * self.half + at;
        let right = left + 1;
        let [w_right, w_down, w_dr, w_ur, w_up, w_ul, w_dl] = self.weights;
        let p = self.place(k, 1, here);
        let sum = [k.splat(T::of(0.0)); 3];
        let sum = self.more(k, sum, p, (1, right), k.load(w_right, here));
        let sum = self.more(k, sum, p, (1, left), k.load(w_right, left));
        let sum = self.more(k, sum, p, (2, here), k.load(w_down, here));
        let sum = self.more(k, sum, p, (0, here), k.load(w_up, here));
        let sum = self.more(k, sum, p, (2, right), k.load(w_dr, here));
        let sum = self.more(k, sum, p, (0, left), k.load(w_ul, left));
        let sum = self.more(k, sum, p, (0, right), k.load(w_ur, here));
        self.more(k, sum, p, (2, left), k.load(w_dl, left))
    }

    #[inline(always)]
    fn place<K: Machine<T>>(&self, k: K, row: usize, at: usize) -> [K::V; 3] {
        let [x, y, z] = self.rows[row];
        [k.load(x, at), k.load(y, at), k.load(z, at)]
    }

    /// Adds a weighted difference to a row's place.
    #[inline(always)]
    fn more<K: Machine<T>>(&self, k: K, sum: [K::V; 3], p: [K::V; 3], (row, at): (usize, usize), w: K::V) -> [K::V; 3] {
        let q = self.place(k, row, at);
        [
            k.add(sum[0], k.mul(k.sub(q[0], p[0]), w)),
            k.add(sum[1], k.mul(k.sub(q[1], p[1]), w)),
            k.add(sum[2], k.mul(k.sub(q[2], p[2]), w)),
        ]
    }

    /// Column 0, which has nothing to its left.
    #[inline(always)]
    fn first_column(&self) -> [T; 3] {
        let [w_right, w_down, w_dr, w_ur, w_up, _, _] = self.weights;
        let half = self.half;
        let edges = [(1, half, w_right[0]), (2, 0, w_down[0]), (0, 0, w_up[0]), (2, half, w_dr[0]), (0, half, w_ur[0])];
        let mut sum = [T::of(0.0); 3];
        for (row, place, w) in edges {
            for (c, sum) in sum.iter_mut().enumerate() {
                *sum = *sum + (self.rows[row][c][place] - self.rows[1][c][0]) * w;
            }
        }
        sum
    }
}
