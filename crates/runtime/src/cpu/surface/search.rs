//! Twin of shaders/surface_search.wgsl: the planes that particles meet in a frame.

use super::contact::Plane;
use super::give::give;
use super::nearest::{faces_away, walk, walk_beyond};
use super::pose::{between, unit};
use super::{Hint, Pin, Worn, face, length, mix};
use crate::cloth::MODELLED_INSIDE_M;
use crate::cloth::surface::{BodySurface, NONE, On, Spot};
use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, V3, add, cast, cross, dot, scale, sub};

/// A particle that much \[m\] farther than it moves in a frame meets nothing in it.
pub const MARGIN_M: f64 = 0.006;
/// Ways of the last frame that a particle, or the surface near it, may go in the next.
pub const WAYS: f64 = 2.0;
/// The same for a particle whose motion in the last frame is not known: 6 m/s at 60 Hz.
pub const UNKNOWN_WAY_M: f64 = 0.1;
/// Frames for which a particle is left out, at most, and how much farther \[m\] the surface may come in each than it does now.
pub const MAX_WAIT: f64 = 3.0;
pub const FASTER_M: f64 = 0.008;
/// A particle deeper \[m\] inside than this is left there: no normal tells where it came from.
pub const LOST_M: f64 = 0.04;
/// A point that was found stays if the particle is not farther \[m\] beside it: on a limb of 5 cm that is 0.02 mm of height.
pub const BESIDE_M: f64 = 0.0015;
/// The same for each metre of height above that.
pub const BESIDE_PER_HEIGHT: f64 = 0.1;
/// Points of neighbours whose normals differ by less than this cosine are of the same side.
pub const SAME_COSINE: f64 = 0.7;
/// The farthest \[m\] that a second side of the surface may be, and the largest cosine between the normals of both.
pub const SECOND_M: f64 = 0.05;
pub const SECOND_COSINE: f64 = 0.3;
/// Two sides with a smaller cosine than this face each other.
pub const FACING_COSINE: f64 = -0.3;
/// Of two points on two sides of one part of the body, as sines of the heights at which each sees the other above its face: both are below the first, one is
/// below the second.
pub const LEVEL_SINE: f64 = 0.1;
pub const BACK_SINE: f64 = -0.3;
/// They are at most this many times as far from each other at rest as now.
pub const BACK_WAYS: f64 = 2.0;
/// Frames in which each particle tries the nearest patch once.
pub const SEARCH_FRAMES: u32 = 32;
/// One that meets nothing tries it each time that it looks, if it and the surface have gone farther \[m\] than this together.
pub const FAST_M: f64 = 0.008;
/// Cloth comes out of a body at a slant: up to this distance \[m\] from its pin where it is as long as the pin is deep, and a quarter of that; from twice the
/// distance on where it is as long.
pub const SLANT: f64 = 0.25;
pub const SLANT_M: f64 = 0.1;
/// Beside a border a particle farther from the normal than by the angle of this cosine has no surface below it.
pub const OPEN_COSINE: f64 = 0.7;
/// A point nearer \[m\] to the surface than this has no direction from it.
pub const ON_SURFACE_M: f64 = 1e-5;

/// A point of the surface, seen from a particle at the start of a frame.
#[derive(Clone, Copy)]
pub(super) struct View<T> {
    /// The distance of the particle \[m\], below 0 inside.
    pub height: T,
    /// How far \[m\] the particle is beside the normal there.
    beside: T,
    /// How the surface moves in the frame \[m\], how far, and where it is at the end.
    pub drift: V3<T>,
    pub way: T,
    pub to: V3<T>,
    /// The normal, and whether it is the direction of the particle.
    pub normal: V3<T>,
    straight: bool,
    /// From the point to the particle.
    from: V3<T>,
    /// Whether the particle is beside a border, with no surface below it.
    pub open: bool,
}

