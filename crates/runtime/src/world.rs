//! The state that both backends share: the scene, its schedules and the clock.

mod act;
mod fuse;
mod sleep;

pub use act::Action;
#[cfg(feature = "gpu")]
pub use fuse::Batch;

use std::sync::OnceLock;

use crate::choose::{Choice, Follow, Settings};
use crate::clock::Clock;
use crate::cloth::{Anchor, Cloth, Tethers};
use crate::coat::Coats;
use crate::collider::solid::Solid;
use crate::cpu::body::Body;
use crate::cpu::fused::{self, Frame};
use crate::cpu::rows::Threads;
use crate::error::{Error, Result};
use crate::findings::{Sight, Watchdog, is_risky};
use crate::form::Fused;
use crate::fused::{Room, arenas};
use crate::limits::{self, Warning};
use crate::number::real::{Real, xyz};
use crate::options::{Options, Solver};
use crate::passes::{Kinds, Schedule, has_levels, schedule};
use crate::quality::{Chooser, Quality};
use crate::scene::Scene;
use crate::step::{Step, StepInput};
use crate::tile::{Order, order};
use sleep::Calm;

/// A scene, what is to be run for it, and when.
pub struct World {
    pub scene: Scene,
    /// With all decided that the host left open.
    pub options: Settings,
    /// Why so.
    pub choice: Choice,
    /// Keeps substeps up with the speed of colliders.
    pub follow: Follow,
    pub clock: Clock,
    /// Chooses substeps.
    pub chooser: Chooser,
    pub schedules: Vec<Schedule>,
    /// How colliders meet each cloth.
    pub coats: Coats,
    /// Which of them run in one dispatch.
    pub fused: Vec<Option<Fused>>,
    /// How passes run together of those that do not, found when it is first asked for.
    pub orders: Vec<OnceLock<Option<Order>>>,
    /// Cloths that lie in the same buffers, by index.
    pub arenas: Vec<Vec<usize>>,
    /// What the device that steps has room for.
    pub room: Option<Room>,
    /// What pinned cloths hang on; without slots where nothing does.
    pub tethers: Vec<Tethers>,
    pub asleep: Vec<bool>,
    /// What was changed because the solver cannot do it.
    pub warnings: Vec<Warning>,
    /// The same of steps that were too long.
    pub raised: Option<Warning>,
    /// What has been contained since anybody asked.
    pub faults: Vec<Fault>,
    /// What goes wrong while cloths move.
    pub watchdog: Watchdog,
    /// How long each cloth has been calm.
    pub calm: Vec<Calm>,
    /// What users have done since the last frame.
    pub actions: Vec<Action>,
}

/// A frame that was taken back: particles were NaN, or more than 1e8 m away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Index of the cloth.
    pub cloth: usize,
    /// The last of the particles at fault.
    pub particle: usize,
    /// How many there were.
    pub particles: usize,
    /// End of the frame \[s\], in the time of the scene.
    pub time: f64,
}

/// Most faults kept; older ones are dropped.
const MOST_FAULTS: usize = 64;

impl World {
    pub fn new(mut scene: Scene, options: Options) -> Result<Self> {
        options.check()?;
        scene.check()?;
        let (options, choice) = Settings::new(options, &scene);
        let (clock, follow) = (Clock::new(&options), Follow::new(&options, &scene));
        let (mut warnings, mut tethers) = (Vec::new(), Vec::new());
        for cloth in &mut scene.cloths {
            // It may come from a stepper that has cut it.
            cloth.close();
            let most = limits::prepare(cloth, &options, &mut warnings)?;
            let lies = options.pyramid > 0 && !scene.colliders.is_empty() && has_levels(cloth, &options);
            let lies = lies && !cloth.particles().iter().any(|p| p.is_pinned());
            warnings.extend(lies.then(|| Warning::PyramidOnColliders { cloth: cloth.name().into() }));
            tethers.push(hang(cloth, most, options.slack[tethers.len()]));
        }
        let asleep = vec![false; scene.cloths.len()];
        let watchdog = Watchdog::new(scene.cloths.len());
        let (calm, actions) = (vec![Calm::default(); scene.cloths.len()], Vec::new());
        let mut world = World {
            scene,
            options,
            choice,
            follow,
            clock,
            chooser: Chooser::default(),
            schedules: Vec::new(),
            coats: Coats::default(),
            fused: Vec::new(),
            orders: Vec::new(),
            arenas: Vec::new(),
            room: None,
            tethers,
            warnings,
            raised: None,
            faults: Vec::new(),
            watchdog,
            asleep,
            calm,
            actions,
        };
        world.raise();
        // Nothing has moved yet: the first step is like those after it.
        world.clock = Clock::new(&world.options);
        world.reschedule();
        Ok(world)
    }

