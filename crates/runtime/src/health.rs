//! How a cloth fares: stretch, speed, depth in colliders, height. Measured in one pass, at most 20 ns per particle.

use std::array::from_fn;

use crate::cloth::{Cloth, Rest};
use crate::collider::solid::Solid;
use crate::number::real::{Real, V3, dot, sub, xyz};

/// Figures of a cloth at the end of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// End of the frame \[s\], in the time of the scene.
    pub time: f64,
    /// Extension (length / rest length - 1, at least 0) of the springs to the right and down; none of cloth that is cut.
    pub stretch: Option<Stretch>,
    /// RMS speed of the particles \[m/s\] in the last step.
    pub speed: f64,
    /// Largest depth \[m\] of a particle inside a collider, thickness of the cloth included, and of a free particle inside the surface of a
    /// body ([`crate::Cloth::set_body`]); 0 outside of all. That surface counts in what [`crate::Stepper::examine`] returns alone.
    pub depth: f64,
}

/// Mean, 99th percentile and largest extension. Springs between two pins do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Mean.
    pub mean: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

/// The largest and the 99th percentile of extensions, and their mean. Lengths are those of `T`, sums are in f64.
pub(crate) fn stretch<T: Real>(cloth: &Cloth, now: &[[T; 4]]) -> Option<Stretch> {
    if cloth.is_cut() {
        return None;
    }
    let mut all = Vec::with_capacity(2 * now.len());
    for (index, grid) in cloth.grids().iter().enumerate() {
        let (width, height) = (grid.width as usize, grid.height as usize);
        // To the right, and down: springs per row, rows, and the way to the other end.
        let sides = [(width.saturating_sub(1), height, 1), (width, height.saturating_sub(1), width)];
        for (direction, (columns, rows, step)) in sides.into_iter().enumerate() {
            for first in (0..rows).map(|row| grid.range().start + row * width) {
                let ends = now[first..first + columns].iter().zip(&now[first + step..]);
                match cloth.rest() {
                    Rest::None => {}
                    Rest::Constant(rest) => all.extend(ends.map(|(a, b)| extension(a, b, rest[index][direction]))),
                    Rest::Image(rest) => {
                        all.extend(ends.zip(&rest[first..]).map(|((a, b), rest)| extension(a, b, rest[direction])));
                    }
                }
            }
        }
    }
    if all.iter().any(|e| *e < 0.0) {
        all.retain(|e| *e >= 0.0);
    }
    let (fours, left) = all.as_chunks::<4>();
    let sums = fours.iter().fold([0.0; 4], |sums, e| from_fn(|n| sums[n] + f64::from(e[n])));
    let sum = sums.iter().sum::<f64>() + left.iter().map(|e| f64::from(*e)).sum::<f64>();
    let max = f64::from(all.iter().copied().fold(0.0, f32::max));
    let (count, rank) = (all.len(), all.len() * 99 / 100);
    let p99 = if count > 0 { f64::from(*all.select_nth_unstable_by(rank, f32::total_cmp).1) } else { 0.0 };
    Some(Stretch { mean: sum / f64::max(count as f64, 1.0), p99, max })
}

/// The longest springs of a cloth that is in trouble.
pub(crate) struct Longest {
    /// The largest length of a spring to the right or down over its rest length, or over the mean rest length of the cloth where that is larger:
    /// springs of cells that a map squeezes are a fraction of the others, and their own length does not measure what is seen.
    pub length: f64,
    /// The particles of the spring that is extended most.
    pub ends: [usize; 2],
    /// Whether an end of a spring that is extended most, or nearly so, is a pin.
    pub is_at_pin: bool,
}

/// Share of the largest extension that another is nearly as large with.
const NEARLY: f64 = 0.9;

