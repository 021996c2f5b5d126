//! Vector instructions of the processor at hand, behind one trait for f32 and f64.
//!
//! Only additions, multiplications, divisions, square roots and comparisons are used, all correctly rounded and none
//! fused, so every instruction set gives the same bits, as a loop over single numbers would.

use std::slice::from_mut;

use bytemuck::{bytes_of, cast_slice, cast_slice_mut, pod_read_unaligned};
use pulp::Simd;

use super::real::Real;

/// Numbers in a block: one AVX-512 register of f32, two of AVX2, four of SSE2 or NEON. Lists are as long as a whole
/// number of blocks.
pub const LANES: usize = 16;

/// An instruction set. `V` is a vector of `WIDE` numbers, `M` a mask of as many.
pub trait Machine<T: Real>: Copy {
    type V: Copy;
    type M: Copy;
    /// A divisor of [`LANES`].
    const WIDE: usize;
    /// The vector at `at`. The list must reach as far.
    fn load(self, from: &[T], at: usize) -> Self::V;
    /// Writes a vector back.
    fn store(self, to: &mut [T], at: usize, v: Self::V);
    /// The columns of a table of `WIDE` rows. The number of a lane is in the row that [`lane_rows`] has.
    fn columns(self, rows: &[[T; 4]]) -> [Self::V; 4];
    /// The table of four columns.
    fn table(self, columns: [Self::V; 4], to: &mut [[T; 4]]);
    fn splat(self, x: T) -> Self::V;
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// The largest whole number not above a, from -2^22 to 2^22.
    fn floor(self, a: Self::V) -> Self::V;
    /// Whether a > b, number by number.
    fn above(self, a: Self::V, b: Self::V) -> Self::M;
    /// Whether a >= b, number by number.
    fn at_least(self, a: Self::V, b: Self::V) -> Self::M;
    /// Where both masks are set.
    fn both(self, a: Self::M, b: Self::M) -> Self::M;
    /// Where the first mask is set and the second is not.
    fn without(self, a: Self::M, b: Self::M) -> Self::M;
    /// a where the mask is set, else b.
    fn choose(self, mask: Self::M, a: Self::V, b: Self::V) -> Self::V;

    /// Whether the mask is set anywhere.
    fn any(self, mask: Self::M) -> bool;

    /// The larger one; b where either is NaN.
    fn most(self, a: Self::V, b: Self::V) -> Self::V;
    /// The smaller one; b where either is NaN.
    fn least(self, a: Self::V, b: Self::V) -> Self::V;

    /// The place of the least number of lists that were gone through by vectors: `least` of each lane, and where its vector begins, below 0 for none. The
    /// first of those that are equal, whatever the width of vectors.
    #[inline(always)]
    fn first_least(self, least: Self::V, begins: Self::V) -> Option<usize> {
        let mut lanes = [[T::of(0.0); LANES]; 2];
        self.store(&mut lanes[0], 0, least);
        self.store(&mut lanes[1], 0, begins);
        let (mut best, mut first) = (T::of(f64::from(f32::MAX)), usize::MAX);
        for (lane, (d, begin)) in lanes[0].iter().zip(&lanes[1]).take(Self::WIDE).enumerate() {
            if *begin < T::of(0.0) {
                continue;
            }
            let at = begin.get() as usize + lane;
            if *d < best || (*d == best && at < first) {
                (best, first) = (*d, at);
            }
        }
        if first < usize::MAX { Some(first) } else { None }
    }

    /// Squares of lengths, summed in the order of `real::dot`.
    #[inline(always)]
    fn squares(self, v: [Self::V; 3]) -> Self::V {
        self.dot(v, v)
    }

    /// A vector of numbers that are alike.
    #[inline(always)]
    fn splats(self, [x, y, z]: [T; 3]) -> [Self::V; 3] {
        [self.splat(x), self.splat(y), self.splat(z)]
    }

    /// A vector from three lists.
    #[inline(always)]
    fn loads(self, [x, y, z]: &[Vec<T>; 3], at: usize) -> [Self::V; 3] {
        [self.load(x, at), self.load(y, at), self.load(z, at)]
    }

    /// A sum of vectors.
    #[inline(always)]
    fn plus(self, a: [Self::V; 3], b: [Self::V; 3]) -> [Self::V; 3] {
        [self.add(a[0], b[0]), self.add(a[1], b[1]), self.add(a[2], b[2])]
    }

