//! A grid in planes: coordinates apart from one another, even columns apart from odd ones.
//!
//! A row is `[x even, x odd, y even, y odd, z even, z odd]`, each `half` numbers long, so that the springs of every colour
//! join two contiguous lists: right-even is even with odd, right-odd is odd with even from the second on, and so on.
//! Columns past the end are particles that cannot move.

use std::sync::Arc;

use crate::cloth::Grid;
use crate::number::aligned::Aligned;
use crate::number::lanes::LANES;
use crate::number::real::{Real, V3};

/// A number for each particle of a sheet, or one for all.
#[derive(Clone, Debug)]
pub enum Values<T> {
    /// The same everywhere.
    Constant(T),
    /// In the layout of [`Sheet::w`].
    List(Arc<Vec<T>>),
}

impl<T> Values<T> {
    /// The numbers, where they are not the same.
    pub fn list(&self) -> &[T] {
        if let Values::List(list) = self { list } else { &[] }
    }
}

/// A grid of particles.
#[derive(Clone, Debug)]
pub struct Sheet<T: Real> {
    pub width: usize,
    pub height: usize,
    /// Numbers in half a row of one coordinate: whole blocks.
    pub half: usize,
    pub now: Aligned<T>,
    pub before: Aligned<T>,
    /// Remainders too small for the positions to take up; as `now` where they are kept, else empty.
    pub lost: Aligned<T>,
    /// Inverse mass \[1/kg\], 0 for what does not move. Rows of `[even, odd]`.
    pub w: Aligned<T>,
    /// For every row the inverse mass of all its particles, or 0 where they differ or one is pinned.
    pub alike: Vec<T>,
}

/// Numbers in half a row of one coordinate: whole blocks of pairs, the odd ones from one further on.
pub fn half_row(width: usize) -> usize {
    let blocks = |pairs: usize| pairs.div_ceil(LANES) * LANES;
    blocks(width.div_ceil(2)).max(1 + blocks((width - 1) / 2)).next_multiple_of(LANES)
}

/// The coordinates of a row, `[even, odd]` each.
#[inline(always)]
pub fn planes<T>(row: &mut [T], half: usize) -> [&mut [T]; 3] {
    let (x, rest) = row.split_at_mut(2 * half);
    let (y, z) = rest.split_at_mut(2 * half);
    [x, y, &mut z[..2 * half]]
}

/// Where in `[even, odd]` vectors of `wide` numbers start that hold all columns.
#[inline(always)]
pub fn columns(width: usize, half: usize, wide: usize) -> impl Iterator<Item = usize> {
    let even = (0..width.div_ceil(2)).step_by(wide);
    even.chain((half..half + width / 2).step_by(wide))
}

/// The same for reading.
#[inline(always)]
pub fn planes_ref<T>(row: &[T], half: usize) -> [&[T]; 3] {
    [&row[..2 * half], &row[2 * half..4 * half], &row[4 * half..6 * half]]
}

impl<T: Real> Sheet<T> {
    /// Room for a grid; everything 0.
    pub fn new(grid: &Grid) -> Self {
        let (width, height) = (grid.width as usize, grid.height as usize);
        let half = half_row(width);
        let row = 6 * half * height;
        Sheet {
            width,
            height,
            half,
            now: Aligned::zeros(row),
            before: Aligned::zeros(row),
            lost: Aligned::default(),
            w: Aligned::zeros(2 * half * height),
            alike: vec![T::of(0.0); height],
        }
    }

    /// Sets the inverse masses, by texels; what is below 0 is pinned.
    pub fn weigh(&mut self, of: impl Fn(usize) -> T) {
        let (zero, width) = (T::of(0.0), self.width);
        for k in 0..width * self.height {
            let place = self.single(k);
            self.w[place] = of(k).max(zero);
        }
        for (j, alike) in self.alike.iter_mut().enumerate() {
            let first = of(j * width).max(zero);
            *alike = if (1..width).all(|i| of(j * width + i) == first) { first } else { zero };
        }
    }

    /// Numbers in a row of `now`.
    pub fn row(&self) -> usize {
        6 * self.half
    }

    /// Where texel `k` of the grid (row-major) lies in `w`.
    #[inline]
    pub fn single(&self, k: usize) -> usize {
        let (i, j) = (k % self.width, k / self.width);
        j * 2 * self.half + (i & 1) * self.half + i / 2
    }