impl<T: Real> Worn<T> {
    /// Finds the planes of all particles, once a frame.
    pub fn search(&mut self, sheets: &[Sheet<T>], firsts: &[usize]) {
        if !std::mem::take(&mut self.due) {
            return;
        }
        self.skinned.begin();
        self.boxes.follow(&self.surface, &mut self.skinned);
        // Particles do not see what others find in this frame, so that their order has no effect.
        self.marks.clear();
        self.marks.extend(self.hints.iter().map(|hint| (hint.triangle, hint.normal, hint.second)));
        for (g, (sheet, first)) in sheets.iter().zip(firsts).enumerate() {
            self.planes.iter_mut().for_each(|planes| planes[g].clear());
            let size = (sheet.width, sheet.height);
            for k in 0..sheet.width * sheet.height {
                let (particle, single) = (first + k, sheet.single(k));
                let is_met = self.clearances[particle] >= T::of(-f64::from(MODELLED_INSIDE_M));
                if !is_met || sheet.w[single] <= T::of(0.0) || self.points[particle] as usize != particle {
                    continue;
                }
                let triple = sheet.triple(k);
                if self.waits[particle] > 0 {
                    self.waits[particle] -= 1;
                    let p = sheet.at(triple);
                    if self.boxes.passes(&self.skinned, p, sub(p, self.hints[particle].last), false).is_none() {
                        continue;
                    }
                }
                let pin = self.holds[particle].as_ref().and_then(|hold| hold.pin(sheets));
                let spans = self.spans.get(particle).filter(|_| pin.is_some());
                let clearance = self.clearances[particle] - spans.map_or(T::of(0.0), |spans| give(sheet, k, spans));
                let beside = beside(k, size, 1, self.frames).map(|n| first + n);
                let found = self.planes_of(sheet.at(triple), particle, beside, (clearance, pin));
                for (planes, plane) in self.planes.iter_mut().zip(found) {
                    plane.iter().for_each(|plane| planes[g].put((single, triple), sheet.half, plane));
                }
            }
        }
        for [(g, single, triple), (from, first, at)] in &self.twins {
            for planes in &mut self.planes {
                if let Some(plane) = planes[*from].get((*first, *at), sheets[*from].half) {
                    planes[*g].put((*single, *triple), sheets[*g].half, &plane);
                }
            }
        }
        self.frames = self.frames.wrapping_add(1);
    }