    /// A difference of vectors.
    #[inline(always)]
    fn minus(self, a: [Self::V; 3], b: [Self::V; 3]) -> [Self::V; 3] {
        [self.sub(a[0], b[0]), self.sub(a[1], b[1]), self.sub(a[2], b[2])]
    }

    /// A vector times a number.
    #[inline(always)]
    fn times(self, a: [Self::V; 3], by: Self::V) -> [Self::V; 3] {
        [self.mul(a[0], by), self.mul(a[1], by), self.mul(a[2], by)]
    }

    /// A product of vectors, summed in the order of `real::dot`.
    #[inline(always)]
    fn dot(self, a: [Self::V; 3], b: [Self::V; 3]) -> Self::V {
        self.add(self.add(self.mul(a[0], b[0]), self.mul(a[1], b[1])), self.mul(a[2], b[2]))
    }

    /// As `real::cross`.
    #[inline(always)]
    fn cross(self, a: [Self::V; 3], b: [Self::V; 3]) -> [Self::V; 3] {
        [
            self.sub(self.mul(a[1], b[2]), self.mul(a[2], b[1])),
            self.sub(self.mul(a[2], b[0]), self.mul(a[0], b[2])),
            self.sub(self.mul(a[0], b[1]), self.mul(a[1], b[0])),
        ]
    }

    /// The first `count` numbers of a vector, zeros after them.
    #[inline(always)]
    fn first(self, v: Self::V, count: usize) -> Self::V {
        let zero = self.splat(T::of(0.0));
        let mask = self.above(self.load(T::ONES_THEN_ZEROS, LANES.saturating_sub(count)), zero);
        self.choose(mask, v, zero)
    }
}

/// Work for whatever instruction set there is. Everything it calls must be inlined into it, always; closures and
/// `array::map` are not, and cost fifty times as much.
pub trait Work<T: Real> {
    /// Does it.
    fn run<K: Machine<T>>(self, k: K);
}

/// Runs `work` with the widest instructions of this processor.
#[inline(always)]
pub fn widest<T: Real>(work: impl Work<T>) {
    T::widest(work);
}

/// For each lane of a block the row of a table that has its number, as the instructions of this processor order them.
pub fn lane_rows<T: Real>() -> [usize; LANES] {
    let mut rows = [0; LANES];
    widest(LaneRows::<T> { rows: &mut rows, of: std::marker::PhantomData });
    rows
}

struct LaneRows<'a, T> {
    rows: &'a mut [usize; LANES],
    of: std::marker::PhantomData<T>,
}

impl<T: Real> Work<T> for LaneRows<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        for at in (0..LANES).step_by(K::WIDE) {
            let (mut table, mut lanes) = ([[T::of(0.0); 4]; LANES], [T::of(0.0); LANES]);
            for (n, row) in table.iter_mut().enumerate() {
                *row = [T::of((at + n) as f64); 4];
            }
            k.store(&mut lanes, 0, k.columns(&table)[0]);
            for (row, number) in self.rows[at..at + K::WIDE].iter_mut().zip(lanes) {
                *row = number.get() as usize;
            }
        }
    }
}

