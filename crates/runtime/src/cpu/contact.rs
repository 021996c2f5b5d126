//! Twin of shaders/contact.wgsl: swept collision with moving colliders, and friction.

use super::colliders::rub;
use super::lanes::{LANES, each, points};
use super::real::{Real, V3, add, cross, dot, scale, sub};
use super::rows::Threads;
use super::sheet::{Sheet, planes, planes_ref};
use super::solid::Solid;

/// Rows that are done in one go.
const TOGETHER: usize = 8;

/// Particles inside a collider, or on its other side, go to its surface. Colliders out of reach of the sheet cost one
/// comparison, those out of reach of a block of particles another.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, solids: &[Solid<T>], dt: T) {
    let (lowest, highest) = bounds(sheet);
    let near: Vec<_> = solids.iter().map(|s| (s, Reach::new(s, dt))).filter(|(_, r)| r.box_near(lowest, highest)).collect();
    if near.is_empty() {
        return;
    }
    let (half, row) = (sheet.half, sheet.row());
    let (w, before) = (&sheet.w[..], &sheet.before[..]);
    threads.chunks(&mut sheet.now, TOGETHER * row, |chunk, rows| {
        for (n, now) in rows.chunks_exact_mut(row).enumerate() {
            let j = chunk * TOGETHER + n;
            let was = planes_ref(&before[j * row..(j + 1) * row], half);
            let w = &w[j * 2 * half..(j + 1) * 2 * half];
            let mut now = planes(now, half);
            for at in (0..2 * half).step_by(LANES) {
                for (solid, reach) in &near {
                    block(&mut now, was, w, at, solid, reach, dt);
                }
            }
        }
    });
}

#[inline(always)]
fn block<T: Real>(
    now: &mut [&mut [T]; 3],
    was: [&[T]; 3],
    w: &[T],
    at: usize,
    solid: &Solid<T>,
    reach: &Reach<T>,
    dt: T,
) {
    let p = points([&*now[0], &*now[1], &*now[2]], at);
    let b = points(was, at);
    if !reach.any_near(&p, &b) {
        return;
    }
    for k in (0..LANES).filter(|k| w[at + k] > T::of(0.0)) {
        let (p, b) = (p.map(|c| c[k]), b.map(|c| c[k]));
        if let Some(out) = meet(solid, p, b, dt) {
            (0..3).for_each(|c| now[c][at + k] = out[c]);
        }
    }
}

/// Where a particle that went from `was` to `at` in `dt` is put; none if it meets nothing.
#[inline]
pub fn meet<T: Real>(solid: &Solid<T>, at: V3<T>, was: V3<T>, dt: T) -> Option<V3<T>> {
    // Where it would have been before, had the collider always been where it is now.
    let carried = add(solid.velocity, cross(solid.spin, sub(was, solid.center)));
    let from = add(was, scale(carried, dt));
    let (out, normal) = swept(solid, from, at)?;
    let depth = sub(out, at);
    let out = if solid.friction > T::of(0.0) {
        rub(solid, out, normal, was, dot(depth, depth).sqrt(), dt)
    } else {
        out
    };
    // Sliding along a flat or hollow side can end inside again.
    Some(solid.exit(out).map_or(out, |(at, _)| at))
}

/// The way out of a solid at rest for a particle that went from `from` to `at`.
///
/// A step shorter than the solid is thick cannot pass it: the closest way out is right. A longer one leaves by the plane
/// that touches the solid where the path entered.
fn swept<T: Real>(solid: &Solid<T>, from: V3<T>, at: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let path = sub(at, from);
    let thick = solid.thickness();
    if dot(path, path) < thick * thick {
        return solid.exit(at);
    }
    if let Some((surface, normal)) = solid.exit(from) {
        // It began inside, as resting particles do by rounding: the plane is that of where it began.
        return out_by(at, surface, normal).or_else(|| solid.exit(at));
    }
    match solid.entry(from, path) {
        Some((surface, normal)) => out_by(at, surface, normal).or_else(|| solid.exit(at)),
        None => solid.exit(at),
    }
}

