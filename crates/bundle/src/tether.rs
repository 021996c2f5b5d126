//! Tethers: the distance along the surface from each particle to its nearest pins.
//!
//! T.-Y. Kim, N. Chentanez, M. Mueller-Fischer, "Long Range Attachments: A Method to Simulate Inextensible Clothing in
//! Computer Games", SCA 2012: a particle that is kept within its geodesic distance of a pin cannot stretch the cloth
//! between them. Distances come from rest lengths alone, so they hold whatever shape the cloth is in.

mod bridge;
mod front;
mod groups;
mod labels;
mod unfold;

use crate::bundle::Bundle;
use crate::error::Result;
use crate::map::{Image, MapKind};
use crate::particle::Particle;
use crate::rings::find_rings;
use crate::stitch::Stitch;
pub use bridge::{Bridge, bridges};
use front::Front;
pub use groups::groups;

/// Largest number of anchors per particle.
pub const MAX_ANCHORS: usize = 4;

/// Rest lengths \[m\] of one grid: right, down, down-right, up-right. 0, negative and not finite mean no spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RestLengths<'a> {
    /// The same at every texel.
    Constant([f32; 4]),
    /// One entry a texel, row by row; texels past the end have no springs.
    Image(&'a [[f32; 4]]),
}

/// One grid of a surface. Its particles follow those of the grid before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringGrid<'a> {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Its springs.
    pub rest: RestLengths<'a>,
}

/// A pinned particle that holds another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Index of a pinned particle, the lowest of its duplicates; [`Anchor::NONE`] has `u32::MAX`.
    pub particle: u32,
    /// Geodesic distance to it \[m\], at least 0.
    pub distance: f32,
}

impl Anchor {
    /// No anchor: no further pin can be reached.
    pub const NONE: Anchor = Anchor { particle: u32::MAX, distance: 0.0 };

    /// Whether there is an anchor.
    pub fn exists(&self) -> bool {
        self.particle != u32::MAX
    }
}

/// The anchors of every particle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tethers {
    /// Slots per particle, 0 to [`MAX_ANCHORS`].
    pub per_particle: usize,
    /// `anchors[particle * per_particle + slot]`, nearest first; unused slots, at the end, are [`Anchor::NONE`].
    pub anchors: Vec<Anchor>,
}

impl Tethers {
    /// The anchors of a particle, nearest first, [`Anchor::NONE`] at the end; empty past the last particle.
    pub fn of(&self, particle: usize) -> &[Anchor] {
        let start = particle.saturating_mul(self.per_particle);
        self.anchors.get(start..start + self.per_particle).unwrap_or(&[])
    }

    /// Whether no particle has an anchor.
    pub fn is_empty(&self) -> bool {
        !self.anchors.iter().any(Anchor::exists)
    }
}

