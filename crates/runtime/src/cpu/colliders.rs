//! Twin of shaders/colliders.wgsl: particles inside a collider go to its surface, and friction holds them there.

use super::rows::Threads;
use crate::collider::solid::{Exit, Solid};
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w, xyz};

const CHUNK: usize = 1024;

/// One pass over all particles, the colliders in their order. `before` and the length of the step are for friction.
pub fn run<T: Real>(threads: &Threads, now: &mut [[T; 4]], before: &[[T; 4]], solids: &[Solid<T>], dt: T) {
    threads.chunks(now, CHUNK, |chunk, now| {
        for (k, p) in now.iter_mut().enumerate() {
            if p[3] <= T::of(0.0) {
                continue;
            }
            let mut at = xyz(*p);
            for solid in solids {
                let Some(out) = solid.exit(at) else { continue };
                if solid.friction > T::of(0.0) {
                    let was = xyz(before[chunk * CHUNK + k]);
                    at = rub(solid, &out, moved_by(solid, was, dt));
                } else {
                    at = out.at;
                }
            }
            *p = with_w(at, p[3]);
        }
    });
}

/// Where a collider carries a point in `dt` \[s\].
pub fn moved_by<T: Real>(solid: &Solid<T>, p: V3<T>, dt: T) -> V3<T> {
    add(p, scale(add(solid.velocity, cross(solid.spin, sub(p, solid.center))), dt))
}

/// Takes back the motion along the surface since the last step, by at most friction times the depth; `from` is where the collider carried
/// the particle from where it was.
pub fn rub<T: Real>(solid: &Solid<T>, &Exit { at, normal: n, depth }: &Exit<T>, from: V3<T>) -> V3<T> {
    let moved = sub(at, from);
    let along = sub(moved, scale(n, dot(moved, n)));
    let far = dot(along, along).sqrt();
    let most = solid.friction * depth;
    if far <= most { sub(at, along) } else { sub(at, scale(along, most / far)) }
}
