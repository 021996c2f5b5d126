//! Pinning particles and finding the duplicates of seam particles.

use std::sync::Arc;

use super::Cloth;
use crate::error::{Error, Result};
use gimage_bundle::Particle;

/// Fewest particles for which a table of all rings pays.
const MIN_FOR_TABLE: usize = 16;
/// No ring, in that table.
const NO_RING: u32 = u32::MAX;

impl Cloth {
    /// Pins a particle and its seam duplicates where they are, or frees them. Errors if the cloth has no particle of this index.
    pub fn set_pinned(&mut self, index: usize, pinned: bool) -> Result<()> {
        let (what, count) = ("particle", self.len());
        let particle = u32::try_from(index).map_err(|_| Error::NoSuch { what, index, count })?;
        self.hold(&[particle], pinned)
    }

    /// Pins particles and their seam duplicates where they are. Takes time linear in the number of particles. Errors if the
    /// cloth has no particle of an index; then nothing has changed.
    pub fn pin(&mut self, particles: &[u32]) -> Result<()> {
        self.hold(particles, true)
    }

    /// Frees particles, as [`Cloth::pin`] pins them.
    pub fn unpin(&mut self, particles: &[u32]) -> Result<()> {
        self.hold(particles, false)
    }

    fn hold(&mut self, particles: &[u32], pinned: bool) -> Result<()> {
        let all = self.with_duplicates(particles)?;
        self.hold_all(all.into_iter().map(|[k, _]| k), pinned);
        Ok(())
    }

    /// The same for particles that exist, all duplicates among them.
    pub(crate) fn hold_all(&mut self, particles: impl Iterator<Item = u32>, pinned: bool) {
        let list = Arc::make_mut(&mut self.parts.particles);
        for k in particles {
            let particle = &mut list[k as usize];
            if particle.is_pinned() != pinned {
                self.stored_tethers = None;
            }
            let next = particle.next();
            *particle = if pinned { Particle::Pinned { next } } else { Particle::Free { next } };
        }
    }

    /// Particles and all their duplicates, each once and in order, with the index in `particles` that it comes from; the
    /// last index if it comes from several. Errors if the cloth has no particle of an index.
    pub(crate) fn with_duplicates(&self, particles: &[u32]) -> Result<Vec<[u32; 2]>> {
        let (what, count) = ("particle", self.len());
        let exists = |k: u32| self.parts.particles.get(k as usize).is_some_and(|p| p.exists());
        if let Some(k) = particles.iter().find(|k| !exists(**k)) {
            return Err(Error::NoSuch { what, index: *k as usize, count });
        }
        let few = particles.len() < MIN_FOR_TABLE || self.ring_count() == 0;
        let table = if few { Vec::new() } else { self.ring_table() };
        let ring = |k: u32| match table.get(k as usize) {
            None => self.ring_of(k),
            Some(&NO_RING) => None,
            Some(ring) => Some(self.ring(*ring as usize)),
        };
        let mut all = Vec::with_capacity(particles.len());
        for (place, &k) in particles.iter().enumerate() {
            match ring(k) {
                Some(ring) => all.extend(ring.iter().map(|member| [*member, place as u32])),
                None => all.push([k, place as u32]),
            }
        }
        // Stable, so that of equal particles the last comes last.
        all.sort_by_key(|[k, _]| *k);
        all.dedup_by(|later, kept| {
            let same = later[0] == kept[0];
            kept[1] = if same { later[1] } else { kept[1] };
            same
        });
        Ok(all)
    }

    /// All duplicates of a seam particle, itself among them. Costs a search through the seams.
    pub fn ring_of(&self, index: u32) -> Option<&[u32]> {
        let at = self.ring_members.iter().position(|&m| m == index)?;
        Some(self.ring(self.ring_starts.partition_point(|&s| s as usize <= at) - 1))
    }

    /// The members of a ring.
    pub(crate) fn ring(&self, ring: usize) -> &[u32] {
        &self.ring_members[self.ring_starts[ring] as usize..self.ring_starts[ring + 1] as usize]
    }

    /// The ring of each particle.
    fn ring_table(&self) -> Vec<u32> {
        let mut table = vec![NO_RING; self.len()];
        for ring in 0..self.ring_count() {
            self.ring(ring).iter().for_each(|k| table[*k as usize] = ring as u32);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Grid, Mass, Parts, Rest};
    use super::*;

    /// Two rows of twenty particles, each the duplicate of the one in the other row.
    fn folded() -> Cloth {
        let grids = vec![Grid { name: "strip".into(), first: 0, width: 20, height: 2 }];
        let particles = (0..40).map(|k| Particle::Free { next: Some((k + 20) % 40) }).collect();
        let positions = (0..40).map(|k| [(k % 20) as f32, 0.0, 0.0]).collect();
        let (name, rest, mass) = ("strip".into(), Rest::None, Mass::Constant(1.0));
        Cloth::new(Parts { name, grids, positions, particles, rest, mass }).unwrap()
    }

    #[test]
    fn duplicates_follow_and_the_last_of_several_counts() {
        let mut cloth = folded();
        for count in [3, MIN_FOR_TABLE as u32] {
            let mut chosen: Vec<u32> = (0..count).collect();
            // The duplicate of the first.
            chosen.push(20);
            let all = cloth.with_duplicates(&chosen).unwrap();
            assert_eq!(all.len(), 2 * count as usize);
            assert!(all.windows(2).all(|w| w[0][0] < w[1][0]));
            for [k, place] in all {
                assert_eq!(place, if k % 20 == 0 { count } else { k % 20 }, "{k}");
            }
        }
        cloth.pin(&[3]).unwrap();
        assert!(cloth.particles()[3].is_pinned() && cloth.particles()[23].is_pinned());
        assert!(cloth.pin(&[4, 40]).unwrap_err().to_string().contains("no particle 40"));
        assert!(!cloth.particles()[4].is_pinned(), "nothing is half done");
        cloth.unpin(&[23]).unwrap();
        assert!(cloth.particles().iter().all(|p| !p.is_pinned()));
    }
}