    /// More steps where they are too long for the solver. Steps that are chosen are as few as they are chosen to be.
    pub fn raise(&mut self) {
        let (step, asked, quality) = (self.options.step, self.options.substeps, self.options.quality);
        let (made, longest) = limits::fewest(&self.options, &self.scene.cloths, &self.tethers);
        if made > asked && quality == Quality::Fixed {
            self.options.substeps = made;
            self.clock.change(&self.options);
            self.raised = Some(Warning::Substeps { asked, made, step, longest });
        }
    }

    /// Decides again what the host left open, as the cloth has lost its last pin or met its first collider.
    pub fn decide(&mut self) {
        let slack = std::mem::take(&mut self.options.slack);
        let (mut settings, choice) = Settings::new(self.options.given().clone(), &self.scene);
        let polish = self.options.polish;
        self.follow = Follow::new(&settings, &self.scene);
        // Substeps that are chosen from frame to frame go on, and tethers were made with the stepper.
        if self.options.quality != Quality::Fixed {
            settings.substeps = self.options.substeps;
        }
        settings.slack = slack;
        (self.options, self.choice) = (settings, choice);
        self.clock.change(&self.options);
        if polish != self.options.polish {
            self.reschedule();
        }
        self.raise();
    }

    /// What the device that will step has room for.
    pub fn make_room(&mut self, room: Room) {
        let slots = |cloth: usize| self.tethers[cloth].per_particle;
        self.arenas = arenas(&self.scene.cloths, slots, &self.options, &room);
        self.room = Some(room);
        self.fuse();
    }

    /// Chooses how many substeps the next frames have.
    pub fn choose(&mut self) {
        let now = self.options.substeps;
        let substeps = match self.options.quality {
            Quality::Fixed => self.follow.next(now, &self.scene),
            quality => self.chooser.next(quality, now),
        };
        if substeps != self.options.substeps {
            self.options.substeps = substeps;
            self.clock.change(&self.options);
        }
        self.raise();
    }

    /// To be called after the steps of a frame.
    pub fn tick(&mut self, steps: u32) {
        self.chooser.stepped(f64::from(steps) * self.clock.dt);
        self.follow.stepped(f64::from(steps) * self.clock.dt);
        (0..steps).for_each(|_| self.clock.tick());
    }

    /// Works out which passes run; to be called when colliders, wind, rest lengths or seams have changed.
    pub fn reschedule(&mut self) {
        let kinds = Kinds::of(&self.scene.colliders);
        let wind = self.scene.wind.as_ref();
        let cloths = self.scene.cloths.iter().zip(&self.tethers);
        let slots = |t: &Tethers| t.per_particle as u32;
        // Only the classic solver has another pass without friction.
        let smooth = |c: &Cloth| self.options.solver == Solver::Classic && c.friction <= 0.0;
        let met = |c: &Cloth| kinds.map(|k| Kinds { friction: k.friction && !smooth(c), ..k });
        self.schedules = cloths.map(|(c, t)| schedule((c, slots(t)), met(c), wind, &self.options)).collect();
        self.coats = Coats::new(&self.scene.cloths, &self.options);
        self.watch();
        self.fuse();
    }

    /// The numbers of the next step of a cloth.
    pub fn step(&self, cloth: &Cloth, first: bool) -> Step<f64> {
        let (dt, dt_old) = (self.clock.dt, if first { self.clock.dt_old } else { self.clock.dt });
        Step::new(&StepInput {
            gravity: self.scene.gravity,
            wind: self.scene.wind.as_ref(),
            damping: cloth.damping,
            speed_limit: cloth.speed_limit,
            dt,
            dt_old,
            // The noise stands still within a frame, so that its steps share their numbers.
            time: self.clock.time,
        })
    }

    /// Whether step `n` of a frame has the passes on coarser grids.
    pub fn coarse(&self, n: u32) -> bool {
        self.options.pyramid > 0 && n.is_multiple_of(self.options.pyramid)
    }

    /// How the passes of a cloth's steps run together by tiles, where any do.
    pub fn order(&self, cloth: usize) -> Option<&Order> {
        let find = || {
            let tiled = self.options.fused && self.options.solver == Solver::Xpbd;
            order(&self.scene.cloths[cloth], &self.schedules[cloth], self.room.as_ref().filter(|_| tiled)?)
        };
        self.orders.get(cloth)?.get_or_init(find).as_ref()
    }

    /// Time \[s\] from the end of step `n` of `steps` to the end of the frame, where colliders move; else 0.
    pub fn left(&self, n: u32, steps: u32) -> f64 {
        let moves = |c: &crate::collider::Collider| [c.velocity, c.spin].as_flattened().iter().any(|x| *x != 0.0);
        let swept = self.options.solver == Solver::Xpbd;
        if swept && self.scene.colliders.iter().any(moves) { f64::from(steps - 1 - n) * self.clock.dt } else { 0.0 }
    }

