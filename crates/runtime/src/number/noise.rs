//! Value noise, after K. Perlin's lattice: numbers at whole points, and smooth changes between them.

use super::lanes::{LANES, Machine};
use super::real::{Real, V3};

/// Noise between -1 and 1 that changes smoothly from lattice point to lattice point.
#[inline]
pub fn noise<T: Real>(last: &mut LastCell<T>, q: V3<T>) -> T {
    let base = q.map(T::floor);
    within(last.of(base), q, base)
}

/// Noise at a point of a cell, given the lattice around it.
#[inline]
fn within<T: Real>(at: &[T; 8], q: V3<T>, base: V3<T>) -> T {
    let f = [0, 1, 2].map(|c| q[c] - base[c]);
    let u = f.map(|x| x * x * (T::of(3.0) - T::of(2.0) * x));
    let mix = |a: T, b: T, t: T| a + (b - a) * t;
    let along = [0, 2, 4, 6].map(|n| mix(at[n], at[n + 1], u[0]));
    mix(mix(along[0], along[1], u[1]), mix(along[2], along[3], u[1]), u[2])
}

/// The lattice around the cell that was looked at last: cloth is finer than gusts.
#[derive(Clone, Copy)]
pub struct LastCell<T> {
    cell: Option<V3<T>>,
    at: [T; 8],
}

impl<T: Real> Default for LastCell<T> {
    fn default() -> Self {
        LastCell { cell: None, at: [T::of(0.0); 8] }
    }
}

impl<T: Real> LastCell<T> {
    #[inline(always)]
    fn of(&mut self, cell: V3<T>) -> &[T; 8] {
        if self.cell != Some(cell) {
            *self = LastCell { cell: Some(cell), at: corners(cell) };
        }
        &self.at
    }
}

/// The same for a vector of points, with the same bits within 2^22 cells of the origin.
///
/// Cell by cell, and nearly always all points are in one. Code for lattice points in vectors would be a tenth of this crate's
/// compile time.
#[inline(always)]
pub fn noises<T: Real, K: Machine<T>>(k: K, last: &mut LastCell<T>, q: [K::V; 3]) -> K::V {
    let (zero, one) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)));
    let base = [k.floor(q[0]), k.floor(q[1]), k.floor(q[2])];
    let f = k.minus(q, base);
    let u = [smooth(k, f[0]), smooth(k, f[1]), smooth(k, f[2])];
    let mut cells = [[T::of(0.0); LANES]; 3];
    for c in 0..3 {
        k.store(&mut cells[c], 0, base[c]);
    }
    let (mut all, mut left, mut lane) = (zero, one, 0);
    loop {
        let cell = [cells[0][lane], cells[1][lane], cells[2][lane]];
        let here = k.splats(cell);
        // A NaN is in every cell, and comes out as NaN.
        let mut elsewhere = zero;
        for c in 0..3 {
            elsewhere = k.choose(k.above(base[c], here[c]), one, elsewhere);
            elsewhere = k.choose(k.above(here[c], base[c]), one, elsewhere);
        }
        let at = last.of(cell);
        let mut along = [zero; 4];
        for n in 0..4 {
            along[n] = mix(k, k.splat(at[2 * n]), k.splat(at[2 * n + 1]), u[0]);
        }
        let value = mix(k, mix(k, along[0], along[1], u[1]), mix(k, along[2], along[3], u[1]), u[2]);
        let elsewhere = k.above(elsewhere, zero);
        all = k.choose(elsewhere, all, value);
        left = k.choose(elsewhere, left, zero);
        let mut still = [T::of(0.0); LANES];
        k.store(&mut still, 0, left);
        match still[..K::WIDE].iter().position(|s| *s > T::of(0.0)) {
            Some(next) => lane = next,
            None => return all,
        }
    }
}

/// The lattice around a cell, by x, then y, then z.
#[inline(never)]
fn corners<T: Real>(base: V3<T>) -> [T; 8] {
    let [x, y, z] = base.map(|b| b.get() as i32);
    let at = |n: i32| lattice(x.wrapping_add(n & 1), y.wrapping_add(n >> 1 & 1), z.wrapping_add(n >> 2));
    [0, 1, 2, 3, 4, 5, 6, 7].map(|n| T::of(f64::from(at(n))))
}

/// From 0 to 1 without a bend at the ends.
#[inline(always)]
fn smooth<T: Real, K: Machine<T>>(k: K, x: K::V) -> K::V {
    k.mul(k.mul(x, x), k.sub(k.splat(T::of(3.0)), k.mul(k.splat(T::of(2.0)), x)))
}

#[inline(always)]
fn mix<T: Real, K: Machine<T>>(k: K, a: K::V, b: K::V, t: K::V) -> K::V {
    k.add(a, k.mul(k.sub(b, a), t))
}

/// A number between -1 and 1 for a lattice point; repeats after 1024 cells.
pub fn lattice(x: i32, y: i32, z: i32) -> f32 {
    let wrap = |k: i32| (k & 1023) as u32;
    let mut h = wrap(x) | (wrap(y) << 10) | (wrap(z) << 20);
    // lowbias32 by C. Wellons: integer, so the same everywhere.
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    (h >> 8) as f32 * (1.0 / 8_388_608.0) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::lanes::{Work, widest};

    struct Compare<'a, T>(&'a mut Vec<(V3<T>, T)>);

    impl<T: Real> Work<T> for Compare<'_, T> {
        fn run<K: Machine<T>>(self, k: K) {
            let mut last = LastCell::default();
            for n in 0..400 {
                let far = |m: usize, c: usize| ((n * LANES + m) * (7919 + 12 * c)) as f64 % 60_000.0 * 0.037 - 900.0;
                // Every other vector is within a cell.
                let near = |m: usize, c: usize| far(0, c).floor() + 0.05 + 0.9 * m as f64 / LANES as f64;
                let at = |m, c| if n % 2 == 0 { far(m, c) } else { near(m, c) };
                let list = |c: usize| -> Vec<T> { (0..LANES).map(|m| T::of(at(m, c))).collect() };
                let lists = [list(0), list(1), list(2)];
                let all = noises(k, &mut last, [0, 1, 2].map(|c| k.load(&lists[c], 0)));
                let mut out = vec![T::of(0.0); LANES];
                k.store(&mut out, 0, all);
                self.0.extend((0..K::WIDE).map(|m| (lists.each_ref().map(|l| l[m]), out[m])));
            }
        }
    }

    fn vectors_have_the_bits_of_numbers<T: Real + std::fmt::Debug>() {
        let mut all = Vec::new();
        widest(Compare::<T>(&mut all));
        assert!(all.len() >= 800);
        let single = |q| noise(&mut LastCell::default(), q);
        for (q, found) in &all {
            assert!(*found == single(*q), "{q:?}: {found:?}, {:?}", single(*q));
        }
        let (low, high) = all.iter().fold((0.0f64, 0.0f64), |(a, b), (_, x)| (a.min(x.get()), b.max(x.get())));
        assert!(low < -0.5 && high > 0.5 && low >= -1.0 && high <= 1.0, "{low} to {high}");
    }

    #[test]
    fn noise_in_vectors_has_the_bits_of_single_numbers() {
        vectors_have_the_bits_of_numbers::<f32>();
        vectors_have_the_bits_of_numbers::<f64>();
    }
}
