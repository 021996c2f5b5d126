//! Counts of the contents of the images of a bundle.

use crate::bundle::Bundle;
use crate::error::{Error, Result};
use crate::manifest::{Counts, PieceEntry};
use crate::map::{Image, MapKind};
use crate::particle::Particle;
use crate::rings::{Rings, find_rings, ring_gap};
use crate::springs::other_end;

impl Bundle {
    /// The particle of every texel of the bundle, in the order of the indices. A piece without positions has none.
    /// Errors on the first code that is not legal, with its texel.
    pub fn particles(&self) -> Result<Vec<Particle>> {
        let mut particles = Vec::new();
        for (index, piece) in self.manifest.pieces.iter().enumerate() {
            for k in 0..piece.width as usize * piece.height as usize {
                let w = self.image(index, &MapKind::Position).and_then(|p| p.at(k).get(3)).copied().unwrap_or(0.0);
                let (i, j) = (k as u32 % piece.width, k as u32 / piece.width);
                let at = |source| Error::Code { piece: piece.name.clone(), i, j, source };
                particles.push(Particle::from_code(w).map_err(at)?);
            }
        }
        Ok(particles)
    }

    /// The seam rings; errors as [`Bundle::particles`]. Faulty links are left out: [`crate::validate`] names them.
    pub fn rings(&self) -> Result<Rings> {
        Ok(find_rings(&self.particles()?).0)
    }

    /// Writes the counts of every piece to the manifest. Call it after all images are inserted.
    pub fn count(&mut self) -> Result<()> {
        let particles = self.particles()?;
        let (rings, _) = find_rings(&particles);
        let counts = count_pieces(self, &particles, &rings);
        for (piece, count) in self.manifest.pieces.iter_mut().zip(counts) {
            piece.counts = count;
        }
        Ok(())
    }

    /// The largest distance \[m\] between linked duplicates; exactly 0 in a sound bundle.
    pub fn seam_gap(&self) -> Result<f64> {
        Ok(ring_gap(&self.rings()?, |index| self.position(index).unwrap_or([f32::NAN; 3])))
    }

    /// Position \[m\] of the particle with a bundle-wide index; none past the end.
    pub fn position(&self, index: u32) -> Option<[f32; 3]> {
        let (piece, k) = self.locate(index)?;
        self.image(piece, &MapKind::Position)?.at(k).get(..3)?.try_into().ok()
    }

    /// The piece that owns a bundle-wide index, and the index of the texel in it.
    pub fn locate(&self, index: u32) -> Option<(usize, usize)> {
        let pieces = &self.manifest.pieces;
        let piece = pieces.partition_point(|p| p.first_particle <= index).checked_sub(1)?;
        let k = (index - pieces[piece].first_particle) as usize;
        (k < pieces[piece].width as usize * pieces[piece].height as usize).then_some((piece, k))
    }
}

/// Whether spring `kind` of texel `k` of a piece joins two particles inside the grid. `particles` are those of the piece.
pub(crate) fn spring_fits(piece: &PieceEntry, particles: &[Particle], k: usize, kind: usize) -> bool {
    let exists = |k: usize| particles.get(k).is_some_and(|p| p.exists());
    let end = other_end(piece.width as usize, piece.height as usize, k, kind);
    end.is_some_and(|end| exists(k) && exists(end))
}

/// The particles of one piece out of those of the bundle; empty where they are too few.
pub(crate) fn piece_particles<'a>(piece: &PieceEntry, particles: &'a [Particle]) -> &'a [Particle] {
    let first = piece.first_particle as usize;
    let texels = piece.width as usize * piece.height as usize;
    first.checked_add(texels).and_then(|end| particles.get(first..end)).unwrap_or(&[])
}

pub(crate) fn count_pieces(bundle: &Bundle, particles: &[Particle], rings: &Rings) -> Vec<Counts> {
    let pieces = &bundle.manifest.pieces;
    let mut counts = vec![Counts::default(); pieces.len()];
    for (index, (piece, count)) in pieces.iter().zip(&mut counts).enumerate() {
        let own = piece_particles(piece, particles);
        let number = |test: fn(&Particle) -> bool| own.iter().filter(|p| test(p)).count() as u32;
        count.particles = number(|p| p.exists());
        count.seam_texels = number(|p| p.next().is_some());
        count.pinned = number(|p| p.is_pinned());
        count.springs = springs(piece, own, bundle.image(index, &MapKind::Rest));
    }
    for ring in rings.iter() {
        if let Some((piece, _)) = ring.first().and_then(|&lowest| bundle.locate(lowest)) {
            counts[piece].seam_points += 1;
            counts[piece].largest_ring = counts[piece].largest_ring.max(ring.len() as u32);
        }
    }
    counts
}

fn springs(piece: &PieceEntry, particles: &[Particle], rest: Option<&Image>) -> u32 {
    if let Some(rest) = rest {
        return rest.data.iter().filter(|&&length| length > 0.0).count() as u32;
    }
    let Some(constant) = piece.constants.rest else { return 0 };
    let kinds = (0..constant.len()).filter(|&kind| constant[kind] > 0.0);
    kinds.map(|kind| (0..particles.len()).filter(|&k| spring_fits(piece, particles, k, kind)).count() as u32).sum()
}
