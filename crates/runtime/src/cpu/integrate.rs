//! Twin of shaders/integrate.wgsl: one Verlet step of every free particle.

use super::gust::air;
use super::rows::Threads;
use crate::number::noise::LastCell;
use crate::number::real::{Real, V3, add, dot, scale, sub, with_w, xyz};
use crate::step::Step;

const CHUNK: usize = 1024;

/// Acceleration that air adds to gravity; fields lie as the particles do.
#[derive(Clone, Copy)]
pub enum Air<'a, A> {
    None,
    /// Every particle alike.
    Push,
    /// An acceleration a particle, from the pass `wind`.
    Field(&'a [A]),
}

/// Moves free particles on and makes their positions the previous ones.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, now: &mut [[T; 4]], before: &mut [[T; 4]], air: Air<[T; 4]>) {
    threads.chunks2(now, before, (CHUNK, CHUNK), |chunk, now, before| match air {
        Air::None => all(step, now, before, |_, _, _| step.gravity),
        Air::Push => {
            let mut last = LastCell::default();
            all(step, now, before, |_, p, moved| add(step.gravity, push(step, &mut last, p, moved)));
        }
        Air::Field(field) => {
            let field = &field[chunk * CHUNK..];
            all(step, now, before, |k, _, _| add(step.gravity, xyz(field[k])));
        }
    });
}

#[inline]
fn push<T: Real>(step: &Step<T>, last: &mut LastCell<T>, p: V3<T>, moved: V3<T>) -> V3<T> {
    scale(sub(air(step, last, p), scale(moved, step.rate)), step.response)
}

#[inline]
fn all<T: Real>(
    step: &Step<T>,
    now: &mut [[T; 4]],
    before: &mut [[T; 4]],
    mut acceleration: impl FnMut(usize, V3<T>, V3<T>) -> V3<T>,
) {
    for (k, (p, b)) in now.iter_mut().zip(before).enumerate() {
        if p[3] <= T::of(0.0) {
            continue;
        }
        let at = xyz(*p);
        let moved = sub(at, xyz(*b));
        let a = acceleration(k, at, moved);
        let on = if dot(moved, moved) > step.longest { T::of(0.0) } else { step.keep };
        *b = *p;
        *p = with_w(add(add(at, scale(moved, on)), scale(a, step.scale)), p[3]);
    }
}
