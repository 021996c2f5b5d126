//! Cloth that crosses, on the CPU: hands the cloths that have contact to [`Untangle`] while some of them cross, and moves their particles.

mod in_motion;

use super::World;
use super::joined::Joined;
use super::truncate::{Key, is_safe};
use crate::cpu::body::Body;
use crate::cpu::fabric::seam_steps::Member;
use crate::cpu::truncation::surface::{Source, Surface, Texel};
use crate::cpu::untangle::loose::{self, Loose};
use crate::cpu::untangle::{Found, Untangle};
use crate::findings::Fate;
use crate::handle::ClothHandle;
use crate::memory::Tally;
use crate::number::real::{Real, V3};
use crate::options::Solver;

/// Steps after which crossings are found again.
const LOOK_STEPS: u32 = 4;
/// Time \[s\] after which crossings that are left are reported.
const LATE_S: f64 = 2.0;

/// Time \[s\] without crossings after which those that follow are others.
const QUIET_S: f64 = 0.5;
/// Time \[s\] for which it is watched where cloth has crossed in motion: a fold of few cells, which contact does not hold open, soon crosses again.
const WATCH_S: f64 = 0.5;

/// Cloths of a scene that cross.
pub struct Tangled {
    of: Untangle,
    /// For each point and particle where it lies in its cloth.
    members: Vec<Member>,
    /// The point of each particle, cloth by cloth; `u32::MAX` for none.
    points: Vec<Vec<u32>>,
    /// Whether it crossed in motion: then it is searched around known crossings only.
    in_motion: bool,
    /// Crossings of the last look.
    found: Found,
    /// Time \[s\] since it crossed.
    clean_s: f64,
}

/// Which cloths were looked at, and those that cross.
#[derive(Default)]
pub struct Tangles {
    /// Cloths as they were when crossings were looked for.
    looked: Key,
    /// Cloths of which it is known where they cross at rest.
    at_rest: Vec<ClothHandle>,
    pub some: Option<Box<Tangled>>,
    /// The lists of cloth that crossed in motion before, used again.
    spare: Option<Box<Tangled>>,
    /// Time \[s\] for which cloth crosses now, and since when none has been found that does.
    seconds: f64,
    quiet_s: f64,
    /// Time \[s\] for which crossings are left alone from here on, and how often they were.
    rest_s: f64,
    rests: i32,
}

impl Tangles {
    /// Looks for crossings in the next frame.
    pub fn forget(&mut self) {
        *self = Tangles { at_rest: std::mem::take(&mut self.at_rest), ..Tangles::default() };
    }

    /// Follows the cloths as one leaves the scene; if it is one of those that were looked at, all are looked at again.
    pub fn leave(&mut self, gone: usize) {
        for tangled in [&mut self.some, &mut self.spare].into_iter().flatten() {
            tangled.of.surface.leave(gone);
            if gone < tangled.points.len() {
                tangled.points.remove(gone);
            }
        }
    }

    /// Lets time pass, in which crossings were found or not; whether cloth has crossed for so long that this is reported.
    fn pass(&mut self, seconds: f64, found: bool) -> bool {
        let crosses = found || self.some.as_ref().is_some_and(|tangled| tangled.found.hits > 0);
        self.quiet_s = if crosses { 0.0 } else { self.quiet_s + seconds };
        let before = self.seconds;
        self.seconds = match (crosses, self.quiet_s < QUIET_S) {
            (true, _) => before + seconds,
            (false, true) => before,
            (false, false) => 0.0,
        };
        if self.seconds == 0.0 {
            self.rests = 0;
        }
        before < LATE_S && self.seconds >= LATE_S
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        for tangled in [&self.some, &self.spare].into_iter().flatten() {
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
        for cloth in &cloths {
            bodies[*cloth].fabric_mut().iter_mut().for_each(|fabric| fabric.begin_patrol());
        }
        let key = self.key(&cloths, bodies);
        let fresh = self.tangles.looked != key;
        if fresh {
            self.tangles.forget();
            self.tangles.looked = key;
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
        Box::new(Tangled {
            of: Untangle::new(surface, spacing, layer),
            members,
            points,
            in_motion: false,
            found: Found::default(),
            clean_s: 0.0,
        })
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
        if of.look(|_, texel| at_rest(texel.cloth as usize, texel.particle as usize)).hits > 0 {
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
        let at_rest = |texel: Texel| self.scene.cloths[texel.cloth as usize].positions()[texel.particle as usize];
        if of.look(|_, texel| at_rest(texel).map(f64::from)).hits == 0 {
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
        if self.tangles.some.as_ref().is_some_and(|tangled| tangled.is_heap()) {
            self.give_up(bodies);
        }
    }

    fn look_at_tangles<T: Real>(&mut self, bodies: &mut [Body<T>], at: impl Fn(&Body<T>, Member, u32) -> V3<f64>) {
        let Some(tangled) = &mut self.tangles.some else { return };
        let Untangle { surface, free, .. } = &mut tangled.of;
        for (point, free) in free.iter_mut().enumerate() {
            let texels = surface.of_point(point);
            let body = &bodies[texels[0].cloth as usize];
            let moves = texels.iter().all(|texel| body.now()[texel.particle as usize][3] > T::of(0.0));
            *free = moves && !self.runs[texels[0].cloth as usize].asleep;
        }
        let members = &tangled.members;
        // The tier safe would hold the rest on the wrong side.
        tangled.of.gives_up = self.safe.is_none();
        tangled.found =
            tangled.of.look(|first, texel| at(&bodies[texel.cloth as usize], members[first], texel.particle));
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

    /// Forgets crossings that are gone at the end of a frame, and takes up those that have arisen in it. Returns the failure to resolve crossings, with a cloth.
    pub(super) fn end_tangles<T: Real>(&mut self, bodies: &mut [Body<T>], seconds: f64) -> Option<(usize, Fate)> {
        let cloths = self.cloths_with_contact(bodies);
        if cloths.is_empty() || self.tangles.looked.is_empty() {
            return None;
        }
        let seeds = self.patrol(bodies, &cloths);
        self.take_up(bodies, &cloths, &seeds, seconds);
        let late = self.tangles.pass(seconds, !seeds.is_empty());
        let (none, in_motion, watched) = self.tangles.some.as_mut().map_or((false, true, false), |tangled| {
            let none = tangled.found.hits == 0;
            tangled.clean_s = if none { tangled.clean_s + seconds } else { 0.0 };
            (none, tangled.in_motion, tangled.in_motion && tangled.clean_s < WATCH_S)
        });
        let pairs = if (none && !in_motion) || late { self.pairs_of(&cloths, bodies) } else { 0 };
        if none && !watched && (in_motion || pairs == 0) {
            let tangled = self.tangles.some.take();
            self.tangles.spare = tangled.filter(|_| in_motion).or(self.tangles.spare.take());
            self.hold_all(bodies);
            return None;
        }
        if let Some(tangled) = &mut self.tangles.some {
            if none && !in_motion {
                tangled.of.be_thorough();
            }
            tangled.of.pass(seconds);
            if !none && !tangled.found.is_moved {
                self.give_up(bodies);
            }
        }
        (late && pairs > 0).then(|| (cloths[0], Fate::Tangled { pairs }))
    }
}

/// The position of a particle as a frame begins.
fn at_start<T: Real>(body: &Body<T>, _: Member, particle: u32) -> V3<f64> {
    let p = body.now()[particle as usize];
    [0, 1, 2].map(|c| p[c].get())
}