    pub fn cloth(&self, index: usize) -> Result<&Cloth> {
        let count = self.scene.cloths.len();
        self.scene.cloths.get(index).ok_or(Error::NoSuch { what: "cloth", index, count })
    }

    /// Bodies of all cloths at the start.
    pub fn bodies<T: Real>(&self) -> Vec<Body<T>> {
        self.scene.cloths.iter().zip(&self.tethers).map(|(c, t)| Body::new(c, t, &self.options)).collect()
    }

    /// The colliders as cloths meet them, a list for each of [`World::coats`].
    pub fn solids<T: Real>(&self) -> Vec<Vec<Solid<T>>> {
        self.coats.solids(&self.scene.colliders)
    }

    /// Of a cloth's colliders the first, where all lists lie one after the other.
    pub fn first_solid(&self, cloth: usize) -> usize {
        self.coats.of(cloth) * self.coats.stride(self.scene.colliders.len())
    }

    /// A cloth as the watchdog sees it, `seconds` after the last step that was counted.
    pub fn sight<'a, T: Real>(
        &'a self,
        index: usize,
        (now, before): (&'a [[T; 4]], &'a [[T; 4]]),
        solids: &'a [Solid<T>],
        seconds: f64,
    ) -> Sight<'a, T> {
        Sight {
            index,
            cloth: &self.scene.cloths[index],
            now,
            before,
            solids,
            gravity: self.scene.gravity,
            time: self.clock.time + seconds,
            dt: self.clock.dt,
            substeps: self.options.substeps,
        }
    }

    /// Runs a frame of `steps` steps on the CPU.
    pub fn run<T: Real>(&mut self, bodies: &mut [Body<T>], threads: &Threads, steps: u32) {
        let solids: Vec<Vec<Solid<T>>> = self.solids();
        let seconds = f64::from(steps) * self.clock.dt;
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        let due = watchdog.is_due(self.clock.time + seconds);
        for (index, body) in bodies.iter_mut().enumerate() {
            if self.asleep[index] {
                continue;
            }
            let (cloth, plan) = (&self.scene.cloths[index], &self.schedules[index]);
            let numbers = [self.step(cloth, true).cast::<T>(), self.step(cloth, false).cast()];
            let step = |n: u32| Step { left: T::of(self.left(n, steps)), ..numbers[usize::from(n > 0)] };
            let frame =
                Frame { plan, steps, rounds: self.options.iterations, coarse: &|n| self.coarse(n), step: &step };
            body.bound_diagonals(T::of(cloth.bound(self.clock.dt).into()));
            let met = &solids[self.coats.of(index)];
            let risky = !met.is_empty() && is_risky(body.now(), body.before(), met, self.clock.dt, seconds);
            let prior: Vec<_> = body.now().iter().filter(|_| risky).map(|p| xyz(*p)).collect();
            fused::run(body, &frame, threads, met);
            let sight = self.sight(index, (body.now(), body.before()), met, seconds);
            if risky {
                watchdog.cross(&sight, &prior, seconds);
            }
            if due {
                watchdog.examine(&sight);
            }
            if let Some((particles, particle)) = body.faulty.take() {
                let time = self.clock.time + seconds;
                self.faults.push(Fault { cloth: index, particle, particles, time });
                let excess = self.faults.len().saturating_sub(MOST_FAULTS);
                self.faults.drain(..excess);
            }
            if let Some(error) = body.strain.take() {
                self.chooser.measured(error.get());
            }
            if let Some(limit) = self.calm_below() {
                self.note(index, body.fastest.get() <= limit, seconds);
            }
        }
        if due {
            watchdog.done(self.clock.time + seconds);
        }
        self.watchdog = watchdog;
        self.tick(steps);
    }
}

/// The tethers of a cloth, in as many slots as are used, where it may have `most` a particle, longer by a factor.
fn hang(cloth: &Cloth, most: u32, slack: f32) -> Tethers {
    if most == 0 || !cloth.particles().iter().any(|p| p.is_pinned()) {
        return Tethers::default();
    }
    let found = cloth.stored_tethers().cloned().unwrap_or_else(|| cloth.tethers(most as usize));
    let used = (0..cloth.len()).map(|k| found.of(k).iter().filter(|a| a.exists()).count()).max().unwrap_or(0);
    let mut ends: Vec<u32> = found.anchors.iter().filter(|a| a.exists()).map(|a| a.particle).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut anchors = Vec::with_capacity(used * cloth.len());
    for k in 0..cloth.len() {
        if ends.len() == used {
            // A slot for each pin: neighbours then hang on the same one, which is quicker.
            let of = |end: &u32| found.of(k).iter().find(|a| a.particle == *end).copied().unwrap_or(Anchor::NONE);
            anchors.extend(ends.iter().map(of));
        } else {
            anchors.extend(&found.of(k)[..used]);
        }
    }
    anchors.iter_mut().for_each(|a| a.distance *= slack);
    Tethers { per_particle: used, anchors }
}
