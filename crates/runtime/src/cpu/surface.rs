//! Contact with the surface of a body.
//!
//! At the start of a frame each particle finds the nearest point of the surface, from the triangle at which it was in the last frame, and gets the
//! plane there. The plane moves with the surface over the substeps, which cost one dot product per particle each ([`contact`]). A walk can end where
//! the surface is nearest only around there: so particles also try the triangles of their neighbours in the grid, and some of them per frame the
//! nearest of all patches. Where a patch comes to a particle in the frame, the plane is that of the end of the frame ([`struck`]). Particles far from the body are
//! left out until it or they may have come near.

pub(crate) mod boxes;
pub(crate) mod contact;
pub(crate) mod give;
pub(crate) mod nearest;
pub(crate) mod passing;
pub(crate) mod pose;
pub(crate) mod search;
pub(crate) mod struck;

use std::sync::Arc;

use super::fabric::seam_steps::Member;
use super::rows::Threads;
use super::sheet::Sheet;
use crate::cloth::surface::{BodySurface, NONE, On};
use crate::cloth::{Anchor, Cloth, Poses};
use crate::collider::FRICTION;
use crate::memory::Tally;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub};
use crate::step::Step;
use boxes::Boxes;
use contact::Planes;
use pose::Skinned;

/// The last known nearest point of a particle.
#[derive(Clone, Copy)]
struct Hint<T> {
    /// Where the particle was in the last frame \[m\].
    last: V3<T>,
    /// From the point that was found to the particle then, of a point that is not inside of its triangle.
    way: V3<T>,
    /// The normal there.
    normal: V3<T>,
    weights: V3<T>,
    /// [`NONE`] where it is not known.
    triangle: u32,
    /// A point of another side of the surface; [`NONE`] where no other is near.
    second: u32,
    /// Where on the triangle the point is.
    on: On,
}

/// A duplicate of a seam point, and the one that finds its plane: sheet, place in [`Sheet::w`], place in [`Sheet::now`].
type Twin = [(usize, usize, usize); 2];

/// The nearest pin of a particle: where it lies in the sheets, how far \[m\] it is along the cloth, and how deep \[m\] inside it was modelled.
struct Hold<T> {
    place: Member,
    most: T,
    modelled: T,
}

/// The pin that holds a particle: where it is \[m\], and the rest as in [`Hold`].
struct Pin<T> {
    at: V3<T>,
    most: T,
    modelled: T,
}

impl<T: Real> Hold<T> {
    /// None where it holds nothing any more.
    fn pin(&self, sheets: &[Sheet<T>]) -> Option<Pin<T>> {
        let Hold { place: Member { sheet, at, single }, most, modelled } = *self;
        let sheet = &sheets[sheet as usize];
        (sheet.w[single as usize] <= T::of(0.0)).then(|| Pin { at: sheet.at(at as usize), most, modelled })
    }
}

/// The surface that a cloth is worn on, and what its particles know of it.
pub struct Worn<T: Real> {
    surface: Arc<BodySurface>,
    skinned: Skinned<T>,
    /// Of the nearest side, and of the second one.
    planes: [Vec<Planes<T>>; 2],
    hints: Vec<Hint<T>>,
    /// Frames for which each particle is left out.
    waits: Vec<u8>,
    /// The triangle, the normal and the second triangle that each particle knew before this frame: those that its neighbours try.
    marks: Vec<(u32, V3<T>, u32)>,
    boxes: Boxes<T>,
    clearances: Vec<T>,
    /// The nearest pin of each particle.
    holds: Vec<Option<Hold<T>>>,
    /// As [`give::spans`]; empty where contact never gives way.
    spans: Vec<[f32; 4]>,
    /// The first duplicate of each particle.
    points: Vec<u32>,
    twins: Vec<Twin>,
    friction: T,
    /// Frames since all particles searched among all patches.
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
        let (surface, _) = cloth.worn_on()?;
        let points = cloth.points();
        let twin = |k: &u32| points[*k as usize] != *k && cloth.particles()[*k as usize].exists();
        let twins =
            (0..cloth.len() as u32).filter(twin).map(|k| [place(k as usize), place(points[k as usize] as usize)]);
        let clearances: Vec<T> = cloth.clearances(thickness).iter().map(|h| T::of(f64::from(*h))).collect();
        let hold = |anchor: &Anchor| {
            let (pin, most) = (anchor.particle as usize, T::of(f64::from(anchor.distance)));
            let modelled = T::of(0.0).max(T::of(0.0) - *clearances.get(pin)?);
            let (sheet, single, at) = place(pin);
            let place = Member { sheet: sheet as u32, at: at as u32, single: single as u32 };
            Some(Hold { place, most, modelled })
        };
        let mut holds: Vec<_> = cloth.tethers(1).anchors.iter().map(hold).collect();
        holds.resize_with(cloth.len(), || None);
        let zero = [T::of(0.0); 3];
        let on = On::Face;
        let hint = Hint { last: zero, way: zero, normal: zero, weights: zero, triangle: NONE, second: NONE, on };
        Some(Worn {
            skinned: Skinned::new(surface),
            planes: [0, 1].map(|_| sheets.iter().map(Planes::new).collect()),
            hints: vec![hint; cloth.len()],
            waits: vec![0; cloth.len()],
            marks: Vec::new(),
            boxes: Boxes::new(surface),
            clearances,
            holds,
            spans: if give::gives(cloth) { give::spans(cloth) } else { Vec::new() },
            twins: twins.collect(),
            points,
            friction: T::of(f64::from((FRICTION * cloth.friction).min(f32::MAX))),
            frames: 0,
            due: false,
            surface: surface.clone(),
        })
    }

    /// As [`Skinned::lead`].
    pub fn lead(&mut self, poses: &Poses<T>, rate: T) {
        self.skinned.lead(poses, rate);
    }

    /// The cloth has been cut.
    pub fn open(&mut self) {
        self.spans = Vec::new();
    }

    /// A frame begins.
    pub fn begin(&mut self) {
        self.due = true;
    }

    /// Searches all particles afresh in the next frame.
    pub fn forget(&mut self) {
        self.hints.iter_mut().for_each(|hint| (hint.triangle, hint.second) = (NONE, NONE));
        self.waits.fill(0);
        self.frames = 0;
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.hints);
        tally.state(&self.marks);
        tally.state(&self.waits);
        tally.state(&self.clearances);
        tally.state(&self.holds);
        tally.state(&self.spans);
        tally.state(&self.points);
        tally.state(&self.twins);
    }

    /// Particles leave the surface; as [`contact::run`].
    pub fn run(&self, threads: &Threads, sheets: &mut [Sheet<T>], step: &Step<T>) {
        for (g, sheet) in sheets.iter_mut().enumerate() {
            // The side at which a particle is has the last word.
            for planes in self.planes.iter().rev() {
                contact::run(threads, sheet, &planes[g], self.friction, (step.dt, step.left));
            }
        }
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

#[cfg(test)]
#[path = "surface/tests.rs"]
mod tests;
