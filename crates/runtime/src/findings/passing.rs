//! Search for particles that went through a collider within a frame.
//!
//! The rule is [`Core::passed`], for one particle. Groups of particles are first compared with vectors of colliders by their bounding
//! balls, then the particles of a group with each collider that is left. Both comparisons leave out only what cannot have passed.

use super::CORE;
use crate::collider::solid::Solid;
use crate::number::aligned::Aligned;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, xyz};

/// Particles that went through one collider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    pub collider: usize,
    pub particles: usize,
    /// The first of them.
    pub particle: usize,
}

/// Numbers of a collider in [`Cores::lists`]: center, axis, half length and radius of a capsule around its core, and how far \[m\] its
/// center goes and how far \[rad\] it turns in the frame.
const NUMBERS: usize = 10;

/// The inner part of a collider that a particle cannot reach without going through.
struct Core<T> {
    collider: usize,
    solid: Solid<T>,
    still: bool,
    axis: V3<T>,
    half: T,
    radius: T,
}

/// The cores of all colliders that have another side, also as vectors of colliders.
struct Cores<T: Real> {
    each: Vec<Core<T>>,
    /// Of vector after vector of [`LANES`] colliders, number by number.
    lists: Aligned<T>,
    frame: T,
}

/// Particles that went from `was` to `now` in a frame of `frame` \[s\], and through a collider: one entry per such collider, in the order of
/// colliders, which are as at the end of the frame. Positions have the inverse mass as fourth number.
pub fn search<T: Real>(solids: &[Solid<T>], now: &[[T; 4]], was: &[[T; 4]], frame: f64) -> Vec<Passing> {
    let cores = Cores::new(solids, T::of(frame));
    let mut near = Vec::new();
    widest(Search { cores: &cores, now, was, near: &mut near });
    near.sort_unstable();
    let passed = |(index, k): &(usize, usize)| {
        let core = cores.each.get(*index)?;
        core.passed(xyz(was[*k]), xyz(now[*k]), cores.frame).then_some((core.collider, *k))
    };
    let mut all: Vec<Passing> = Vec::new();
    for (collider, particle) in near.iter().filter_map(passed) {
        match all.last_mut().filter(|last| last.collider == collider) {
            Some(last) => last.particles += 1,
            None => all.push(Passing { collider, particles: 1, particle }),
        }
    }
    all
}

impl<T: Real> Core<T> {
    fn new(collider: usize, solid: &Solid<T>) -> Option<Self> {
        let core = solid.coated(solid.thickness() * T::of(-CORE));
        let around = core.around()?;
        let [half, radius] = core.line().unwrap_or([T::of(0.0), around]);
        let size = core.center.iter().fold(T::of(0.0), |sum, x| sum + x.abs());
        let still = dot(solid.velocity, solid.velocity) + dot(solid.spin, solid.spin) == T::of(0.0);
        Some(Core { collider, solid: core, still, axis: core.up(), half, radius: radius + size * T::of(1e-6) })
    }

    /// Whether a particle was outside and went in.
    fn passed(&self, was: V3<T>, now: V3<T>, frame: T) -> bool {
        let from = if self.still { was } else { self.carried(was, frame) };
        self.solid.exit(from).is_none() && self.solid.entry(from, sub(now, from)).is_some()
    }

    /// Where a point fixed to it is at the end of the frame.
    fn carried(&self, p: V3<T>, frame: T) -> V3<T> {
        let Solid { velocity, spin, .. } = self.solid;
        let arm = sub(p, sub(self.solid.center, scale(velocity, frame)));
        add(p, scale(add(velocity, cross(spin, arm)), frame))
    }

    /// Whether any particle of a vector that went from `was` to `now` may have passed. NaN has not.
    #[inline(always)]
    fn may_pass<K: Machine<T>>(&self, k: K, was: [K::V; 3], now: [K::V; 3], frame: T) -> K::M {
        let Solid { center, velocity, spin, .. } = self.solid;
        let (frame_v, start) = (k.splat(frame), sub(center, scale(velocity, frame)));
        let turned = k.cross(k.splats(spin), k.minus(was, k.splats(start)));
        let from = k.plus(was, k.times(k.plus(k.splats(velocity), turned), frame_v));
        let share = k.splat(T::of(0.5));
        let way = k.times(k.minus(now, from), share);
        let d = k.minus(k.times(k.plus(from, now), share), k.splats(center));
        let axis = k.splats(self.axis);
        let along = k.least(k.most(k.dot(d, axis), k.splat(-self.half)), k.splat(self.half));
        let d = k.minus(d, k.times(axis, along));
        // Without a root: (radius + way)^2 is at most 2 (radius^2 + way^2).
        let reach2 = k.mul(k.splat(T::of(2.02)), k.add(k.splat(self.radius * self.radius), k.squares(way)));
        k.at_least(reach2, k.squares(d))
    }
}

impl<T: Real> Cores<T> {
    fn new(solids: &[Solid<T>], frame: T) -> Self {
        let each: Vec<_> = solids.iter().enumerate().filter_map(|(n, solid)| Core::new(n, solid)).collect();
        let mut lists = Aligned::zeros(each.len().div_ceil(LANES) * LANES * NUMBERS);
        let length = |v: V3<T>| dot(v, v).sqrt() * frame;
        for (n, block) in lists.chunks_exact_mut(LANES * NUMBERS).enumerate() {
            // No ball is near a radius of less than nothing.
            block[7 * LANES..8 * LANES].fill(T::of(-1e30));
            for (lane, core) in each.iter().skip(n * LANES).take(LANES).enumerate() {
                let ([x, y, z], [a, b, c]) = (core.solid.center, core.axis);
                let ways = [length(core.solid.velocity), length(core.solid.spin)];
                let numbers = [x, y, z, a, b, c, core.half, core.radius, ways[0], ways[1]];
                numbers.into_iter().enumerate().for_each(|(of, x)| block[of * LANES + lane] = x);
            }
        }
        Cores { each, lists, frame }
    }
}

