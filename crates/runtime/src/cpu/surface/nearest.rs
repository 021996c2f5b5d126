//! As shaders/part/surface_walk.wgsl: the nearest point of a surface, found by walking from triangle to triangle.

use super::face;
use super::pose::{Skinned, unit};
use super::search::SECOND_COSINE;
use crate::cloth::surface::{BodySurface, NONE, On, Spot, on_triangle};
use crate::number::real::{Real, V3, dot, sub};

/// Steps of a walk, and triangles around a corner that it looks at.
pub const STEPS: usize = 48;
pub const AROUND: usize = 24;

/// The nearest point to `p` that a walk from a triangle finds: each step goes to a neighbour that is nearer.
pub fn walk<T: Real>(surface: &BodySurface, skinned: &mut Skinned<T>, start: u32, p: V3<T>) -> Spot<T> {
    walk_beyond(surface, skinned, (start, None), p)
}

/// The same among triangles that face away from a normal, if one is given: so a walk on one wall of a crease does not come out on the other one.
pub fn walk_beyond<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    (start, away): (u32, Option<V3<T>>),
    p: V3<T>,
) -> Spot<T> {
    let mut spot = on_triangle(p, start, skinned.corners(surface, start));
    for _ in 0..STEPS {
        let next = match spot.on {
            On::Face => from_face(surface, skinned, (&spot, away), p),
            On::Side(side) => beyond(surface, skinned, (&spot, away), side.into(), p),
            On::Corner(corner) => around(surface, skinned, (&spot, away), corner.into(), p),
        };
        match next {
            Some(nearer) => spot = nearer,
            None => break,
        }
    }
    spot
}

/// Whether a triangle faces away from a normal.
pub fn faces_away<T: Real>(surface: &BodySurface, skinned: &mut Skinned<T>, triangle: u32, normal: V3<T>) -> bool {
    dot(normal, unit(face(&skinned.corners(surface, triangle)))) < T::of(SECOND_COSINE)
}

/// A point that was found, if a walk may go there.
fn allowed<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    found: Spot<T>,
    away: Option<V3<T>>,
) -> Option<Spot<T>> {
    away.is_none_or(|normal| faces_away(surface, skinned, found.triangle, normal)).then_some(found)
}

/// The triangle beyond a side, if it is nearer.
fn beyond<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    (spot, away): (&Spot<T>, Option<V3<T>>),
    side: usize,
    p: V3<T>,
) -> Option<Spot<T>> {
    let other = surface.across[spot.triangle as usize][side];
    if other == NONE {
        return None;
    }
    let found = on_triangle(p, other, skinned.corners(surface, other));
    if found.distance2 < spot.distance2 { allowed(surface, skinned, found, away) } else { None }
}

/// The nearest of those beyond the sides of a face that hides them: where the surface is hollow, and from behind.
fn from_face<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    (spot, away): (&Spot<T>, Option<V3<T>>),
    p: V3<T>,
) -> Option<Spot<T>> {
    let hollow = surface.hollow[spot.triangle as usize];
    let behind = hollow != 7 && {
        let corners = skinned.corners(surface, spot.triangle);
        dot(sub(p, corners[0]), face(&corners)) < T::of(0.0)
    };
    let mut best = None;
    for side in (0..3).filter(|side| behind || hollow >> side & 1 == 1) {
        let than = best.as_ref().unwrap_or(spot).distance2;
        best = beyond(surface, skinned, (&Spot { distance2: than, ..*spot }, away), side, p).or(best);
    }
    best
}

/// The nearest triangle around a corner, if it is nearer.
fn around<T: Real>(
    surface: &BodySurface,
    skinned: &mut Skinned<T>,
    (spot, away): (&Spot<T>, Option<V3<T>>),
    corner: usize,
    p: V3<T>,
) -> Option<Spot<T>> {
    let vertex = surface.triangles[spot.triangle as usize][corner];
    let mut best: Option<Spot<T>> = None;
    // One way round, and the other way too if that ends at a border.
    for way in [0, 2] {
        let mut at = spot.triangle;
        let mut closed = false;
        for _ in 0..AROUND {
            let own = surface.triangles[at as usize];
            let Some(c) = own.iter().position(|v| *v == vertex) else { break };
            let next = surface.across[at as usize][(c + way) % 3];
            if next == NONE || next == spot.triangle {
                closed = next != NONE;
                break;
            }
            at = next;
            let found = on_triangle(p, at, skinned.corners(surface, at));
            if found.distance2 < best.as_ref().unwrap_or(spot).distance2 {
                best = allowed(surface, skinned, found, away).or(best);
            }
        }
        if closed {
            break;
        }
    }
    best
}
