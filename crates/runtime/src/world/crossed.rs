//! Counts the crossings of cloths as they are now.

use super::World;
use crate::cpu::body::Body;
use crate::crossings::{self, Crossings, Drawn};
use crate::findings::Fate;
use crate::number::real::Real;

/// Whether triangles cross.
pub(super) fn is_crossed(found: &[(usize, Fate)]) -> bool {
    found.iter().any(|(_, fate)| matches!(fate, Fate::Crossed { pairs, .. } if *pairs > 0))
}

impl World {
    /// The crossings of some cloths, with one of these.
    pub(super) fn crossings_of<T: Real>(
        &self,
        cloths: &[usize],
        bodies: &[Body<T>],
        forced: usize,
    ) -> Option<(usize, Fate)> {
        let found = self.find_crossings(cloths, bodies)?;
        let (pairs, touching) = (found.total(), found.touching);
        let cloth = found.worst.first().map_or(0, |pair| pair.first.cloth);
        (pairs + touching > 0).then(|| (cloths[cloth], Fate::Crossed { pairs, touching, forced }))
    }

    /// Pairs of triangles of some cloths that cross.
    pub(super) fn pairs_of<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>]) -> u64 {
        self.find_crossings(cloths, bodies).map_or(0, |found| found.total())
    }

    fn find_crossings<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>]) -> Option<Crossings> {
        let single = |p: &[T; 4]| p.map(|x| x.get() as f32);
        let now: Vec<Vec<[f32; 4]>> = cloths.iter().map(|c| bodies[*c].now().iter().map(single).collect()).collect();
        let drawn = |(c, now): (&usize, &'_ Vec<[f32; 4]>)| {
            let holes = &bodies[*c].holes;
            (holes.len() == now.len()).then_some(&**holes)
        };
        let holes: Vec<Option<&[u32]>> = cloths.iter().zip(&now).map(drawn).collect();
        let each = cloths.iter().zip(&now).zip(&holes);
        let drawn: Vec<Drawn> = each
            .map(|((c, now), holes)| Drawn { cloth: &self.scene.cloths[*c], positions: Some(now), holes: *holes })
            .collect();
        crossings::find(&drawn, 1).ok()
    }
}