macro_rules! machine {
    ($t:ident, $v:ident, $m:ident, $run:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $sqrt:ident, $floor:ident, $above:ident, $at_least:ident, $both:ident, $either:ident, $choose:ident, $first:ident, $max:ident, $min:ident, $apart:ident, $together:ident, $dispatch:ident) => {
        impl<S: Simd> Machine<$t> for On<S> {
            type V = S::$v;
            type M = S::$m;
            const WIDE: usize = size_of::<S::$v>() / size_of::<$t>();

            #[inline(always)]
            fn load(self, from: &[$t], at: usize) -> S::$v {
                pod_read_unaligned(cast_slice(&from[at..at + <Self as Machine<$t>>::WIDE]))
            }
            #[inline(always)]
            fn store(self, to: &mut [$t], at: usize, v: S::$v) {
                cast_slice_mut(&mut to[at..at + <Self as Machine<$t>>::WIDE]).copy_from_slice(bytes_of(&v));
            }
            #[inline(always)]
            fn columns(self, rows: &[[$t; 4]]) -> [S::$v; 4] {
                self.0.$apart(pod_read_unaligned::<[S::$v; 4]>(cast_slice(&rows[..<Self as Machine<$t>>::WIDE])))
            }
            #[inline(always)]
            fn table(self, columns: [S::$v; 4], to: &mut [[$t; 4]]) {
                let rows = self.0.$together(columns);
                cast_slice_mut(&mut to[..<Self as Machine<$t>>::WIDE]).copy_from_slice(bytes_of(&rows));
            }
            #[inline(always)]
            fn splat(self, x: $t) -> S::$v {
                self.0.$splat(x)
            }
            #[inline(always)]
            fn add(self, a: S::$v, b: S::$v) -> S::$v {
                self.0.$add(a, b)
            }
            #[inline(always)]
            fn sub(self, a: S::$v, b: S::$v) -> S::$v {
                self.0.$sub(a, b)
            }
            #[inline(always)]
            fn mul(self, a: S::$v, b: S::$v) -> S::$v {
                self.0.$mul(a, b)
            }
            #[inline(always)]
            fn div(self, a: S::$v, b: S::$v) -> S::$v {
                self.0.$div(a, b)
            }
            #[inline(always)]
            fn sqrt(self, a: S::$v) -> S::$v {
                self.0.$sqrt(a)
            }
            #[inline(always)]
            fn floor(self, a: S::$v) -> S::$v {
                self.$floor(a)
            }
            #[inline(always)]
            fn above(self, a: S::$v, b: S::$v) -> S::$m {
                self.0.$above(a, b)
            }
            #[inline(always)]
            fn at_least(self, a: S::$v, b: S::$v) -> S::$m {
                self.0.$at_least(a, b)
            }
            #[inline(always)]
            fn both(self, a: S::$m, b: S::$m) -> S::$m {
                self.0.$both(a, b)
            }
            #[inline(always)]
            fn without(self, a: S::$m, b: S::$m) -> S::$m {
                self.0.$either(a, self.0.$both(a, b))
            }
            #[inline(always)]
            fn choose(self, mask: S::$m, a: S::$v, b: S::$v) -> S::$v {
                self.0.$choose(mask, a, b)
            }
            #[inline(always)]
            fn most(self, a: S::$v, b: S::$v) -> S::$v {
                // One instruction of x86 in place of two; those of other processors treat NaN otherwise.
                if cfg!(any(target_arch = "x86", target_arch = "x86_64")) && <Self as Machine<$t>>::WIDE > 1 {
                    return self.0.$max(a, b);
                }
                self.0.$choose(self.0.$above(a, b), a, b)
            }
            #[inline(always)]
            fn least(self, a: S::$v, b: S::$v) -> S::$v {
                if cfg!(any(target_arch = "x86", target_arch = "x86_64")) && <Self as Machine<$t>>::WIDE > 1 {
                    return self.0.$min(a, b);
                }
                self.0.$choose(self.0.$above(b, a), a, b)
            }
            #[inline(always)]
            fn any(self, mask: S::$m) -> bool {
                self.0.$first(mask) < <Self as Machine<$t>>::WIDE
            }
        }

        /// Runs work on vectors of this type.
        pub fn $run(work: impl Work<$t>) {
            struct Op<W>(W);
            impl<W: Work<$t>> pulp::WithSimd for Op<W> {
                type Output = ();
                #[inline(always)]
                fn with_simd<S: Simd>(self, simd: S) {
                    self.0.run(On(simd));
                }
            }
            $dispatch(Op(work));
        }
    };
}

/// Runs `op` on the widest vectors of this processor: AVX-512, AVX2, NEON or the vectors of WebAssembly, else number by number. Vectors of
/// 16 bytes made of single numbers would be two to three times as fast there as numbers, and a quarter of this crate's compile time.
#[inline(always)]
fn on_all(op: impl pulp::WithSimd) {
    _ = pulp::Arch::new().dispatch(op);
}