/// A ball around free particles now and before, and a length above all rounding of distances to it.
struct Ball<T> {
    center: V3<T>,
    radius: T,
    slack: T,
}

impl<T: Real> Ball<T> {
    /// None if no particle is free. NaN is left out.
    fn around(now: &[[T; 4]], was: &[[T; 4]]) -> Option<Self> {
        let most = T::of(f64::from(f32::MAX));
        let (mut low, mut high, mut any) = ([most; 4], [-most; 4], false);
        for (p, b) in now.iter().zip(was).filter(|(p, _)| p[3] > T::of(0.0)) {
            any = true;
            for c in 0..4 {
                for x in [p[c], b[c]] {
                    low[c] = if x < low[c] { x } else { low[c] };
                    high[c] = if x > high[c] { x } else { high[c] };
                }
            }
        }
        let half = T::of(0.5);
        let center = [0, 1, 2].map(|c| low[c] * half + high[c] * half);
        let d = [0, 1, 2].map(|c| high[c] * half - low[c] * half);
        let size = [0, 1, 2].iter().fold(T::of(0.0), |sum, c| sum + low[*c].abs().max(high[*c].abs()));
        any.then_some(Ball { center, radius: dot(d, d).sqrt(), slack: size * T::of(1e-5) })
    }

    /// Whether particles in it may have passed a core, for a vector of cores at `at` of `numbers`.
    #[inline(always)]
    fn near<K: Machine<T>>(&self, k: K, numbers: &[T], at: usize) -> K::M {
        let of = |n: usize| &numbers[n * LANES..(n + 1) * LANES];
        let d = k.minus(k.splats(self.center), [k.load(of(0), at), k.load(of(1), at), k.load(of(2), at)]);
        let axis = [k.load(of(3), at), k.load(of(4), at), k.load(of(5), at)];
        let half = k.load(of(6), at);
        let along = k.least(k.most(k.dot(d, axis), k.sub(k.splat(T::of(0.0)), half)), half);
        let apart = k.sqrt(k.squares(k.minus(d, k.times(axis, along))));
        let (goes, turns) = (k.load(of(8), at), k.load(of(9), at));
        let own = k.splat(self.radius);
        // A point of the ball is carried by this, as its arm is from where the center was.
        let arm = k.add(k.add(k.sqrt(k.squares(d)), goes), own);
        let reach = k.add(k.add(k.load(of(7), at), own), k.add(goes, k.mul(turns, arm)));
        let reach = k.add(k.mul(reach, k.splat(T::of(1.001))), k.splat(self.slack));
        // An infinite ball is near everything, also where distances are NaN.
        let all = k.at_least(own, own);
        k.without(all, k.above(apart, reach))
    }
}

struct Search<'a, T: Real> {
    cores: &'a Cores<T>,
    now: &'a [[T; 4]],
    was: &'a [[T; 4]],
    /// Index of a core, and a particle.
    near: &'a mut Vec<(usize, usize)>,
}

impl<T: Real> Work<T> for Search<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (one, zero) = (k.splat(T::of(1.0)), k.splat(T::of(0.0)));
        let groups = self.now.chunks(LANES).zip(self.was.chunks(LANES));
        for (group, (now, was)) in groups.enumerate() {
            let Some(ball) = Ball::around(now, was) else { continue };
            let mut lists = None;
            let blocks = self.cores.lists.chunks_exact(LANES * NUMBERS).zip(self.cores.each.chunks(LANES));
            for (block, (numbers, cores)) in blocks.enumerate() {
                let mut marks = [T::of(0.0); LANES];
                let mut any = false;
                for at in (0..LANES).step_by(K::WIDE) {
                    let near = ball.near(k, numbers, at);
                    any |= k.any(near);
                    k.store(&mut marks, at, k.choose(near, one, zero));
                }
                if !any {
                    continue;
                }
                let [xs, ys, zs, us, vs, ws] = lists.get_or_insert_with(|| planes(now, was));
                for (n, core) in cores.iter().enumerate().filter(|(n, _)| marks[*n] > T::of(0.0)) {
                    for at in (0..LANES).step_by(K::WIDE) {
                        let now = [k.load(xs, at), k.load(ys, at), k.load(zs, at)];
                        let was = [k.load(us, at), k.load(vs, at), k.load(ws, at)];
                        let near = core.may_pass(k, was, now, self.cores.frame);
                        if k.any(near) {
                            let mut marks = [T::of(0.0); LANES];
                            k.store(&mut marks, at, k.choose(near, one, zero));
                            let lanes = (at..at + K::WIDE).filter(|lane| marks[*lane] > T::of(0.0));
                            self.near.extend(lanes.map(|lane| (block * LANES + n, group * LANES + lane)));
                        }
                    }
                }
            }
        }
    }
}

/// Coordinates of a group now and before; NaN for particles that are not free.
fn planes<T: Real>(now: &[[T; 4]], was: &[[T; 4]]) -> [[T; LANES]; 6] {
    let mut lists = [[T::of(f64::NAN); LANES]; 6];
    for (n, (p, b)) in now.iter().zip(was).enumerate().filter(|(_, (p, _))| p[3] > T::of(0.0)) {
        for c in 0..3 {
            (lists[c][n], lists[3 + c][n]) = (p[c], b[c]);
        }
    }
    lists
}

#[cfg(test)]
mod tests;
