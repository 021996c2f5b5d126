//! Contact with the surface of a body: a part of the pass of contact, on the CPU.
//!
//! At the start of a frame each particle finds the nearest point of the surface, from the triangle at which it was in the last frame, and gets the
//! plane there. The plane moves with the surface over the substeps, which cost one dot product per particle each ([`planes`]). A walk can end where
//! the surface is nearest only around there: so particles also try the triangles of their neighbours in the grid, and some of them per frame the
//! nearest of all patches. Particles far from the body are left out until it or they may have come near.

mod nearest;
mod planes;
mod skinned;

use std::sync::Arc;

use super::rows::Threads;
use super::sheet::Sheet;
use crate::cloth::{Cloth, Rows};
use crate::collider::surface::{BodySurface, FRICTION, NONE};
use crate::memory::Tally;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, add, cast, cross, dot, scale, sub};
use crate::step::Step;
use nearest::{On, Spot, walk};
use planes::{Plane, Planes};
use skinned::{Skinned, unit};

/// A particle that much \[m\] farther than it moves in a frame meets nothing in it.
const MARGIN_M: f64 = 0.006;
/// Ways of the last frame that a particle may go in the next.
const WAYS: f64 = 2.0;
/// A particle deeper \[m\] inside than this is left there: no normal tells where it came from.
const LOST_M: f64 = 0.04;
/// Frames in which each particle tries the nearest patch once.
const SEARCH_FRAMES: u32 = 32;
/// Least clearance \[m\] of cloth that was modelled nearer to the body.
const LEAST_CLEARANCE_M: f64 = 0.001;
/// A point nearer \[m\] to the surface than this has no direction from it.
const ON_SURFACE_M: f64 = 1e-5;

/// The last known nearest point of a particle.
#[derive(Clone, Copy)]
struct Hint<T> {
    /// Where the particle was then \[m\].
    at: V3<T>,
    /// Where it was in the last frame.
    last: V3<T>,
    /// Its distance then \[m\], at least 0.
    far: T,
    /// [`Worn::travel`] then.
    travel: T,
    /// [`NONE`] where it is not known.
    triangle: u32,
}

/// A duplicate of a seam point, and the one that finds its plane: sheet, place in [`Sheet::w`], place in [`Sheet::now`].
type Twin = [(usize, usize, usize); 2];

/// The surface that a cloth is worn on, and what its particles know of it.
pub struct Worn<T: Real> {
    surface: Arc<BodySurface>,
    skinned: Skinned<T>,
    planes: Vec<Planes<T>>,
    hints: Vec<Hint<T>>,
    /// The middles of patches at the start of the frame \[m\]; padded to whole blocks.
    middles: [Vec<T>; 3],
    /// The largest ways of the surface in all frames \[m\].
    travel: T,
    clearances: Vec<T>,
    /// The first duplicate of each particle.
    points: Vec<u32>,
    twins: Vec<Twin>,
    friction: T,
    /// Frames since all particles searched by the tree.
    frames: u32,
    /// Whether a frame has begun.
    due: bool,
}

impl<T: Real> Worn<T> {
    /// For a cloth that wears any; `place` has the sheet and the places of a particle, `thickness` \[m\] is that of cloth without its own.
    pub fn of(
        cloth: &Cloth,
        sheets: &[Sheet<T>],
        thickness: f32,
        place: impl Fn(usize) -> (usize, usize, usize),
    ) -> Option<Self> {
        let (surface, heights) = cloth.worn_on()?;
        let thickness = cloth.thickness.unwrap_or(thickness);
        let least = thickness.min(LEAST_CLEARANCE_M as f32);
        let points = cloth.points();
        let twin = |k: &u32| points[*k as usize] != *k && cloth.particles()[*k as usize].exists();
        let twins = (0..cloth.len() as u32).filter(twin).map(|k| [place(k as usize), place(points[k as usize] as usize)]);
        let zero = [T::of(0.0); 3];
        let hint = Hint { at: zero, last: zero, far: T::of(0.0), travel: T::of(0.0), triangle: NONE };
        let patches = surface.middles.len().next_multiple_of(LANES);
        let far = T::of(f64::from(f32::MAX.sqrt()));
        Some(Worn {
            skinned: Skinned::new(surface),
            planes: sheets.iter().map(Planes::new).collect(),
            hints: vec![hint; cloth.len()],
            middles: [0, 1, 2].map(|_| vec![far; patches]),
            travel: T::of(0.0),
            clearances: heights.iter().map(|h| T::of(f64::from(h.clamp(least, thickness)))).collect(),
            twins: twins.collect(),
            points,
            friction: T::of(f64::from((FRICTION * cloth.friction).min(f32::MAX))),
            frames: 0,
            due: false,
            surface: surface.clone(),
        })
    }

