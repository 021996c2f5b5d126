//! Twin of shaders/contact.wgsl: swept collision with moving colliders, and friction.
//!
//! The rule is [`meet`], for one particle. Most particles go a way that is short beside the collider, where the rule is the
//! way out alone: `wide` does that for a vector of them at a time, with the same bits. `rows` finds the colliders that a vector meets.

pub mod clear;
mod crowd;
mod reach;
mod rows;
mod wide;

use super::colliders::{moved_by, rub};
use super::rows::Threads;
use super::sheet::Sheet;
use crate::collider::solid::{Exit, Solid};
use crate::number::lanes::{LANES, widest};
use crate::number::real::{Real, V3, add, dot, scale, sub};
use clear::Clear;
use crowd::Crowd;
use reach::{Reach, bounds};
use rows::{Lists, Rows};

/// Rows that are done in one go.
const TOGETHER: usize = 8;

/// Groups of colliders that have a bit each in the lists of blocks.
const GROUPS: usize = u64::BITS as usize;

/// A collider that a sheet can touch.
struct Near<'a, T> {
    index: usize,
    solid: &'a Solid<T>,
    reach: &'a Reach<T>,
    /// How far \[m\] its surface can move in the rest of the frame.
    ahead: T,
}

/// Colliders as they are in a step, and what each can touch in it.
pub struct Posed<T> {
    all: Vec<(Solid<T>, Reach<T>)>,
    dt: T,
    left: T,
}

impl<T: Real> Posed<T> {
    /// Of a step of `dt` \[s\], after which `left` \[s\] of the frame are to go.
    pub fn new(solids: impl Iterator<Item = Solid<T>>, dt: T, left: T) -> Self {
        let all = solids.map(|solid| (solid, Reach::new(&solid, dt))).collect();
        Posed { all, dt, left }
    }
}

/// Particles inside a collider, or on its other side, go to its surface.
/// Colliders out of reach of the sheet cost one comparison, those out of reach of a block of particles one per frame.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, clear: &mut Clear<T>, solids: &Posed<T>) {
    let (dt, left) = (solids.dt, solids.left);
    let (lowest, highest) = bounds(sheet);
    let near = in_reach((lowest, highest), &solids.all, left / dt);
    if near.is_empty() {
        clear.forget();
        return;
    }
    // Colliders of a group follow one another, so that groups in order are colliders in order.
    let group = near.len().div_ceil(GROUPS);
    let alone = near.len() == 1;
    if alone {
        clear.skip(sheet.w.len());
    } else {
        clear.prepare(sheet.w.len(), near.len().div_ceil(group), near.iter().map(|near| near.index));
    }
    let size = |p: V3<T>| p[0].abs().max(p[1].abs()).max(p[2].abs());
    let largest = near.iter().fold(size(lowest).max(size(highest)), |most, near| most.max(near.reach.size()));
    // Above all rounding of a distance and of what is taken off it.
    let slack = largest * T::of(2e-5);
    // Steps in which a list should last at the present speed: one of few colliders is made as quickly as it is used.
    let steps = (left / dt).min(T::of(near.len() as f64) - T::of(1.0)) + T::of(2.0);
    let (half, row) = (sheet.half, sheet.row());
    let (w, before) = (&sheet.w[..], &sheet.before[..]);
    let size = (TOGETHER * row, TOGETHER * 2 * half / LANES);
    let takes = !alone && clear.pays();
    let (blocks, spared) = clear.parts();
    let crowd = Crowd::new(&near).filter(|_| takes);
    threads.chunks2(&mut sheet.now, blocks, size, |chunk, rows, blocks| {
        let lists = Lists { blocks, takes, spared, slack, steps, group };
        let first = chunk * TOGETHER;
        widest(Rows { rows, lists, row, half, w, before, first, near: &near, crowd: crowd.as_ref(), dt });
    });
}

/// The colliders that particles in a box can touch, in their order: also those that another one can push them to. `steps` are to go in the
/// frame.
fn in_reach<T: Real>(
    (mut lowest, mut highest): (V3<T>, V3<T>),
    all: &[(Solid<T>, Reach<T>)],
    steps: T,
) -> Vec<Near<'_, T>> {
    let mut near = vec![false; all.len()];
    loop {
        let mut more = false;
        let (low, high) = (lowest, highest);
        for ((_, reach), near) in all.iter().zip(&mut near).filter(|(x, near)| !**near && x.1.box_near(low, high)) {
            (*near, more) = (true, true);
            let far = reach.pushes(low, high);
            for c in 0..3 {
                lowest[c] = lowest[c].min(far.0[c]);
                highest[c] = highest[c].max(far.1[c]);
            }
        }
        if !more {
            break;
        }
    }
    // No step after the last one: a half-space that turns moves infinitely far in each.
    let ahead = |reach: &Reach<T>| if steps > T::of(0.0) { reach.moves() * steps } else { T::of(0.0) };
    let near = all.iter().enumerate().filter(|(index, _)| near[*index]);
    near.map(|(index, (solid, reach))| Near { index, solid, ahead: ahead(reach), reach }).collect()
}

/// Where a particle that went from `was` to `at` in `dt` is put; none if it meets nothing.
#[inline]
pub fn meet<T: Real>(solid: &Solid<T>, at: V3<T>, was: V3<T>, dt: T) -> Option<V3<T>> {
    // From where it would have been before, had the collider always been where it is now.
    let from = moved_by(solid, was, dt);
    let out = swept(solid, from, at)?;
    // A solid is convex, and friction moves the particle at right angles to its normal: the particle stays outside.
    Some(if solid.friction > T::of(0.0) { rub(solid, &out, from) } else { out.at })
}

/// The way out of a solid at rest for a particle that went from `from` to `at`.
///
/// After a step far shorter than the solid is thick it is the closest one, which is smooth. After a longer one that could
/// be out of the side or the back: it is by the plane that touches the solid where the path entered, or where it began
/// inside, as resting particles do by rounding.
fn swept<T: Real>(solid: &Solid<T>, from: V3<T>, at: V3<T>) -> Option<Exit<T>> {
    let path = sub(at, from);
    if dot(path, path) < short(solid) {
        return solid.exit(at);
    }
    let met = solid.exit(from).map(|out| (out.at, out.normal)).or_else(|| solid.entry(from, path));
    met.and_then(|(surface, normal)| out_by(at, surface, normal)).or_else(|| solid.exit(at))
}

/// Below this square of a way \[m^2\] a particle leaves a solid by the closest point.
fn short<T: Real>(solid: &Solid<T>) -> T {
    let short = solid.thickness() * T::of(0.25);
    short * short
}

fn out_by<T: Real>(at: V3<T>, surface: V3<T>, normal: V3<T>) -> Option<Exit<T>> {
    let depth = dot(sub(surface, at), normal);
    (depth > T::of(0.0)).then(|| Exit { at: add(at, scale(normal, depth)), normal, depth })
}

#[cfg(test)]
mod tests;
