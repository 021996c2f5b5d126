//! The report of a cleared start.

use std::fmt;

use super::net::Net;
use super::obstacles::Obstacles;
use super::relax::CLOSE_M;
use crate::cloth::Cloth;
use crate::health::{Stretch, stretch};
use crate::number::real::V3;

/// Result of [`crate::Scene::clear_start`] for a cloth: particles that began inside, and those that are left. Seam duplicates count once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClearedStart {
    /// The index of the cloth.
    pub cloth: usize,
    /// Its name.
    pub name: String,
    /// Free points of the cloth.
    pub free: usize,
    /// Those of them that began inside a body or a collider, or behind a garment of a layer below.
    pub inside: usize,
    /// Their mean and their largest depth \[m\].
    pub depth: [f64; 2],
    /// Points that were moved, and the longest way \[m\].
    pub moved: usize,
    /// The longest way \[m\] of them.
    pub farthest: f64,
    /// Free points that are still inside.
    pub left: usize,
    /// The deepest of them \[m\].
    pub left_depth: f64,
    /// Pinned points that are inside, which stay there, and keep the cloth around them inside.
    pub pins: usize,
    /// The deepest of them \[m\].
    pub pins_depth: f64,
    /// Extension of springs before and after; `None` of cloth that is cut.
    pub stretch: Option<[Stretch; 2]>,
}

impl ClearedStart {
    /// Of a cloth in which nothing was found yet.
    pub(super) fn new(cloth: usize, of: &Cloth, net: &Net) -> Self {
        let free = net.free.iter().filter(|free| **free).count();
        ClearedStart { cloth, name: of.name().into(), free, ..ClearedStart::default() }
    }

    /// Takes in the points of a garment before it is cleared.
    pub(super) fn before(&mut self, net: &Net, points: &[u32], obstacles: &Obstacles) {
        for (point, depth) in depths(net, points, obstacles) {
            if net.free[point] {
                let sum = self.depth[0] * self.inside as f64 + depth;
                self.inside += 1;
                self.depth = [sum / self.inside as f64, self.depth[1].max(depth)];
            } else {
                self.pins += 1;
                self.pins_depth = self.pins_depth.max(depth);
            }
        }
    }

    /// Takes in the points of a garment after it was cleared.
    pub(super) fn after(&mut self, net: &Net, points: &[u32], obstacles: &Obstacles) {
        for (_, depth) in depths(net, points, obstacles).into_iter().filter(|(point, _)| net.free[*point]) {
            self.left += 1;
            self.left_depth = self.left_depth.max(depth);
        }
        for way in points.iter().map(|point| net.way(*point as usize)).filter(|way| *way > CLOSE_M) {
            self.moved += 1;
            self.farthest = self.farthest.max(way);
        }
    }

    /// Compares the springs of the cloth, which has moved from `before` \[m\].
    pub(super) fn compare(&mut self, cloth: &Cloth, before: &[[f32; 3]]) {
        let of = |list: &[[f32; 3]]| {
            let at = |(k, p): (usize, &[f32; 3])| [p[0], p[1], p[2], cloth.inverse_mass(k)];
            stretch(cloth, &list.iter().enumerate().map(at).collect::<Vec<_>>())
        };
        self.stretch = of(before).zip(of(cloth.positions())).map(|(a, b)| [a, b]);
    }
}

/// Points that are inside, with their depths \[m\].
fn depths(net: &Net, points: &[u32], obstacles: &Obstacles) -> Vec<(usize, f64)> {
    let at = |point: usize| -> V3<f64> { net.at[point] };
    let each = points.iter().map(|point| (*point as usize, obstacles.depth(*point as usize, at(*point as usize))));
    each.filter(|(_, depth)| *depth > CLOSE_M).collect()
}

impl fmt::Display for ClearedStart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |x: f64| format!("{:.1} mm", 1e3 * x);
        let ClearedStart { name, free, inside, depth, moved, farthest, left, pins, .. } = self;
        write!(
            f,
            "cloth '{name}': {inside} of {free} free particles began inside a body, a collider or a layer below (mean {}, at most {}); \
             {moved} moved, by at most {}",
            mm(depth[0]),
            mm(depth[1]),
            mm(*farthest)
        )?;
        if *left > 0 {
            let are = if *left == 1 { "is" } else { "are" };
            write!(f, "; {left} {are} still inside, at most {}", mm(self.left_depth))?;
        }
        if *pins > 0 {
            let (particles, stay) = if *pins == 1 { ("particle is", "stays") } else { ("particles are", "stay") };
            write!(f, "; {pins} pinned {particles} inside, at most {}, and {stay} there", mm(self.pins_depth))?;
        }
        if let Some([before, after]) = self.stretch.filter(|[before, after]| after.max > before.max + 0.01) {
            write!(
                f,
                "; springs are up to {:.0} % longer than at rest, {:.0} % before",
                100.0 * after.max,
                100.0 * before.max
            )?;
        }
        Ok(())
    }
}