    /// Where its x lies in `now`; y and z are `2 half` and `4 half` further on.
    #[inline]
    pub fn triple(&self, k: usize) -> usize {
        let (i, j) = (k % self.width, k / self.width);
        j * 6 * self.half + (i & 1) * self.half + i / 2
    }

    /// A list by texels in the layout of `w`; `fill` where there is no texel.
    pub fn list(&self, fill: T, value: impl Fn(usize) -> T) -> Vec<T> {
        let mut out = vec![fill; self.w.len()];
        (0..self.width * self.height).for_each(|k| out[self.single(k)] = value(k));
        out
    }

    /// Positions from texels.
    pub fn load(&mut self, now: &[[T; 4]], before: &[[T; 4]]) {
        // Past the last column too: a NaN there would spread.
        self.now.fill(T::of(0.0));
        self.before.fill(T::of(0.0));
        self.lost.fill(T::of(0.0));
        scatter(&mut self.now, self.width, self.half, now);
        scatter(&mut self.before, self.width, self.half, before);
    }

    /// A list by texels in the layout of [`Sheet::now`].
    pub fn arrange(&self, texels: &[[T; 4]], list: &mut [T]) {
        scatter(list, self.width, self.half, texels);
    }

    /// A list in the layout of [`Sheet::now`] to texels; their fourth component stays.
    pub fn gather(&self, list: &[T], texels: &mut [[T; 4]]) {
        gather(list, self.width, self.half, texels);
    }

    /// Positions to texels; their fourth component stays.
    pub fn store(&self, now: &mut [[T; 4]], before: &mut [[T; 4]]) {
        gather(&self.now, self.width, self.half, now);
        gather(&self.before, self.width, self.half, before);
    }

    /// Copies the low bits of the positions to texels; without low bits the texels keep their values.
    pub fn store_lost(&self, texels: &mut [[T; 4]]) {
        if !self.lost.is_empty() {
            gather(&self.lost, self.width, self.half, texels);
        }
    }

    /// The same from texels.
    pub fn load_lost(&mut self, texels: &[[T; 4]]) {
        let mut lost = Aligned::zeros(self.now.len());
        scatter(&mut lost, self.width, self.half, texels);
        self.lost = lost;
    }

    /// A position.
    #[inline]
    pub fn at(&self, triple: usize) -> V3<T> {
        [self.now[triple], self.now[triple + 2 * self.half], self.now[triple + 4 * self.half]]
    }

    /// Sets a position.
    #[inline]
    pub fn put(&mut self, triple: usize, at: V3<T>) {
        (0..3).for_each(|c| self.now[triple + 2 * c * self.half] = at[c]);
    }
}

fn scatter<T: Real>(planes: &mut [T], width: usize, half: usize, texels: &[[T; 4]]) {
    for (row, texels) in planes.chunks_exact_mut(6 * half).zip(texels.chunks_exact(width)) {
        let (even, odd) = (texels.iter().step_by(2), texels.iter().skip(1).step_by(2));
        for c in 0..3 {
            let (e, o) = row[2 * c * half..2 * (c + 1) * half].split_at_mut(half);
            e.iter_mut().zip(even.clone()).for_each(|(to, t)| *to = t[c]);
            o.iter_mut().zip(odd.clone()).for_each(|(to, t)| *to = t[c]);
        }
    }
}

fn gather<T: Real>(planes: &[T], width: usize, half: usize, texels: &mut [[T; 4]]) {
    for (row, texels) in planes.chunks_exact(6 * half).zip(texels.chunks_exact_mut(width)) {
        let [x, y, z] = planes_ref(row, half).map(|p| p.split_at(half));
        let even = x.0.iter().zip(y.0).zip(z.0);
        let odd = x.1.iter().zip(y.1).zip(z.1);
        let (pairs, last) = texels.as_chunks_mut::<2>();
        for (pair, (((a, b), c), ((d, e), f))) in pairs.iter_mut().zip(even.zip(odd)) {
            *pair = [[*a, *b, *c, pair[0][3]], [*d, *e, *f, pair[1][3]]];
        }
        let end = width / 2;
        for texel in last {
            (texel[0], texel[1], texel[2]) = (x.0[end], y.0[end], z.0[end]);
        }
    }
}