    /// As [`Skinned::lead`].
    pub fn lead(&mut self, matrices: &[Rows], rate: T) {
        self.skinned.lead(matrices, rate);
    }

    /// A frame begins.
    pub fn begin(&mut self) {
        self.due = true;
    }

    /// Searches all particles afresh in the next frame.
    pub fn forget(&mut self) {
        self.hints.iter_mut().for_each(|hint| hint.triangle = NONE);
        (self.frames, self.travel) = (0, T::of(0.0));
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.hints);
        tally.state(&self.clearances);
        tally.state(&self.points);
        tally.state(&self.twins);
    }

    /// Finds the planes of all particles, once a frame.
    pub fn search(&mut self, sheets: &[Sheet<T>], firsts: &[usize]) {
        if !std::mem::take(&mut self.due) {
            return;
        }
        self.skinned.begin();
        let pace = self.move_middles();
        self.travel = self.travel + pace;
        for (g, (sheet, first)) in sheets.iter().zip(firsts).enumerate() {
            self.planes[g].clear();
            for k in 0..sheet.width * sheet.height {
                let (particle, single) = (first + k, sheet.single(k));
                if sheet.w[single] <= T::of(0.0) || self.points[particle] as usize != particle {
                    continue;
                }
                let triple = sheet.triple(k);
                let p = sheet.at(triple);
                let size = (sheet.width, sheet.height);
                if let Some(plane) = self.plane(p, particle, beside(k, size, self.frames).map(|n| first + n), pace) {
                    self.planes[g].put((single, triple), sheet.half, &plane);
                }
            }
        }
        for [(g, single, triple), (from, first, at)] in &self.twins {
            if let Some(plane) = self.planes[*from].get((*first, *at), sheets[*from].half) {
                self.planes[*g].put((*single, *triple), sheets[*g].half, &plane);
            }
        }
        self.frames += 1;
    }

    /// Particles leave the surface; as [`planes::run`].
    pub fn run(&self, threads: &Threads, sheets: &mut [Sheet<T>], step: &Step<T>) {
        for (sheet, planes) in sheets.iter_mut().zip(&self.planes) {
            planes::run(threads, sheet, planes, self.friction, (step.dt, step.left));
        }
    }

    /// Moves the middles of patches to where they are at the start of the frame. Returns a bound on the way of the surface in it \[m\].
    fn move_middles(&mut self) -> T {
        let mut most = T::of(0.0);
        for (n, t) in self.surface.middles.iter().enumerate() {
            let [from, to] = self.skinned.ends(&self.surface, self.surface.triangles[*t as usize][0]);
            (0..3).for_each(|c| self.middles[c][n] = from[c]);
            let way = sub(to, from);
            most = most.max(dot(way, way));
        }
        // Points between the middles may go farther.
        most.sqrt() * T::of(1.25)
    }

    /// The plane that the particle at `p` meets in this frame, if it may meet any. `beside` is a neighbour of it, `pace` \[m\] the way of the surface.
    #[inline]
    fn plane(&mut self, p: V3<T>, particle: usize, beside: Option<usize>, pace: T) -> Option<Plane<T>> {
        let hint = self.hints[particle];
        let clearance = self.clearances[particle];
        let tries = (particle as u32).wrapping_add(self.frames) % SEARCH_FRAMES == 0;
        let mut reach = clearance + T::of(MARGIN_M);
        let mut spot = if hint.triangle == NONE {
            let found = self.skinned.search(&self.surface, p);
            if found == NONE {
                return None;
            }
            walk(&self.surface, &mut self.skinned, found, p)
        } else {
            reach = reach + T::of(WAYS) * length(sub(p, hint.last));
            self.hints[particle].last = p;
            let spent = length(sub(p, hint.at)) + (self.travel - hint.travel);
            if hint.far - spent > reach + pace && !tries {
                return None;
            }
            walk(&self.surface, &mut self.skinned, hint.triangle, p)
        };
        if let Some(other) = beside.map(|n| self.hints[self.points[n] as usize].triangle).filter(|t| *t != NONE) {
            // Within a patch the walk has been there.
            if self.surface.patch[other as usize] != self.surface.patch[spot.triangle as usize] {
                let found = walk(&self.surface, &mut self.skinned, other, p);
                self.take(&mut spot, found, p);
            }
        }
        if tries && hint.triangle != NONE {
            let patch = nearest_of(&self.middles, p);
            let start = self.surface.middles[patch];
            if self.surface.patch[spot.triangle as usize] as usize != patch {
                let found = walk(&self.surface, &mut self.skinned, start, p);
                self.take(&mut spot, found, p);
            }
        }
        let far = self.height(&spot, p).max(T::of(0.0));
        self.hints[particle] = Hint { at: p, last: p, far, travel: self.travel, triangle: spot.triangle };
        self.plane_at(&spot, p, clearance, reach)
    }

    /// Takes another point if it is nearer. A particle inside stays with the side that it came from.
    fn take(&mut self, spot: &mut Spot<T>, other: Spot<T>, p: V3<T>) {
        if other.distance2 < spot.distance2 {
            let (own, others) = (self.height(spot, p), self.height(&other, p));
            if !(own < T::of(0.0) && others >= T::of(0.0) && own > T::of(-LOST_M)) {
                *spot = other;
            }
        }
    }

    /// The distance of `p` from the surface at its nearest point, below 0 inside.
    fn height(&mut self, spot: &Spot<T>, p: V3<T>) -> T {
        let [(corners, normals), _] = self.skinned.both(&self.surface, spot.triangle);
        let d = sub(p, mix(&corners, spot.weights));
        let up = if spot.on == On::Face { face(&corners) } else { mix(&normals, spot.weights) };
        let far = spot.distance2.sqrt();
        if dot(d, up) < T::of(0.0) { -far } else { far }
    }

    /// The plane at a point of the surface, if `p` is within reach of it.
    fn plane_at(&mut self, spot: &Spot<T>, p: V3<T>, clearance: T, reach: T) -> Option<Plane<T>> {
        let far = spot.distance2.sqrt();
        let [(start, starts), (end, ends)] = self.skinned.both(&self.surface, spot.triangle);
        let [from, to] = [mix(&start, spot.weights), mix(&end, spot.weights)];
        let way = sub(to, from);
        if far > reach + length(way) {
            return None;
        }
        let d = sub(p, from);
        let [first, last] = match spot.on {
            On::Face => [unit(face(&start)), unit(face(&end))],
            _ => {
                let [first, last] = [unit(mix(&starts, spot.weights)), unit(mix(&ends, spot.weights))];
                let up = dot(d, first);
                if self.is_border(spot) && up.abs() < T::of(0.7) * far {
                    return None;
                }
                if up > T::of(0.0) && far > T::of(ON_SURFACE_M) {
                    let away = scale(d, T::of(1.0) / far);
                    [away, unit(add(away, sub(last, first)))]
                } else {
                    [first, last]
                }
            }
        };
        if dot(d, first) < T::of(-LOST_M) {
            return None;
        }
        let rate = self.skinned.rate();
        let (drift, turn) = (scale(way, rate), scale(sub(last, first), rate));
        Some(Plane { at: to, normal: last, drift, turn, clearance })
    }

    /// Whether a point is on the border of the surface.
    fn is_border(&self, spot: &Spot<T>) -> bool {
        let across = &self.surface.across[spot.triangle as usize];
        match spot.on {
            On::Face => false,
            On::Side(side) => across[side] == NONE,
            On::Corner(corner) => self.surface.border[self.surface.triangles[spot.triangle as usize][corner] as usize],
        }
    }
}