fn out_by<T: Real>(at: V3<T>, surface: V3<T>, normal: V3<T>) -> Option<(V3<T>, V3<T>)> {
    let deep = dot(sub(surface, at), normal);
    (deep > T::of(0.0)).then(|| (add(at, scale(normal, deep)), normal))
}

/// A ball or a half-space around all that a solid can touch within a step.
struct Reach<T> {
    center: V3<T>,
    /// Squared radius; none for a half-space.
    radius: Option<T>,
    normal: V3<T>,
}

impl<T: Real> Reach<T> {
    fn new(solid: &Solid<T>, dt: T) -> Self {
        let around = solid.around();
        let v = solid.velocity;
        let moves = dot(v, v).sqrt() * dt;
        let radius = around.map(|r| {
            let s = solid.spin;
            let turns = dot(s, s).sqrt() * dt * r;
            r + moves + turns
        });
        let normal = solid.up();
        Reach { center: solid.center, radius, normal }
    }

    fn box_near(&self, lowest: V3<T>, highest: V3<T>) -> bool {
        let zero = T::of(0.0);
        match self.radius {
            Some(r) => {
                let d = [0, 1, 2].map(|c| (lowest[c] - self.center[c]).max(self.center[c] - highest[c]).max(zero));
                // Written so that a box that is no number is near.
                !(dot(d, d) > r * r)
            }
            None => {
                let corner = [0, 1, 2].map(|c| if self.normal[c] > zero { lowest[c] } else { highest[c] });
                !(dot(sub(corner, self.center), self.normal) > zero)
            }
        }
    }

    /// Whether any lane comes near on its way: the ball around the way meets that of the solid.
    #[inline(always)]
    fn any_near(&self, p: &[[T; LANES]; 3], b: &[[T; LANES]; 3]) -> bool {
        let zero = T::of(0.0);
        let near: [bool; LANES] = match self.radius {
            Some(r) => {
                let d2 = squared(|c, k| p[c][k] - self.center[c]);
                let way2 = squared(|c, k| p[c][k] - b[c][k]);
                // |d| <= r + |way|, without a root: d^2 <= 2 (r^2 + way^2) is wider.
                std::array::from_fn(|k| !(d2[k] > r * r + way2[k] + (r * r * way2[k] * T::of(4.0)).sqrt()))
            }
            None => {
                let above = each(|k| {
                    (p[0][k] - self.center[0]) * self.normal[0]
                        + (p[1][k] - self.center[1]) * self.normal[1]
                        + (p[2][k] - self.center[2]) * self.normal[2]
                });
                std::array::from_fn(|k| !(above[k] > zero))
            }
        };
        near.iter().any(|n| *n)
    }
}

#[inline(always)]
fn squared<T: Real>(f: impl Fn(usize, usize) -> T) -> [T; LANES] {
    each(|k| f(0, k) * f(0, k) + f(1, k) * f(1, k) + f(2, k) * f(2, k))
}

/// The box around all particles now and before.
fn bounds<T: Real>(sheet: &Sheet<T>) -> (V3<T>, V3<T>) {
    let (half, row) = (sheet.half, sheet.row());
    let mut low = [[T::of(f64::from(f32::MAX)); LANES]; 3];
    let mut high = [[T::of(-f64::from(f32::MAX)); LANES]; 3];
    super::lanes::widest(
        #[inline(always)]
        || {
            for list in [&sheet.now, &sheet.before] {
                for (j, row) in list.chunks_exact(row).enumerate() {
                    let xyz = planes_ref(row, half);
                    for at in (0..2 * half).step_by(LANES) {
                        let p = points(xyz, at);
                        let w = super::lanes::load(&sheet.w, j * 2 * half + at);
                        let free = T::of(0.0);
                        for c in 0..3 {
                            low[c] = each(|k| if w[k] > free && p[c][k] < low[c][k] { p[c][k] } else { low[c][k] });
                            high[c] = each(|k| if w[k] > free && p[c][k] > high[c][k] { p[c][k] } else { high[c][k] });
                        }
                    }
                }
            }
        },
    );
    let fold = |lanes: [T; LANES], f: fn(T, T) -> T| lanes.into_iter().reduce(f).unwrap_or(T::of(0.0));
    (low.map(|l| fold(l, T::min)), high.map(|h| fold(h, T::max)))
}
