//! Contact that no triangle crosses, on the CPU: hands the cloths of a scene to [`Truncation`] and takes back where particles may go.

use super::World;
use super::crossed::is_crossed;
use super::joined::Joined;
use crate::cloth::{Cloth, ContactTier};
use crate::collider::solid::Solid;
use crate::cpu::body::Body;
use crate::cpu::fabric::seam_steps::Member;
use crate::cpu::rows::Threads;
use crate::cpu::truncation::surface::Texel;
use crate::cpu::truncation::{Outcome, Truncation};
use crate::cpu::untangle::loose::Loose;
use crate::findings::Fate;
use crate::handle::ClothHandle;
use crate::health::depths;
use crate::memory::Tally;
use crate::number::real::{Real, V3};
use crate::options::Solver;

/// Depth in colliders that is reported, as a share of the contact distance.
const SQUEEZED_SHARE: f64 = 0.25;

/// The make-up of the surface; where it changes, another surface is needed.
pub(super) type Key = Vec<(ClothHandle, usize, u32)>;

/// The cloths of a scene whose contact is safe.
pub struct Safe {
    key: Key,
    truncation: Truncation,
    /// For each point and particle where it lies in its cloth.
    members: Vec<Member>,
    /// In this frame.
    outcome: Outcome,
    /// Failures found when the frame began.
    found: Vec<(usize, Fate)>,
    /// Whether crossings were looked for as this frame began.
    pub(super) looked: bool,
    /// Whether some were found then, or at the end of the last frame.
    pub(super) crosses: bool,
}

impl Safe {
    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        self.truncation.tally(tally);
        tally.state(&self.members);
    }

    /// Lets particles that are loose pass one another, by cloth and particle.
    pub(super) fn loosen(&mut self, loose: impl Fn(u32, u32) -> Loose) {
        let surface = &self.truncation.surface;
        let first = |point: usize| surface.of_point(point)[0];
        let of = |texel: Texel| (texel.cloth, loose(texel.cloth, texel.particle));
        let all: Vec<(u32, Loose)> = (0..surface.count()).map(first).map(of).collect();
        self.truncation.loosen(if all.iter().any(|(_, loose)| loose.any()) { all } else { Vec::new() });
    }

    /// Follows its cloths as another one leaves the scene. One of its own changes the key.
    pub(super) fn leave(&mut self, gone: usize) {
        self.truncation.surface.leave(gone);
    }

    /// Searches afresh in the next step.
    pub fn forget(&mut self) {
        self.truncation.forget();
    }
}

/// Whether no triangle of a cloth shall cross others.
pub fn is_safe(cloth: &Cloth) -> bool {
    cloth.contact.is_some_and(|contact| contact.tier == ContactTier::Safe)
}

impl World {
    /// Takes in where the cloths are as a frame begins. Crossings are looked for where particles were put from outside.
    pub(super) fn begin_safe<T: Real>(&mut self, bodies: &[Body<T>]) {
        let safe = |index: &usize| is_safe(&self.scene.cloths[*index]) && bodies[*index].fabric().is_some();
        let cloths: Vec<usize> = (0..bodies.len()).filter(safe).collect();
        if cloths.is_empty() || self.control.options.solver == Solver::Classic {
            self.safe = None;
            return;
        }
        let key = self.key(&cloths, bodies);
        let known = self.safe.take().filter(|safe| safe.key == key);
        let renewed = known.is_none();
        let mut safe = known.unwrap_or_else(|| self.new_safe(&cloths, bodies, key));
        let put = safe.load(bodies, renewed, |cloth| !self.runs[cloth].asleep);
        safe.outcome = Outcome::default();
        safe.found.clear();
        safe.looked = put;
        if put {
            safe.found.extend(self.crossings_of(&cloths, bodies, 0));
            safe.crosses = is_crossed(&safe.found);
        }
        self.safe = Some(safe);
    }