/// The heights \[m\] of points above a surface at rest, below 0 inside.
pub fn heights(surface: &Arc<BodySurface>, points: impl Iterator<Item = [f32; 3]>) -> Vec<f32> {
    let mut skinned = Skinned::<f64>::new(surface);
    skinned.begin();
    let height = |p: [f32; 3]| {
        let p = cast(p);
        let found = skinned.search(surface, p);
        let spot = walk(surface, &mut skinned, found, p);
        let [(corners, normals), _] = skinned.both(surface, spot.triangle);
        let up = if spot.on == On::Face { face(&corners) } else { mix(&normals, spot.weights) };
        let far = spot.distance2.sqrt();
        (if dot(sub(p, mix(&corners, spot.weights)), up) < 0.0 { -far } else { far }) as f32
    };
    points.map(height).collect()
}

/// A neighbour of texel `k` in its grid, another one in each of four frames.
fn beside(k: usize, (width, height): (usize, usize), frame: u32) -> Option<usize> {
    let (i, j) = (k % width, k / width);
    match frame & 3 {
        0 => (i > 0).then(|| k - 1),
        1 => (j > 0).then(|| k - width),
        2 => (i + 1 < width).then_some(k + 1),
        _ => (j + 1 < height).then_some(k + width),
    }
}

