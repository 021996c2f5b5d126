//! Cloth that crosses, on the CPU: hands the cloths that have contact to [`Untangle`] while some of them cross, and moves their particles.

use super::World;
use super::joined::Joined;
use super::truncate::{Key, is_safe};
use crate::cpu::body::Body;
use crate::cpu::fabric::seam_steps::Member;
use crate::cpu::truncation::surface::{Source, Surface};
use crate::cpu::untangle::Untangle;
use crate::cpu::untangle::loose::{self, Loose};
use crate::findings::Fate;
use crate::handle::ClothHandle;
use crate::memory::Tally;
use crate::number::real::{Real, V3};
use crate::options::Solver;

/// Steps after which crossings are found again.
const LOOK_STEPS: u32 = 4;
/// Time \[s\] after which crossings that are left are reported.
const LATE_S: f64 = 2.0;

/// Cloths of a scene that cross.
pub struct Tangled {
    of: Untangle,
    /// For each point and particle where it lies in its cloth.
    members: Vec<Member>,
    /// The point of each particle, cloth by cloth; `u32::MAX` for none.
    points: Vec<Vec<u32>>,
    /// Edges that pierce faces now.
    hits: usize,
    /// Time \[s\] that it takes so far.
    seconds: f64,
}

/// Which cloths were looked at, and those that cross.
#[derive(Default)]
pub struct Tangles {
    /// Cloths as they were when crossings were looked for.
    looked: Key,
    /// Cloths of which it is known where they cross at rest.
    at_rest: Vec<ClothHandle>,
    pub some: Option<Box<Tangled>>,
}

impl Tangles {
    /// Looks for crossings in the next frame.
    pub fn forget(&mut self) {
        (self.looked, self.some) = Default::default();
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        if let Some(tangled) = &self.some {
            tangled.of.tally(tally);
            tally.state(&tangled.members);
            tangled.points.iter().for_each(|points| tally.state(points));
        }
    }
}

impl World {
    /// Looks for crossings as a frame begins: of cloths that are there for the first time, that were cut, or into which a state was loaded, and of
    /// those that the tier safe knows to cross.
    pub(super) fn begin_tangles<T: Real>(&mut self, bodies: &mut [Body<T>]) {
        let cloths = self.cloths_with_contact(bodies);
        if cloths.is_empty() || self.control.options.solver == Solver::Classic {
            self.tangles.forget();
            return;
        }
        let key = self.key(&cloths, bodies);
        let fresh = self.tangles.looked != key;
        if fresh {
            (self.tangles.looked, self.tangles.some) = (key, None);
            self.hold_all(bodies);
        }
        if self.tangles.some.is_some() {
            return;
        }
        let all_safe = cloths.iter().all(|cloth| is_safe(&self.scene.cloths[*cloth]));
        let (known, looked) =
            self.safe.as_mut().map_or((false, false), |safe| (std::mem::take(&mut safe.crosses), safe.looked));
        let crosses = known || (fresh && !(all_safe && looked) && self.pairs_of(&cloths, bodies) > 0);
        if fresh {
            self.look_at_rest(&cloths, bodies, crosses);
        }
        if crosses {
            self.tangles.some = Some(self.new_tangled(&cloths, bodies));
            self.look_at_tangles(bodies, at_start);
        }
    }

    fn cloths_with_contact<T: Real>(&self, bodies: &[Body<T>]) -> Vec<usize> {
        let touches = |index: &usize| self.scene.cloths[*index].contact.is_some() && bodies[*index].fabric().is_some();
        (0..bodies.len()).filter(touches).collect()
    }

    /// No particle is loose any more.
    fn hold_all<T: Real>(&mut self, bodies: &mut [Body<T>]) {
        bodies.iter_mut().filter_map(Body::fabric_mut).for_each(|fabric| fabric.loosen(|_| Loose::default()));
        self.safe.iter_mut().for_each(|safe| safe.loosen(|_, _| Loose::default()));
    }