/// The nearest anchors of every particle, geodesic distances along the surface of the grids.
///
/// Pinned particles that are neighbours in a grid (also diagonally) or duplicates of one another form a *group*, such as
/// a pinned row. A particle gets up to `most` (at most [`MAX_ANCHORS`]) anchors: the nearest pins of as many of the
/// nearest groups. Duplicates get the same anchors, bit for bit. `particles` has an entry for every texel of all grids;
/// entries that are lacking count as no particle, and faulty seam links as none.
///
/// Distances are propagated in f64 in the order of Dijkstra over the triangles of both splits of each quad. Where the
/// wave from a pin passes between two particles, the pin is unfolded into the plane of the triangle (M. Novotni, R. Klein,
/// "Computing Geodesic Distances on Triangular Meshes", WSCG 2002), so that a path is straight in any direction. A
/// triangle needs its three springs: paths go around holes and cuts, and cross seams, also to other grids. They go on over `stitches`, from
/// their particle along the thread to the point of their quad and back ([`bridges`]), which is how pieces without pins of their own hang. On developable surfaces distances from
/// one pin are exact to the rounding of the rest lengths. Beyond the end of a cut, and where many pins are close together on
/// uneven texels, they come out long by a share of one texel (under 0.5 % and 1 % in the tests), never short. Behind a row of stitches they
/// come out long by less than one texel, where a path leads from their particles to their quads, and a little short where stitches leave out
/// particles, as waves through two of them are taken for one. On doubly
/// curved surfaces the error falls with the size of the texels; where the surface bulges, they come out a little short.
///
/// Costs O(k n log n) time and 24 k n bytes for n particles, where k is at most 5 (`most` + 1) and does not grow with the
/// number of pins: all pins spread at once, and each particle keeps only the nearest. One thread.
pub fn tethers(grids: &[SpringGrid<'_>], particles: &[Particle], stitches: &[Stitch], most: usize) -> Tethers {
    let most = most.min(MAX_ANCHORS);
    let pinned: Vec<bool> = particles.iter().map(|p| p.is_pinned()).collect();
    let sizes = grids.iter().map(|grid| [grid.width, grid.height]);
    let (groups, count) = groups(sizes, find_rings(particles).0.iter(), &pinned);
    if most == 0 || count == 0 {
        return Tethers { per_particle: most, anchors: vec![Anchor::NONE; most * particles.len()] };
    }
    let mut front = Front::new(grids, particles, &groups, count.min(most + 1)).with(&bridges(grids, stitches));
    front.spread();
    let mut anchors = Vec::with_capacity(most * particles.len());
    for k in 0..particles.len() {
        let nearest = front.nearest(k);
        anchors.extend((0..most).map(|slot| nearest.get(slot).copied().unwrap_or(Anchor::NONE)));
    }
    Tethers { per_particle: most, anchors }
}

impl Bundle {
    /// The tethers of all pieces as [`tethers`] finds them from the stored rest lengths, pins and stitches; particle indices are
    /// bundle-wide. Errors as [`Bundle::particles`].
    pub fn compute_tethers(&self, most: usize) -> Result<Tethers> {
        let pieces = self.manifest.pieces.iter().enumerate();
        let grids: Vec<SpringGrid> = pieces
            .map(|(index, piece)| {
                let image = self.image(index, &MapKind::Rest).map(|image| image.data.as_chunks().0);
                let constant = RestLengths::Constant(piece.constants.rest.unwrap_or_default());
                let rest = image.map_or(constant, RestLengths::Image);
                SpringGrid { width: piece.width, height: piece.height, rest }
            })
            .collect();
        Ok(tethers(&grids, &self.particles()?, &self.stitches(), most))
    }

    /// Writes the nearest anchor of every particle into `tether` maps; a piece none of whose particles can reach a pin has
    /// no such map afterwards. Call it after positions, pins, rest lengths and stitches are inserted. Errors as [`Bundle::particles`].
    pub fn write_tethers(&mut self) -> Result<()> {
        let found = self.compute_tethers(1)?;
        let particles = self.particles()?;
        for index in 0..self.manifest.pieces.len() {
            let piece = &self.manifest.pieces[index];
            let (first, mut image) = (piece.first_particle as usize, Image::zeros(piece.width, piece.height, 3));
            let mut any = false;
            for (k, texel) in image.data.chunks_exact_mut(3).enumerate() {
                // Without a particle a writer stores 0.
                if !particles.get(first + k).is_some_and(|p| p.exists()) {
                    continue;
                }
                let anchor = found.of(first + k).first().filter(|a| a.exists());
                any |= anchor.is_some();
                (texel[0], texel[1]) = anchor.map_or((0.0, -1.0), |a| (a.distance, a.particle as f32));
            }
            self.images.remove(&(index, MapKind::Tether));
            if any {
                self.insert(index, MapKind::Tether, image)?;
            }
        }
        Ok(())
    }

    /// The stored tethers, one per particle; `None` if no piece has a `tether` map. A texel that names no particle of the
    /// bundle, or holds no length, counts as without an anchor.
    pub fn stored_tethers(&self) -> Option<Tethers> {
        let total = self.manifest.texels();
        let mut anchors = Vec::new();
        let mut any = false;
        for (index, piece) in self.manifest.pieces.iter().enumerate() {
            let image = self.image(index, &MapKind::Tether);
            any |= image.is_some();
            anchors.extend((0..piece.width as usize * piece.height as usize).map(|k| {
                let (distance, particle) = match image.map(|i| i.at(k)) {
                    Some(&[distance, particle, _]) => (distance, particle),
                    _ => return Anchor::NONE,
                };
                let sound = distance >= 0.0 && distance.is_finite() && particle >= 0.0 && particle < total as f32;
                if sound { Anchor { particle: particle as u32, distance } } else { Anchor::NONE }
            }));
        }
        any.then_some(Tethers { per_particle: 1, anchors })
    }
}

#[cfg(test)]
#[path = "tether_tests.rs"]
mod tests;
