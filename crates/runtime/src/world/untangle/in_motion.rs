//! Cloth that has crossed in motion: when it is taken apart, and when it is left alone.

use super::{Tangled, at_start};
use crate::cpu::body::Body;
use crate::cpu::untangle::loose;
use crate::number::real::Real;
use crate::world::World;
use crate::world::patrol::Seed;

/// Cloth that crossed in motion is given up for a time if edges pierce more faces than this share of its points, and more than this multiple of the root of
/// their number, which is the length of a line across a sheet: a heap would collapse where contact lets that many points pass, and moves would carry cloth along
/// that falls.
const MAX_HITS: [f64; 2] = [0.125, 4.0];
/// How long \[s\] cloth is left alone that was given up: at first, and at most, as each time takes twice as long as the one before.
const REST_S: [f64; 2] = [0.5, 8.0];

impl Tangled {
    /// Whether it crossed in motion and crosses too much to be taken apart.
    pub(super) fn is_heap(&self) -> bool {
        let points = self.of.surface.count() as f64;
        self.in_motion && self.found.hits as f64 > (MAX_HITS[0] * points).max(MAX_HITS[1] * points.sqrt())
    }
}

impl World {
    /// Leaves cloth that crosses as it is for a time.
    pub(super) fn give_up<T: Real>(&mut self, bodies: &mut [Body<T>]) {
        let tangles = &mut self.tangles;
        tangles.spare = tangles.some.take();
        tangles.rest_s = (REST_S[0] * f64::from(tangles.rests).exp2()).min(REST_S[1]);
        tangles.rests += 1;
        self.hold_all(bodies);
    }

    /// Takes up crossings that have arisen in a frame around some particles.
    pub(super) fn take_up<T: Real>(&mut self, bodies: &mut [Body<T>], cloths: &[usize], seeds: &[Seed], seconds: f64) {
        if self.tangles.rest_s > 0.0 {
            self.tangles.rest_s -= seconds;
            return;
        }
        if seeds.is_empty() {
            return;
        }
        let fresh = self.tangles.some.is_none();
        if fresh {
            let spare = self.tangles.spare.take();
            let mut tangled = spare.unwrap_or_else(|| self.new_tangled(cloths, bodies));
            (tangled.in_motion, tangled.of.rings) = (true, loose::RINGS_IN_MOTION);
            tangled.of.forget();
            tangled.clean_s = 0.0;
            self.tangles.some = Some(tangled);
        }
        let Some(Tangled { of, points, .. }) = self.tangles.some.as_deref_mut().filter(|tangled| tangled.in_motion)
        else {
            return;
        };
        of.search_around(seeds.iter().map(|[cloth, particle]| points[*cloth as usize][*particle as usize]));
        if fresh {
            self.look_at_tangles(bodies, at_start);
        }
    }
}
