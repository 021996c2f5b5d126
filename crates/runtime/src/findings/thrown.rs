//! Search for cloth that begins a frame inside colliders.
//!
//! Contact puts such particles outside within a step, and the way of a step is the speed of the next one.

use super::Fate;
use crate::collider::solid::Solid;
use crate::health::may_touch;
use crate::number::real::{Real, V3, add, dot, scale, xyz};

/// Mean speed \[m/s\] from which cloth is thrown: it rises by 5 cm.
const THROWN_M_S: f64 = 1.0;

/// Mean way \[m\] out from which a start is to be cleared: at 1 m/s that of a step of 1 ms.
const TO_CLEAR_M: f64 = 1e-3;

/// The failure of cloth that begins a frame of `frame` \[s\] in steps of `dt` \[s\] inside colliders, which are as at its end, and the particle
/// that is deepest. Ways out that cancel each other, as of cloth around a limb, throw nothing.
pub fn search<T: Real>(now: &[[T; 4]], solids: &[Solid<T>], dt: f64, frame: f64) -> Option<(Fate, usize)> {
    let began = |solid: &Solid<T>| if solid.still { *solid } else { solid.posed(T::of(frame)) };
    let found = inside(now, &solids.iter().map(began).collect::<Vec<_>>());
    let (speed, Inside { depth, collider, particle, .. }) = (found.mean / dt, found);
    (speed > THROWN_M_S).then_some((Fate::Thrown { collider, depth, speed }, particle))
}

/// Whether cloth among colliders is so far inside of them that a start is to be cleared.
pub fn is_to_clear<T: Real>(now: &[[T; 4]], solids: &[Solid<T>]) -> bool {
    inside(now, solids).mean > TO_CLEAR_M
}

/// Cloth that is inside colliders.
struct Inside {
    /// Length \[m\] of the mean way out of its free particles.
    mean: f64,
    /// Of the particle that is deepest.
    depth: f64,
    collider: usize,
    particle: usize,
}

fn inside<T: Real>(now: &[[T; 4]], solids: &[Solid<T>]) -> Inside {
    let (mut sum, mut free, mut worst) = ([T::of(0.0); 3], 0usize, (0.0, 0, 0));
    for (particle, p) in now.iter().enumerate().filter(|(_, p)| p[3].get() > 0.0) {
        free += 1;
        if let Some((collider, depth, way)) = way_out(xyz(*p), solids) {
            sum = add(sum, way);
            if depth > worst.0 {
                worst = (depth, collider, particle);
            }
        }
    }
    let (depth, collider, particle) = worst;
    Inside { mean: dot(sum, sum).sqrt().get() / free.max(1) as f64, depth, collider, particle }
}

/// The collider that a point is deepest in, the depth, and the way out as a vector.
fn way_out<T: Real>(p: V3<T>, solids: &[Solid<T>]) -> Option<(usize, f64, V3<T>)> {
    let near = solids.iter().enumerate().filter(|(_, solid)| may_touch(solid, p));
    let exits = near.filter_map(|(collider, solid)| {
        let out = solid.exit(p)?;
        Some((collider, out.depth.get(), scale(out.normal, out.depth)))
    });
    exits.max_by(|a, b| a.1.total_cmp(&b.1))
}
