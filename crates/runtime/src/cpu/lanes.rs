//! Sixteen numbers at a time: the shape of loop that compilers turn into vector instructions of any width.
//!
//! Only additions, multiplications, divisions and square roots are used, all correctly rounded and none fused, so every
//! instruction set gives the same bits as the plain loop.

use super::real::Real;

/// Numbers in a block: one AVX-512 register of f32, two of AVX2, four of SSE2 or NEON.
pub const LANES: usize = 16;

/// A block.
pub type Lanes<T> = [T; LANES];

/// The block at `at`. The list must reach as far.
#[inline(always)]
pub fn load<T: Real>(from: &[T], at: usize) -> Lanes<T> {
    let mut out = [T::of(0.0); LANES];
    out.copy_from_slice(&from[at..at + LANES]);
    out
}

/// The block at `at`; zeros where the list ends before it does.
#[inline(always)]
pub fn peek<T: Real>(from: &[T], at: usize) -> Lanes<T> {
    if from.is_empty() { [T::of(0.0); LANES] } else { load(from, at) }
}

/// Writes a block back.
#[inline(always)]
pub fn store<T: Real>(to: &mut [T], at: usize, block: &Lanes<T>) {
    to[at..at + LANES].copy_from_slice(block);
}

/// One number in every lane.
#[inline(always)]
pub fn splat<T: Real>(x: T) -> Lanes<T> {
    [x; LANES]
}

/// Lane by lane.
#[inline(always)]
pub fn each<T: Real>(f: impl Fn(usize) -> T) -> Lanes<T> {
    let mut out = [T::of(0.0); LANES];
    for (k, x) in out.iter_mut().enumerate() {
        *x = f(k);
    }
    out
}

/// Three coordinates of sixteen points.
pub type Points<T> = [Lanes<T>; 3];

/// Loads the same block of three lists.
#[inline(always)]
pub fn points<T: Real>(from: [&[T]; 3], at: usize) -> Points<T> {
    from.map(|list| load(list, at))
}



/// Runs `work` with the widest instructions of this processor. Everything it calls must be inlined into it.
#[inline(always)]
pub fn widest(work: impl FnOnce()) {
    pulp::Arch::new().dispatch(Work(work));
}

struct Work<F>(F);

impl<F: FnOnce()> pulp::NullaryFnOnce for Work<F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        (self.0)();
    }
}