/// Springs between two pins do not count.
pub(crate) fn longest<T: Real>(cloth: &Cloth, now: &[[T; 4]]) -> Longest {
    let (mut all, mut sum) = (Vec::new(), 0.0);
    for (index, grid) in cloth.grids().iter().enumerate() {
        for (k, direction) in (0..grid.texels()).flat_map(|k| [(k, 0), (k, 1)]) {
            let (Some(other), at) = (cloth.neighbour(index, k, direction), grid.range().start + k) else { continue };
            let rest = match cloth.rest() {
                Rest::None => continue,
                Rest::Constant(rest) => rest[index][direction],
                Rest::Image(rest) => rest[at][direction],
            };
            let extension = extension(&now[at], &now[other], rest);
            if extension >= 0.0 {
                let is_at_pin = [at, other].iter().any(|k| now[*k][3] == T::of(0.0));
                all.push((f64::from(rest), f64::from(extension), is_at_pin, [at, other]));
                sum += f64::from(rest);
            }
        }
    }
    let mean = sum / f64::max(all.len() as f64, 1.0);
    let length = all.iter().map(|(rest, e, ..)| (1.0 + e) * rest / mean.max(*rest)).fold(0.0, f64::max);
    // The first of those that are extended as much.
    let extensions = all.iter().map(|(_, e, _, ends)| (*e, *ends));
    let (most, ends) = extensions.fold((0.0, [0; 2]), |most, next| if next.0 > most.0 { next } else { most });
    Longest { length, ends, is_at_pin: all.iter().any(|(_, e, is_at_pin, _)| *is_at_pin && *e >= NEARLY * most) }
}

/// Extension of a spring, at least 0; -1 of none, and of one between two pins.
#[inline(always)]
fn extension<T: Real>(a: &[T; 4], b: &[T; 4], rest: f32) -> f32 {
    let (zero, length) = (T::of(0.0), T::of(rest.into()));
    let d = sub(xyz(*a), xyz(*b));
    let extension = (dot(d, d).sqrt() / length).get() as f32 - 1.0;
    let counts = (rest > 0.0) & (a[3] >= zero) & (b[3] >= zero) & (a[3] + b[3] > zero);
    if counts { extension.max(0.0) } else { -1.0 }
}

/// RMS of the displacements from `before` to `now` over `dt` \[s\].
pub(crate) fn speed<T: Real>(now: &[[T; 4]], before: &[[T; 4]], dt: f64) -> f64 {
    let moved = |(a, b): (&[T; 4], &[T; 4])| {
        let d = sub(xyz(*a), xyz(*b));
        dot(d, d).get()
    };
    let real = || now.iter().zip(before).filter(|(a, _)| a[3].get() >= 0.0);
    (real().map(moved).sum::<f64>() / f64::max(real().count() as f64, 1.0)).sqrt() / dt
}

/// For each collider the largest depth \[m\] of a particle, with `reach` \[m\] added to its surface; 0 outside.
pub(crate) fn depths<T: Real>(now: &[[T; 4]], solids: &[Solid<T>], reach: f64) -> Vec<f64> {
    let deepest = |solid: &Solid<T>| {
        let solid = solid.coated(T::of(reach));
        let real = now.iter().filter(|p| p[3].get() >= 0.0);
        let near = real.map(|p| xyz(*p)).filter(|p| may_touch(&solid, *p));
        near.filter_map(|p| Some(solid.exit(p)?.depth.get())).fold(0.0, f64::max)
    };
    solids.iter().map(deepest).collect()
}

/// The first two colliders that press any of these points against each other: both are closer than `reach` \[m\], and their normals there point apart.
/// Colliders along one limb, whose normals agree, do not.
pub(crate) fn between<T: Real>(points: &[V3<T>], solids: &[Solid<T>], reach: f64) -> Option<[usize; 2]> {
    let normals = |solid: &Solid<T>| -> Vec<V3<T>> {
        let solid = solid.coated(T::of(reach));
        let near = points.iter().filter(|p| may_touch(&solid, **p));
        near.filter_map(|p| Some(solid.exit(*p)?.normal)).collect()
    };
    let all: Vec<Vec<V3<T>>> = solids.iter().map(normals).collect();
    let oppose = |a: usize, b: usize| all[a].iter().any(|m| all[b].iter().any(|n| dot(*m, *n) < T::of(0.0)));
    (0..all.len()).find_map(|a| (a + 1..all.len()).find(|b| oppose(a, *b)).map(|b| [a, b]))
}

/// Whether a point is within the ball around a solid.
pub(crate) fn may_touch<T: Real>(solid: &Solid<T>, p: V3<T>) -> bool {
    let d = sub(p, solid.center);
    solid.around().is_none_or(|r| dot(d, d) <= r * r)
}