    /// The planes that the particle at `p` meets in this frame, if it may meet any. `beside` is a neighbour of it, `clearance` \[m\] the height that it
    /// keeps, `pin` what holds it.
    #[inline]
    fn planes_of(
        &mut self,
        p: V3<T>,
        particle: usize,
        beside: Option<usize>,
        (clearance, pin): (T, Option<Pin<T>>),
    ) -> [Option<Plane<T>>; 2] {
        let hint = self.hints[particle];
        let known = hint.triangle != NONE;
        let moved = length(sub(p, hint.last));
        let goes = if known { T::of(WAYS) * moved } else { T::of(UNKNOWN_WAY_M) };
        let reach = clearance + T::of(MARGIN_M) + goes;
        let (mut spot, mut view) = self.first(&hint, p);
        // A particle that comes nearer to another wall still has the one that it was at.
        let turns = known && dot(hint.normal, view.normal) < T::of(SECOND_COSINE);
        let mut second = if turns { hint.triangle } else { hint.second };
        // The nearest of those that a patch brought near in the last frame.
        if known && hint.second != NONE && moved + view.way > T::of(FAST_M) {
            self.compare((&mut spot, &mut view, &mut second), hint.second, p);
        }
        if let Some(n) = beside {
            let (triangle, normal, other) = self.marks[self.points[n] as usize];
            if triangle != NONE && dot(normal, view.normal) < T::of(SAME_COSINE) {
                self.compare((&mut spot, &mut view, &mut second), triangle, p);
            }
            if second == NONE {
                second = other;
            }
        }
        // Another part of the body may have come where a particle knows none near.
        let is_due = (particle as u32).wrapping_add(self.frames).is_multiple_of(SEARCH_FRAMES)
            || (view.height > reach && moved + view.way > T::of(FAST_M));
        if known && is_due {
            let patch = self.boxes.patch(p);
            if self.surface.patch[spot.triangle as usize] as usize != patch {
                self.compare((&mut spot, &mut view, &mut second), self.surface.middles[patch], p);
            }
        }
        let mut planes = [None, None];
        if is_met(&view, reach) {
            planes[0] = Some(self.plane(&spot, &view, kept(clearance, &pin, p, (view.from, view.normal))));
        }
        if second != NONE {
            let other = walk_beyond(&self.surface, &mut self.skinned, (second, Some(view.normal)), p);
            let side = self.view(&other, p);
            let is_other = side.height.abs() < T::of(SECOND_M)
                && faces_away(&self.surface, &mut self.skinned, other.triangle, view.normal)
                && !(side.height < T::of(0.0)
                    && is_back(&self.surface, (&spot, &other), length(sub(side.from, view.from))));
            second = if is_other { other.triangle } else { NONE };
            // However far it is: a particle in a crease may be thrown from one wall to the other in a frame.
            if is_other && is_met_beside(&other, &side) {
                planes[1] = Some(self.plane(&other, &side, kept(clearance, &pin, p, (side.from, side.normal))));
            }
            if let ([Some(first), Some(last)], true) =
                (&mut planes, dot(view.normal, side.normal) < T::of(FACING_COSINE))
            {
                let half = squeezed(&view, &side, clearance);
                (first.clearance, last.clearance) = (first.clearance.min(half), last.clearance.min(half));
            }
        }
        let goes = sub(p, hint.last);
        let comes = if known { self.boxes.passes(&self.skinned, p, goes, true) } else { None };
        let struck = comes.and_then(|patch| self.struck((patch, spot.triangle), (p, goes), (clearance, &pin), &planes));
        if let Some(struck) = &struck {
            planes = [Some(struck.plane), planes[1].or(planes[0])];
        }
        let nearer = moved + view.way + T::of(FASTER_M);
        let wait = (view.height - reach - view.way) / nearer;
        let wait = if known { wait.min(T::of(MAX_WAIT)).max(T::of(0.0)).get() as u8 } else { 0 };
        self.waits[particle] = wait;
        if let Some(struck) = struck {
            let nearer = struck.view.height.abs() < struck.other.abs();
            let other = if nearer { spot.triangle } else { struck.spot.triangle };
            if nearer {
                (spot, view) = (struck.spot, struck.view);
            }
            if second == NONE || second == spot.triangle {
                second = other;
            }
        }
        let Spot { triangle, weights, on, .. } = spot;
        let (way, normal) = (view.from, view.normal);
        self.hints[particle] = Hint { last: p, way, normal, weights, triangle, second, on };
        planes
    }

    /// The nearest point from where the last one was.
    fn first(&mut self, hint: &Hint<T>, p: V3<T>) -> (Spot<T>, View<T>) {
        if hint.triangle == NONE {
            let found = self.boxes.search(&self.surface, &mut self.skinned, p);
            let spot = walk(&self.surface, &mut self.skinned, found, p);
            return (spot, self.view(&spot, p));
        }
        let Hint { triangle, weights, on, .. } = *hint;
        let spot = Spot { triangle, weights, distance2: T::of(0.0), on };
        let mut view = self.view(&spot, p);
        // Near a side or a corner the surface bends, and the next face may be nearer already.
        let bends = on != On::Face && view.height < T::of(MARGIN_M);
        if view.height > T::of(-BESIDE_M) && !view.open && !bends {
            // Beside the way of the walk; without it a side or a corner would always be straight below.
            let beside = if on == On::Face { view.beside } else { length(cross(hint.way, view.normal)) };
            if beside < T::of(BESIDE_M) + T::of(BESIDE_PER_HEIGHT) * view.height.max(T::of(0.0)) {
                if on != On::Face {
                    view.from = hint.way;
                }
                return (Spot { distance2: view.height * view.height, ..spot }, view);
            }
        }
        let spot = walk(&self.surface, &mut self.skinned, hint.triangle, p);
        (spot, self.view(&spot, p))
    }