    fn new_tangled<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>]) -> Box<Tangled> {
        let Joined { surface, spacing, members } = self.join_surfaces(cloths, bodies);
        let mut points: Vec<Vec<u32>> = bodies.iter().map(|_| Vec::new()).collect();
        cloths.iter().for_each(|cloth| points[*cloth] = vec![u32::MAX; bodies[*cloth].count()]);
        for point in 0..surface.count() {
            surface.of_point(point).iter().for_each(|t| points[t.cloth as usize][t.particle as usize] = point as u32);
        }
        let layer = |cloth: u32| self.scene.cloths[cloth as usize].contact.map_or(0, |contact| contact.layer);
        Box::new(Tangled { of: Untangle::new(surface, spacing, layer), members, points, hits: 0, seconds: 0.0 })
    }

    /// Finds out once where cloths cross at rest: their particles there keep the whole contact distance.
    fn look_at_rest<T: Real>(&mut self, cloths: &[usize], bodies: &mut [Body<T>], crosses: bool) {
        let handles: Vec<ClothHandle> = cloths.iter().map(|cloth| self.handles[*cloth]).collect();
        if cloths.len() < 2 || self.tangles.at_rest == handles {
            return;
        }
        self.tangles.at_rest = handles;
        let at_rest = |cloth: usize, k: usize| self.scene.cloths[cloth].positions()[k].map(f64::from);
        let rests = |cloth: &usize| {
            let now = bodies[*cloth].now().iter().enumerate();
            now.into_iter().all(|(k, p)| [0, 1, 2].map(|c| p[c].get()) == at_rest(*cloth, k))
        };
        if !crosses && cloths.iter().all(rests) {
            return;
        }
        let mut tangled = self.new_tangled(cloths, bodies);
        let of = &mut tangled.of;
        of.rings = loose::RINGS_AT_REST;
        for point in 0..of.surface.count() {
            let texel = of.surface.of_point(point)[0];
            of.at[point] = at_rest(texel.cloth as usize, texel.particle as usize);
        }
        if of.look() > 0 {
            for cloth in cloths {
                let points = &tangled.points[*cloth];
                let crossed = |particle: u32| tangled.of.loose_at(points[particle as usize]).others;
                bodies[*cloth].fabric_mut().iter_mut().for_each(|fabric| fabric.cross_at_rest(crossed));
            }
        }
    }

    /// For each of some cloths, and each particle, whether it is near a line along which cloths cross at rest; nothing of cloth that has no such
    /// particle.
    pub fn crossed_at_rest(&self, cloths: &[usize]) -> Vec<Vec<bool>> {
        let source = |index: &usize| Source { index: *index, cloth: &self.scene.cloths[*index], holes: &[] };
        let surface = Surface::new(&cloths.iter().map(source).collect::<Vec<_>>());
        let spacing = cloths.iter().map(|index| f64::from(self.scene.cloths[*index].spacing()));
        let mut of = Untangle::new(surface, spacing.fold(f64::INFINITY, f64::min), |_| 0);
        of.rings = loose::RINGS_AT_REST;
        for point in 0..of.surface.count() {
            let texel = of.surface.of_point(point)[0];
            of.at[point] = self.scene.cloths[texel.cloth as usize].positions()[texel.particle as usize].map(f64::from);
        }
        if of.look() == 0 {
            return vec![Vec::new(); cloths.len()];
        }
        let mut crossed: Vec<_> = cloths.iter().map(|index| vec![false; self.scene.cloths[*index].len()]).collect();
        for point in (0..of.loose.len()).filter(|point| of.loose[*point].others) {
            for texel in of.surface.of_point(point) {
                let member = cloths.iter().position(|index| *index == texel.cloth as usize).unwrap_or(0);
                crossed[member][texel.particle as usize] = true;
            }
        }
        crossed
    }

    /// Moves particles after the passes of a step.
    pub(super) fn move_tangles<T: Real>(&self, bodies: &mut [Body<T>]) {
        let Some(tangled) = &self.tangles.some else { return };
        let surface = &tangled.of.surface;
        for (point, way) in tangled.of.moves.iter().enumerate().filter(|(_, way)| **way != [0.0; 3]) {
            for at in surface.starts[point] as usize..surface.starts[point + 1] as usize {
                if let Some(fabric) = bodies[surface.texels[at].cloth as usize].fabric_mut() {
                    fabric.shift(tangled.members[at], way.map(T::of));
                }
            }
        }
    }

    /// Finds the crossings after step `n` of a frame of `steps` steps, in some of them.
    pub(super) fn look_again<T: Real>(&mut self, bodies: &mut [Body<T>], n: u32, steps: u32) {
        let due = (n + 1).is_multiple_of(LOOK_STEPS) || n + 1 == steps;
        if self.tangles.some.is_none() || !due {
            return;
        }
        self.look_at_tangles(bodies, |body, member, _| {
            body.fabric().map_or([f64::NAN; 3], |fabric| fabric.at(member).map(Real::get))
        });
    }

    fn look_at_tangles<T: Real>(&mut self, bodies: &mut [Body<T>], at: impl Fn(&Body<T>, Member, u32) -> V3<f64>) {
        let Some(tangled) = &mut self.tangles.some else { return };
        let Untangle { surface, at: now, free, .. } = &mut tangled.of;
        for point in 0..surface.count() {
            let first = surface.starts[point] as usize;
            let texels = surface.of_point(point);
            let body = &bodies[texels[0].cloth as usize];
            now[point] = at(body, tangled.members[first], texels[0].particle);
            let moves = texels.iter().all(|texel| body.now()[texel.particle as usize][3] > T::of(0.0));
            free[point] = moves && !self.runs[texels[0].cloth as usize].asleep;
        }
        tangled.hits = tangled.of.look();
        if let Some(safe) = &mut self.safe {
            let points = &tangled.points;
            safe.loosen(|cloth, particle| tangled.of.loose_at(points[cloth as usize][particle as usize]));
        }
        for (points, body) in tangled.points.iter().zip(bodies) {
            if let Some(fabric) = body.fabric_mut().filter(|_| !points.is_empty()) {
                fabric.loosen(|particle| tangled.of.loose_at(points[particle as usize]));
            }
        }
    }

    /// Forgets crossings that are gone at the end of a frame. Returns the failure to resolve them, with a cloth.
    pub(super) fn end_tangles<T: Real>(&mut self, bodies: &mut [Body<T>], seconds: f64) -> Option<(usize, Fate)> {
        let tangled = self.tangles.some.as_mut()?;
        let before = tangled.seconds;
        tangled.seconds += seconds;
        let late = before < LATE_S && tangled.seconds >= LATE_S;
        let none = tangled.hits == 0;
        let cloths = self.cloths_with_contact(bodies);
        let pairs = if none || late { self.pairs_of(&cloths, bodies) } else { 0 };
        if none && pairs == 0 {
            self.tangles.some = None;
            self.hold_all(bodies);
            return None;
        }
        if let Some(tangled) = self.tangles.some.as_mut().filter(|_| none) {
            tangled.of.be_thorough();
        }
        late.then(|| (cloths[0], Fate::Tangled { pairs }))
    }
}

/// The position of a particle as a frame begins.
fn at_start<T: Real>(body: &Body<T>, _: Member, particle: u32) -> V3<f64> {
    let p = body.now()[particle as usize];
    [0, 1, 2].map(|c| p[c].get())
}
