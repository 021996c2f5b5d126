//! How a cloth fares: stretch, speed, depth in colliders, height. Measured in one pass, about 20 ns per particle.

use crate::cloth::Cloth;
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
    /// Largest depth \[m\] of a particle inside a collider, thickness of the cloth included; 0 outside of all.
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

/// The largest and the 99th percentile of extensions, and their mean.
pub(crate) fn stretch<T: Real>(cloth: &Cloth, now: &[[T; 4]]) -> Option<Stretch> {
    if cloth.is_cut() {
        return None;
    }
    let mut all = Vec::with_capacity(2 * now.len());
    let mut sum = 0.0;
    for (index, grid) in cloth.grids().iter().enumerate() {
        for (local, k) in grid.range().enumerate() {
            for direction in 0..2 {
                let rest = f64::from(cloth.spring(index, local, direction));
                let other = cloth.neighbour(index, local, direction);
                let Some(other) = other.filter(|_| rest > 0.0) else { continue };
                if now[k][3].get() + now[other][3].get() <= 0.0 {
                    continue;
                }
                let d = sub(xyz(now[k]), xyz(now[other]));
                let extension = (dot(d, d).sqrt().get() / rest - 1.0).max(0.0);
                sum += extension;
                all.push(extension as f32);
            }
        }
    }
    let max = f64::from(all.iter().copied().fold(0.0, f32::max));
    let (count, rank) = (all.len(), all.len() * 99 / 100);
    let p99 = if count > 0 { f64::from(*all.select_nth_unstable_by(rank, f32::total_cmp).1) } else { 0.0 };
    Some(Stretch { mean: sum / f64::max(count as f64, 1.0), p99, max })
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
        let depth = near.filter_map(|p| {
            let d = sub(solid.exit(p)?.0, p);
            Some(dot(d, d).sqrt().get())
        });
        depth.fold(0.0, f64::max)
    };
    solids.iter().map(deepest).collect()
}

fn may_touch<T: Real>(solid: &Solid<T>, p: V3<T>) -> bool {
    let d = sub(p, solid.center);
    solid.around().is_none_or(|r| dot(d, d) <= r * r)
}
