//! Twin of shaders/colliders.wgsl: particles inside a collider go to its surface, and friction holds them there.

use super::rows::Threads;
use crate::collider::solid::Solid;
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
                let Some((out, n)) = solid.exit(at) else { continue };
                let depth = sub(out, at);
                at = out;
                if solid.friction > T::of(0.0) {
                    let was = xyz(before[chunk * CHUNK + k]);
                    at = rub(solid, at, n, was, dot(depth, depth).sqrt(), dt);
                }
            }
            *p = with_w(at, p[3]);
        }
    });
}

/// Takes back the motion along the surface since the last step, by at most friction times the depth.
pub fn rub<T: Real>(solid: &Solid<T>, at: V3<T>, n: V3<T>, was: V3<T>, depth: T, dt: T) -> V3<T> {
    let surface = add(solid.velocity, cross(solid.spin, sub(at, solid.center)));
    let moved = sub(sub(at, was), scale(surface, dt));
    let along = sub(moved, scale(n, dot(moved, n)));
    let far = dot(along, along).sqrt();
    let most = solid.friction * depth;
    if far <= most { sub(at, along) } else { sub(at, scale(along, most / far)) }
}