/// Twice the area of a triangle, along its normal.
#[inline]
fn face<T: Real>([a, b, c]: &[V3<T>; 3]) -> V3<T> {
    cross(sub(*b, *a), sub(*c, *a))
}

#[inline]
fn mix<T: Real>([a, b, c]: &[V3<T>; 3], w: V3<T>) -> V3<T> {
    add(add(scale(*a, w[0]), scale(*b, w[1])), scale(*c, w[2]))
}

#[inline]
fn length<T: Real>(v: V3<T>) -> T {
    dot(v, v).sqrt()
}

/// The first of the points nearest to `p`.
fn nearest_of<T: Real>(points: &[Vec<T>; 3], p: V3<T>) -> usize {
    let mut found = 0;
    widest(NearestOf { points, p, found: &mut found });
    found
}

struct NearestOf<'a, T> {
    points: &'a [Vec<T>; 3],
    p: V3<T>,
    found: &'a mut usize,
}

impl<T: Real> Work<T> for NearestOf<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let p = k.splats(self.p);
        let far = k.splat(T::of(f64::from(f32::MAX)));
        let (mut least, mut block) = (far, far);
        for at in (0..self.points[0].len()).step_by(K::WIDE) {
            let d = k.squares(k.minus(k.loads(self.points, at), p));
            let nearer = k.above(least, d);
            least = k.choose(nearer, d, least);
            block = k.choose(nearer, k.splat(T::of(at as f64)), block);
        }
        let mut lanes = [[T::of(0.0); LANES]; 2];
        k.store(&mut lanes[0], 0, least);
        k.store(&mut lanes[1], 0, block);
        // The first of those that are equally far, whatever the width of vectors.
        let mut best = (T::of(f64::from(f32::MAX)), T::of(0.0));
        for lane in 0..K::WIDE {
            let (d, at) = (lanes[0][lane], lanes[1][lane] + T::of(lane as f64));
            if d < best.0 || (d == best.0 && at < best.1) {
                best = (d, at);
            }
        }
        *self.found = best.1.get() as usize;
    }
}