    /// Takes the point that a walk from another triangle finds if it is nearer; the farther one becomes the second, if it is of another side.
    fn compare(&mut self, (spot, view, second): (&mut Spot<T>, &mut View<T>, &mut u32), from: u32, p: V3<T>) {
        let other = walk(&self.surface, &mut self.skinned, from, p);
        if other.triangle == spot.triangle {
            return;
        }
        let side = self.view(&other, p);
        let nearer = side.height.abs() < view.height.abs();
        let farther = if nearer { spot.triangle } else { other.triangle };
        if is_second(view, &side) {
            *second = farther;
        }
        if nearer {
            (*spot, *view) = (other, side);
        }
    }

    /// A point of the surface, seen from `p`, at the time of [`Skinned::look`].
    pub(super) fn view(&mut self, spot: &Spot<T>, p: V3<T>) -> View<T> {
        let time = self.skinned.time();
        let [a, b, c] = self.skinned.vertices(&self.surface, spot.triangle);
        let w = spot.weights;
        let [start, to] = [0, 1].map(|end| mix(&[a.at[end], b.at[end], c.at[end]], w));
        let at = if time > T::of(0.0) { between(&[start, to], time) } else { start };
        let from = sub(p, at);
        let far2 = dot(from, from);
        let far = far2.sqrt();
        let (mut open, mut straight) = (false, false);
        let normal = match spot.on {
            On::Face if time > T::of(0.0) => unit(face(&[a, b, c].map(|v| between(&v.at, time)))),
            On::Face => unit(face(&[a.at[0], b.at[0], c.at[0]])),
            _ => {
                let smooth = match time > T::of(0.0) {
                    true => unit(mix(&[a, b, c].map(|v| between(&v.normal, time)), w)),
                    false => unit(mix(&[a.normal[0], b.normal[0], c.normal[0]], w)),
                };
                let up = dot(from, smooth);
                open = self.surface.is_border(spot) && up.abs() < T::of(OPEN_COSINE) * far;
                straight = up > T::of(0.0) && far > T::of(ON_SURFACE_M);
                if straight { scale(from, T::of(1.0) / far) } else { smooth }
            }
        };
        let up = dot(from, normal);
        let height = if up < T::of(0.0) { -far } else { far };
        let beside = (far2 - up * up).max(T::of(0.0)).sqrt();
        let drift = sub(to, start);
        View { height, beside, drift, way: length(drift), to, normal, straight, from, open }
    }

    /// The plane at a point of the surface.
    fn plane(&mut self, spot: &Spot<T>, view: &View<T>, clearance: T) -> Plane<T> {
        let rate = self.skinned.rate();
        let mut last = view.normal;
        if rate > T::of(0.0) {
            let [a, b, c] = self.skinned.vertices(&self.surface, spot.triangle);
            let smooth = |end: usize| unit(mix(&[a.normal[end], b.normal[end], c.normal[end]], spot.weights));
            last = match (spot.on, view.straight) {
                (On::Face, _) => unit(face(&[a.at[1], b.at[1], c.at[1]])),
                (_, true) => unit(add(view.normal, sub(smooth(1), smooth(0)))),
                (_, false) => smooth(1),
            };
        }
        let (drift, turn) = (scale(view.drift, rate), scale(sub(last, view.normal), rate));
        Plane { at: view.to, normal: last, drift, turn, clearance }
    }
}

