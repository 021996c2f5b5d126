//! Value noise, after K. Perlin's lattice: numbers at whole points, and smooth changes between them.

use super::lanes::{LANES, Machine};
use super::real::{Real, V3};

/// Noise between -1 and 1 that changes smoothly from lattice point to lattice point.
pub fn noise<T: Real>(q: V3<T>) -> T {
    let base = q.map(T::floor);
    let f = [0, 1, 2].map(|c| q[c] - base[c]);
    let u = f.map(|x| x * x * (T::of(3.0) - T::of(2.0) * x));
    let cell = base.map(|x| x.get() as i32);
    let mix = |a: T, b: T, t: T| a + (b - a) * t;
    let row = |y: i32, z: i32| {
        let at = |x: i32| {
            T::of(f64::from(lattice(cell[0].wrapping_add(x), cell[1].wrapping_add(y), cell[2].wrapping_add(z))))
        };
        mix(at(0), at(1), u[0])
    };
    let sheet = |z: i32| mix(row(0, z), row(1, z), u[1]);
    mix(sheet(0), sheet(1), u[2])
}

/// The same for a vector of points, with the same bits within 2^22 cells of the origin.
#[inline(always)]
pub fn noises<T: Real, K: Machine<T>>(k: K, q: [K::V; 3]) -> K::V {
    let one = k.splat(T::of(1.0));
    let base = [k.floor(q[0]), k.floor(q[1]), k.floor(q[2])];
    let f = k.minus(q, base);
    let u = [smooth(k, f[0]), smooth(k, f[1]), smooth(k, f[2])];
    let next = k.plus(base, [one; 3]);
    // Nearly always all points are in one cell, as cloth is finer than gusts.
    if let Some([x, y, z]) = one_cell(k, base) {
        let at = |n: i32| {
            T::of(f64::from(lattice(x.wrapping_add(n & 1), y.wrapping_add(n >> 1 & 1), z.wrapping_add(n >> 2))))
        };
        let rows = [[at(0), at(1)], [at(2), at(3)], [at(4), at(5)], [at(6), at(7)]];
        let [a, b] = [along(k, rows[0], u[0]), along(k, rows[1], u[0])];
        let [c, d] = [along(k, rows[2], u[0]), along(k, rows[3], u[0])];
        return mix(k, mix(k, a, b, u[1]), mix(k, c, d, u[1]), u[2]);
    }
    let [a, b] = [row(k, [base, next], [base[1], base[2]], u[0]), row(k, [base, next], [next[1], base[2]], u[0])];
    let [c, d] = [row(k, [base, next], [base[1], next[2]], u[0]), row(k, [base, next], [next[1], next[2]], u[0])];
    mix(k, mix(k, a, b, u[1]), mix(k, c, d, u[1]), u[2])
}

/// The cell of all points, if it is one.
#[inline(always)]
fn one_cell<T: Real, K: Machine<T>>(k: K, base: [K::V; 3]) -> Option<[i32; 3]> {
    let mut cell = [0; 3];
    for c in 0..3 {
        let mut list = [T::of(0.0); LANES];
        k.store(&mut list, 0, base[c]);
        let first = k.splat(list[0]);
        if k.any(k.above(base[c], first)) || k.any(k.above(first, base[c])) {
            return None;
        }
        cell[c] = list[0].get() as i32;
    }
    Some(cell)
}

#[inline(always)]
fn along<T: Real, K: Machine<T>>(k: K, [a, b]: [T; 2], t: K::V) -> K::V {
    mix(k, k.splat(a), k.splat(b), t)
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

/// Between the lattice points of a cell in the row (y, z).
#[inline(always)]
fn row<T: Real, K: Machine<T>>(k: K, [base, next]: [[K::V; 3]; 2], [y, z]: [K::V; 2], t: K::V) -> K::V {
    mix(k, k.lattice([base[0], y, z]), k.lattice([next[0], y, z]), t)
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
            for n in 0..400 {
                let far = |m: usize, c: usize| ((n * LANES + m) * (7919 + 12 * c)) as f64 % 60_000.0 * 0.037 - 900.0;
                // Every other vector is within a cell.
                let near = |m: usize, c: usize| far(0, c).floor() + 0.05 + 0.9 * m as f64 / LANES as f64;
                let at = |m, c| if n % 2 == 0 { far(m, c) } else { near(m, c) };
                let list = |c: usize| -> Vec<T> { (0..LANES).map(|m| T::of(at(m, c))).collect() };
                let lists = [list(0), list(1), list(2)];
                let all = noises(k, [0, 1, 2].map(|c| k.load(&lists[c], 0)));
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
        for (q, found) in &all {
            assert!(*found == noise(*q), "{q:?}: {found:?}, {:?}", noise(*q));
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
