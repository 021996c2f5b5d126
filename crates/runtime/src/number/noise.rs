//! Value noise, after K. Perlin's lattice: numbers at whole points, and smooth changes between them.

use super::lanes::Machine;
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
    let (one, two, three) = (k.splat(T::of(1.0)), k.splat(T::of(2.0)), k.splat(T::of(3.0)));
    let base = q.map(|x| k.floor(x));
    let u = k.minus(q, base).map(|x| k.mul(k.mul(x, x), k.sub(three, k.mul(two, x))));
    let next = base.map(|x| k.add(x, one));
    let mix = |a, b, t| k.add(a, k.mul(k.sub(b, a), t));
    let row = |y, z| mix(k.lattice([base[0], y, z]), k.lattice([next[0], y, z]), u[0]);
    let sheet = |z| mix(row(base[1], z), row(next[1], z), u[1]);
    mix(sheet(base[2]), sheet(next[2]), u[2])
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
    use crate::number::lanes::{LANES, Work, widest};

    struct Compare<'a, T>(&'a mut Vec<(V3<T>, T)>);

    impl<T: Real> Work<T> for Compare<'_, T> {
        fn run<K: Machine<T>>(self, k: K) {
            for n in 0..400 {
                let list = |c: usize| -> Vec<T> {
                    (0..LANES)
                        .map(|m| T::of(((n * LANES + m) * (7919 + 12 * c)) as f64 % 60_000.0 * 0.037 - 900.0))
                        .collect()
                };
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