/// The same, but for AVX-512. The solver in f64 is a yardstick, not a product: a copy of it for each instruction set would be a fifth
/// of this crate's compile time.
#[inline(always)]
fn on_256_bits(op: impl pulp::WithSimd) {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match pulp::Arch::new() {
        pulp::Arch::V4(simd) => _ = Simd::vectorize(*simd, op),
        pulp::Arch::V3(simd) => _ = Simd::vectorize(simd, op),
        _ => _ = Simd::vectorize(pulp::Scalar, op),
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    on_all(op);
}

/// The instruction set of a processor.
#[derive(Clone, Copy)]
struct On<S>(S);

impl<S: Simd> On<S> {
    #[inline(always)]
    fn floor_f32s(self, a: S::f32s) -> S::f32s {
        let Self(s) = self;
        let shift = s.splat_f32s(WHOLE);
        let near = s.sub_f32s(s.add_f32s(a, shift), shift);
        s.select_f32s(s.greater_than_f32s(near, a), s.sub_f32s(near, s.splat_f32s(1.0)), near)
    }

    #[inline(always)]
    fn floor_f64s(self, mut a: S::f64s) -> S::f64s {
        cast_slice_mut(from_mut(&mut a)).iter_mut().for_each(|x: &mut f64| *x = x.floor());
        a
    }
}

/// 1.5 * 2^23: a number to which this is added is rounded to a whole one.
const WHOLE: f32 = 12_582_912.0;

machine!(
    f32,
    f32s,
    m32s,
    widest_f32,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    sqrt_f32s,
    floor_f32s,
    greater_than_f32s,
    greater_than_or_equal_f32s,
    and_m32s,
    xor_m32s,
    select_f32s,
    first_true_m32s,
    max_f32s,
    min_f32s,
    deinterleave_shfl_f32s,
    interleave_shfl_f32s,
    on_all
);
machine!(
    f64,
    f64s,
    m64s,
    widest_f64,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    sqrt_f64s,
    floor_f64s,
    greater_than_f64s,
    greater_than_or_equal_f64s,
    and_m64s,
    xor_m64s,
    select_f64s,
    first_true_m64s,
    max_f64s,
    min_f64s,
    deinterleave_shfl_f64s,
    interleave_shfl_f64s,
    on_256_bits
);

#[cfg(test)]
mod tests {
    use super::*;

    struct Larger<'a>([f32; 2], &'a mut [[f32; LANES]; 2]);

    impl Work<f32> for Larger<'_> {
        #[inline(always)]
        fn run<K: Machine<f32>>(self, k: K) {
            let Larger([a, b], [most, least]) = self;
            k.store(most, 0, k.most(k.splat(a), k.splat(b)));
            k.store(least, 0, k.least(k.splat(a), k.splat(b)));
        }
    }

    struct Transposed<'a>(&'a mut [[f32; LANES]; 4], &'a mut [[f32; 4]; LANES]);

    impl Work<f32> for Transposed<'_> {
        #[inline(always)]
        fn run<K: Machine<f32>>(self, k: K) {
            let Transposed(lists, table) = self;
            for at in (0..LANES).step_by(K::WIDE) {
                let columns = k.columns(&table[at..]);
                for (list, column) in lists.iter_mut().zip(columns) {
                    k.store(list, at, column);
                }
                table[at..at + K::WIDE].fill([0.0; 4]);
                k.table(columns, &mut table[at..]);
            }
        }
    }

    #[test]
    fn columns_of_a_table_are_its_rows_in_the_order_of_lanes_and_give_the_table_back() {
        let (mut lists, rows) = ([[0.0; LANES]; 4], lane_rows::<f32>());
        let table: [[f32; 4]; LANES] = std::array::from_fn(|n| std::array::from_fn(|c| (4 * n + c) as f32));
        let mut again = table;
        widest(Transposed(&mut lists, &mut again));
        assert_eq!(again, table);
        for (lane, row) in rows.iter().enumerate() {
            assert_eq!([0, 1, 2, 3].map(|c| lists[c][lane]), table[*row]);
        }
        let mut sorted = rows;
        sorted.sort_unstable();
        assert_eq!(sorted, std::array::from_fn::<usize, LANES, _>(|n| n));
    }

    #[test]
    fn the_larger_and_the_smaller_number_are_the_second_where_either_is_nan_or_both_are_zero() {
        let values = [f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1.0, f32::INFINITY];
        for (a, b) in values.iter().flat_map(|a| values.map(|b| (*a, b))) {
            let mut got = [[0.5; LANES]; 2];
            widest(Larger([a, b], &mut got));
            let want = [if a > b { a } else { b }, if a < b { a } else { b }];
            assert_eq!(got.map(|v| v[0].to_bits()), want.map(f32::to_bits), "{a} {b}");
        }
    }
}