    /// The make-up of some cloths.
    pub(super) fn key<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>]) -> Key {
        let removed = |index: &usize| bodies[*index].holes.iter().map(|bits| bits.count_ones()).sum();
        cloths.iter().map(|c| (self.handles[*c], bodies[*c].count(), removed(c))).collect()
    }

    fn new_safe<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>], key: Key) -> Box<Safe> {
        let Joined { surface, spacing, members } = self.join_surfaces(cloths, bodies);
        let truncation = Truncation::new(surface, spacing);
        Box::new(Safe {
            key,
            truncation,
            members,
            outcome: Outcome::default(),
            found: Vec::new(),
            looked: false,
            crosses: false,
        })
    }

    /// Holds particles back after a step of all cloths.
    pub(super) fn step_safe<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads) {
        let Some(safe) = &mut self.safe else { return };
        safe.read(bodies, |cloth| !self.runs[cloth].asleep);
        let outcome = safe.truncation.step(threads);
        safe.outcome.forced = safe.outcome.forced.max(outcome.forced);
        safe.outcome.slowed = safe.outcome.slowed.max(outcome.slowed);
        safe.outcome.held = safe.outcome.held.max(outcome.held);
        safe.outcome.searches += outcome.searches;
        safe.write(bodies);
    }

    /// Failures of a frame, with the cloth of each.
    pub(super) fn end_safe<T: Real>(&mut self, bodies: &[Body<T>]) -> Vec<(usize, Fate)> {
        let Some(safe) = &mut self.safe else { return Vec::new() };
        let mut found = std::mem::take(&mut safe.found);
        let Outcome { forced, slowed, .. } = safe.outcome;
        let cloths: Vec<usize> = (0..bodies.len()).filter(|c| is_safe(&self.scene.cloths[*c])).collect();
        if forced > 0 {
            let forced: Vec<_> = self.crossings_of(&cloths, bodies, forced).into_iter().collect();
            let crosses = is_crossed(&forced);
            self.safe.iter_mut().for_each(|safe| safe.crosses |= crosses);
            found.extend(forced);
        }
        if let (true, Some(cloth)) = (slowed > 0, cloths.first()) {
            found.push((*cloth, Fate::Slowed { particles: slowed }));
        }
        found
    }

    /// How deep \[m\] a cloth is inside its colliders, where contact has held particles back and this is more than a share of its contact distance.
    pub(super) fn squeezed<T: Real>(&self, index: usize, now: &[[T; 4]], solids: &[Solid<T>]) -> Option<Fate> {
        let cloth = &self.scene.cloths[index];
        if !is_safe(cloth) || solids.is_empty() || self.safe.as_ref()?.outcome.held == 0 {
            return None;
        }
        let allowed = SQUEEZED_SHARE * f64::from(cloth.contact_distance(self.control.options.thickness));
        let depth = depths(now, solids, 0.0).into_iter().fold(0.0, f64::max);
        (depth > allowed).then_some(Fate::Squeezed { depth })
    }
}

impl Safe {
    /// Takes in all particles as a frame begins; true where some that are free are not where the last frame has left them.
    fn load<T: Real>(&mut self, bodies: &[Body<T>], renewed: bool, awake: impl Fn(usize) -> bool) -> bool {
        let Truncation { surface, last, want, free, .. } = &mut self.truncation;
        let mut put = renewed;
        for point in 0..surface.count() {
            let texels = surface.of_point(point);
            let of = |texel: &Texel| bodies[texel.cloth as usize].now()[texel.particle as usize];
            want[point] = [0, 1, 2].map(|c| of(&texels[0])[c].get());
            let moves = texels.iter().all(|texel| of(texel)[3] > T::of(0.0));
            free[point] = moves && awake(texels[0].cloth as usize);
            put |= want[point] != last[point] && moves;
        }
        if put {
            last.clone_from(want);
            self.truncation.forget();
        }
        put
    }

    /// Takes in where a step takes the particles of cloths that are awake.
    fn read<T: Real>(&mut self, bodies: &[Body<T>], awake: impl Fn(usize) -> bool) {
        let Truncation { surface, want, last, .. } = &mut self.truncation;
        for (point, want) in want.iter_mut().enumerate() {
            let at = surface.starts[point] as usize;
            let cloth = surface.texels[at].cloth as usize;
            *want = match bodies[cloth].fabric().filter(|_| awake(cloth)) {
                Some(fabric) => fabric.at(self.members[at]).map(Real::get),
                None => last[point],
            };
        }
    }

    /// Puts the particles that were held back.
    fn write<T: Real>(&self, bodies: &mut [Body<T>]) {
        let Truncation { surface, want, last, .. } = &self.truncation;
        for (point, (want, last)) in want.iter().zip(last).enumerate() {
            if want == last || !want.iter().all(|x| x.is_finite()) {
                continue;
            }
            let to: V3<T> = last.map(T::of);
            for at in surface.starts[point] as usize..surface.starts[point + 1] as usize {
                let cloth = surface.texels[at].cloth as usize;
                if let Some(fabric) = bodies[cloth].fabric_mut() {
                    fabric.hold_back(self.members[at], to);
                }
            }
        }
    }
}
