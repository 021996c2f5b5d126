//! f32 and f64 under one name, and vectors of three.

use super::lanes::{LANES, Work};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A floating-point number that twins compute with.
pub trait Real:
    Copy
    + Send
    + Sync
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + bytemuck::Pod
    + 'static
{
    /// Numbers on whole cache lines.
    type Block: bytemuck::Pod + Send + Sync + std::fmt::Debug;
    /// Runs work with the widest vector instructions of this processor.
    fn widest(work: impl Work<Self>);
    /// As many ones as a block has numbers, then as many zeros.
    const ONES_THEN_ZEROS: &'static [Self; 2 * LANES];
    /// The nearest number.
    fn of(x: f64) -> Self;
    /// Exact.
    fn get(self) -> f64;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The largest whole number not above.
    fn floor(self) -> Self;
    /// The larger one.
    fn max(self, other: Self) -> Self;
    /// The smaller one.
    fn min(self, other: Self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
}

macro_rules! real {
    ($($t:ty, $widest:ident, $block:ident;)*) => {$(
        impl Real for $t {
            type Block = super::aligned::$block;
            const ONES_THEN_ZEROS: &'static [Self; 2 * LANES] = &{
                let mut list = [0.0; 2 * LANES];
                let mut k = 0;
                while k < LANES {
                    list[k] = 1.0;
                    k += 1;
                }
                list
            };
            #[inline(always)]
            fn widest(work: impl Work<Self>) {
                super::lanes::$widest(work);
            }
            #[inline]
            fn of(x: f64) -> Self {
                x as $t
            }
            #[inline]
            fn get(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
            #[inline]
            fn floor(self) -> Self {
                <$t>::floor(self)
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                <$t>::max(self, other)
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                <$t>::min(self, other)
            }
            #[inline]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
        }
    )*};
}
real!(f32, widest_f32, Single; f64, widest_f64, Double;);

pub type V3<T> = [T; 3];

#[inline]
pub fn add<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub fn sub<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub fn scale<T: Real>(a: V3<T>, s: T) -> V3<T> {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline]
pub fn dot<T: Real>(a: V3<T>, b: V3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub fn cross<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub fn xyz<T: Real>(a: [T; 4]) -> V3<T> {
    [a[0], a[1], a[2]]
}

#[inline]
pub fn with_w<T: Real>(a: V3<T>, w: T) -> [T; 4] {
    [a[0], a[1], a[2], w]
}

/// The numbers of another precision, rounded.
pub fn cast<A: Real, B: Real, const N: usize>(a: [A; N]) -> [B; N] {
    a.map(|x| B::of(x.get()))
}