/// The height \[m\] that a particle at `p` keeps above a point of the surface; `from` is the vector from that point to the particle. If a pose puts the
/// pin that holds the particle deeper into the body than it was modelled, the height is at most what the length of cloth between the particle and the pin
/// allows. Without this limit, contact would push the cloth beside the pin out on both sides and stretch it.
pub(super) fn kept<T: Real>(clearance: T, pin: &Option<Pin<T>>, p: V3<T>, (from, normal): (V3<T>, V3<T>)) -> T {
    let Some(pin) = pin else { return clearance };
    let (zero, near) = (T::of(0.0), T::of(SLANT_M));
    let height = dot(add(sub(pin.at, p), from), normal) + pin.modelled;
    // Cloth that is far from its pin may be on another side of the body, with the pin outside.
    let slant = T::of(SLANT) * ((near + near - pin.most) / near).max(zero).min(T::of(1.0));
    clearance.min(height + height.min(zero) * slant + pin.most)
}

/// Whether a particle may meet a plane in a frame.
fn is_met<T: Real>(view: &View<T>, reach: T) -> bool {
    !view.open && view.height <= reach + view.way && view.height > T::of(-LOST_M)
}

/// Whether a particle meets the plane of a second side. A walk that ends where a wall does sees no depth from there.
fn is_met_beside<T: Real>(spot: &Spot<T>, view: &View<T>) -> bool {
    !view.open && view.height > T::of(-LOST_M) && (spot.on == On::Face || view.height > T::of(-MARGIN_M))
}

/// Whether two points are on two sides of one part of the body, such as a plate or the rim of a neck: at rest neither is in front of the face of the
/// other. Walls of a crease are, or are farther from each other there than the `apart` \[m\] of now, such as a heel and a robe.
fn is_back<T: Real>(surface: &BodySurface, (one, other): (&Spot<T>, &Spot<T>), apart: T) -> bool {
    let corners = |t: u32| surface.triangles[t as usize].map(|v| cast(surface.rest[v as usize]));
    let [a, b]: [[V3<T>; 3]; 2] = [corners(one.triangle), corners(other.triangle)];
    let way = sub(mix(&b, other.weights), mix(&a, one.weights));
    let far = length(way);
    if far > apart * T::of(BACK_WAYS) {
        return false;
    }
    let (there, here) = (dot(way, unit(face(&a))), dot(scale(way, T::of(-1.0)), unit(face(&b))));
    there.max(here) < T::of(LEVEL_SINE) * far && there.min(here) < T::of(BACK_SINE) * far
}

/// The clearance between two sides that face each other, such as an arm and a chest: half of the gap between them, at its narrowest in the frame, as
/// both clearances may not fit. Where the sides overlap it is 0: particles go out of the crease from step to step, and stay on the first side, at which
/// they are.
fn squeezed<T: Real>(first: &View<T>, last: &View<T>, clearance: T) -> T {
    let zero = T::of(0.0);
    let closes = dot(sub(first.drift, last.drift), first.normal).max(zero);
    (T::of(0.5) * (first.height + last.height - closes)).max(zero).min(clearance)
}

/// Whether a point is of another side of the surface than the nearest one, and near enough to be met.
fn is_second<T: Real>(nearest: &View<T>, other: &View<T>) -> bool {
    other.height.abs() < T::of(SECOND_M) && dot(nearest.normal, other.normal) < T::of(SECOND_COSINE)
}

/// The texel of a grid some cells from texel `k`: to the left, above, to the right or below, on another side in each of four frames.
pub fn beside(k: usize, (width, height): (usize, usize), cells: usize, side: u32) -> Option<usize> {
    let (i, j) = (k % width, k / width);
    match side & 3 {
        0 => (i >= cells).then(|| k - cells),
        1 => (j >= cells).then(|| k - cells * width),
        2 => (i + cells < width).then_some(k + cells),
        _ => (j + cells < height).then_some(k + cells * width),
    }
}
