//! The state that both backends share: the scene, its schedules and the clock.

#[cfg(feature = "gpu")]
mod ahead;
mod air;
pub(crate) mod arrival;
mod cloth_run;
mod control;
mod crossed;
mod dispatch;
mod disturb;
mod drive;
mod follow;
mod fuse;
mod grabs;
mod held;
mod host;
pub(crate) mod images;
mod joined;
#[cfg(feature = "gpu")]
mod kept;
mod levels;
mod members;
mod moving;
mod patrol;
mod run;
mod save;
pub(crate) mod sleep;
mod spare;
mod stir;
mod touch;
mod truncate;
mod untangle;
mod work;

pub use cloth_run::{ClothRun, Kept};
#[cfg(feature = "gpu")]
pub use fuse::Batch;
pub use fuse::Share;
pub use host::{Action, Fault};
#[cfg(feature = "gpu")]
pub use levels::Leg;
pub use members::Left;
pub use truncate::is_safe;

use std::sync::Arc;

use crate::choose::Settings;
use crate::clock::Progress;
use crate::cloth::Cloth;
use crate::coat::Coats;
use crate::collider::Collider;
use crate::collider::solid::Solid;
use crate::cpu::body::Body;
use crate::error::Result;
use crate::findings::{Sight, Watchdog};
use crate::frame::Frame;
use crate::fused::{Room, Roster, arenas};
use crate::handle::ClothHandle;
use crate::limits::{self, Warning};
use crate::loops;
use crate::number::real::Real;
use crate::options::{Options, Solver};
use crate::passes::{Kinds, Pass, Schedule, schedule};
use crate::quality::Quality;
use crate::scene::Scene;
use crate::state::ControlState;
use crate::step::{Step, StepInput};
use crate::tile::{Order, order};
use control::Control;
use disturb::PathLog;
use drive::Drive;
use held::Seen;
use host::Host;
use images::Images;
use truncate::Safe;
use untangle::Tangles;

/// A scene, what is to be run for it, and when.
pub struct World {
    pub scene: Scene,
    pub control: Control,
    pub host: Host,
    /// Where the host moves colliders.
    pub driven: Drive,
    /// Paths of colliders that boxes on their way may not know of.
    pub paths: PathLog,
    /// Cloths at rest, as found last: memory that is used again.
    resting: Vec<usize>,
    /// How each cloth runs.
    pub runs: Vec<ClothRun>,
    /// The handle of each cloth, in ascending order.
    pub handles: Vec<ClothHandle>,
    /// How colliders meet cloths.
    pub coats: Coats,
    /// Capacity of the device that steps.
    pub room: Option<Room>,
    /// Cloths that lie in the same buffers.
    pub arenas: Vec<Roster>,
    /// Finds failures while cloths move.
    pub watchdog: Watchdog,
    /// Cloths whose contact is safe, on the CPU backend.
    pub safe: Option<Box<Safe>>,
    /// Cloths with contact that cross, on the CPU backend.
    pub tangles: Tangles,
    /// Cloths that the host has examined, on the GPU backend.
    seen: Seen,
    /// The images of cloths that may take places which others have left.
    spare_images: Vec<Arc<Images>>,
    /// The last state of the clock in the host's memory, as [`ClothRun::kept`].
    pub kept: Option<ControlState>,
    /// Whether any cloth is worn on the surface of a body.
    pub any_worn: bool,
}

impl World {
    pub fn new(mut scene: Scene, options: Options) -> Result<Self> {
        options.check()?;
        scene.check()?;
        let control = Control::new(options, &scene);
        let options = &control.options;
        let mut runs: Vec<ClothRun> = Vec::new();
        for (cloth, hold) in scene.cloths.iter_mut().zip(&options.hold) {
            let known = runs.iter().filter_map(|run| run.images.as_ref());
            let run = members::prepare(cloth, options, *hold, (&scene.colliders, known))?;
            runs.push(run);
        }
        let (handles, host) = (runs.iter().map(|_| ClothHandle::fresh()).collect(), Host::default());
        let watchdog = Watchdog::new(scene.cloths.len());
        let (coats, room, arenas) = (Coats::default(), None, Vec::new());
        let (driven, paths, resting) = (Drive::default(), PathLog::default(), Vec::new());
        let mut world = World {
            scene,
            control,
            host,
            driven,
            paths,
            resting,
            runs,
            handles,
            coats,
            room,
            arenas,
            watchdog,
            safe: None,
            tangles: Tangles::default(),
            seen: Seen::default(),
            spare_images: Vec::new(),
            kept: None,
            any_worn: false,
        };
        world.raise();
        // Nothing has moved yet: the first step is like those after it.
        world.control.start();
        world.reschedule();
        Ok(world)
    }

    /// As [`World::new`] for the classic solver, which does not collide with surfaces of bodies: its cloths have none, with a warning.
    pub fn without_bodies(mut scene: Scene, options: Options) -> Result<Self> {
        let left_out: Vec<bool> = scene.cloths.iter_mut().map(Cloth::leave_body).collect();
        let mut world = World::new(scene, options)?;
        for (cloth, _) in left_out.into_iter().enumerate().filter(|x| x.1) {
            world.warn_of_body(cloth);
        }
        Ok(world)
    }

    /// Warns that a cloth does not collide with the surface of its body.
    pub fn warn_of_body(&mut self, cloth: usize) {
        let warning = Warning::BodyLeftOut { cloth: self.scene.cloths[cloth].name().into() };
        self.runs[cloth].warnings.push(warning);
    }

    /// More steps where they are too long for the solver. Steps that are chosen are as few as they are chosen to be.
    fn raise(&mut self) {
        let options = &self.control.options;
        let (asked, step, quality) = (options.substeps, options.step, options.quality);
        // A cut may have left parts that no tether holds.
        let free = |(cloth, run): (&Cloth, &ClothRun)| run.tethers.per_particle == 0 || cloth.is_cut();
        let free = self.scene.cloths.iter().zip(&self.runs).any(free);
        let (made, longest) = limits::fewest(options, free);
        if made > asked && quality == Quality::Fixed {
            self.control.set_substeps(made);
            self.host.raised = Some(Warning::Substeps { asked, made, step, longest });
        }
    }

    /// Decides again what the host left open, as a cloth has lost its last pin, got its first one or met its first collider.
    pub fn decide(&mut self) {
        if self.control.decide(&self.scene) {
            self.reschedule();
        }
        self.raise();
    }

    /// Whether a cloth meets any collider.
    pub fn meets(&self, cloth: usize) -> bool {
        let of = &self.scene.cloths[cloth];
        of.body().is_some() || self.scene.meets(of.met_groups())
    }

    /// Takes other options from the next step on.
    pub fn set_options(&mut self, options: Options) {
        if options.sleep != self.control.options.sleep {
            // Boxes were measured for another kind of rest.
            for cloth in 0..self.runs.len() {
                if !self.runs[cloth].asleep {
                    self.wake(cloth);
                }
            }
        }
        self.control.set(Settings::new(options, &self.scene), &self.scene);
        self.host.raised = None;
        self.raise();
        self.reschedule();
    }

    /// Takes the capacity of the device that will step.
    pub fn make_room(&mut self, room: Room) {
        let held = |cloth: usize| self.runs[cloth].instance();
        self.arenas = arenas(&self.scene.cloths, held, &self.control.options, &room);
        self.room = Some(room);
        self.reschedule();
    }

    /// Puts every cloth back to where it began, as what steps them has lost it. `room` is that of the device that steps from here
    /// on.
    #[cfg(feature = "gpu")]
    pub fn start_again(&mut self, room: Option<Room>) {
        self.scene.cloths.iter_mut().for_each(Cloth::close);
        self.runs.iter_mut().for_each(|run| run.home = Default::default());
        self.wake_all();
        (self.host.actions, self.host.touched, self.host.put) = (Vec::new(), true, true);
        (self.room, self.arenas, self.spare_images) = (None, Vec::new(), Vec::new());
        match room {
            Some(room) => self.make_room(room),
            None => self.reschedule(),
        }
    }

    /// Chooses how many substeps and rounds of polish the next frames have.
    pub fn choose(&mut self) {
        if self.control.choose(&self.scene) {
            self.reschedule();
        }
        self.raise();
    }

    /// Begins a frame of `dt` \[s\] of the host's time: chooses its substeps and returns the steps that are due.
    pub fn begin(&mut self, dt: f64) -> Progress {
        self.choose();
        self.forget_arrivals();
        let progress = self.control.clock.frame(dt);
        if progress.steps > 0 {
            let waited = self.driven.stepped();
            self.lead(progress.steps);
            self.move_frames(waited);
        }
        progress
    }

    /// The passes of a cloth under some settings.
    fn schedule(&self, index: usize, options: &Settings) -> Schedule {
        let (cloth, wind) = (&self.scene.cloths[index], self.scene.wind.as_ref());
        // Only the classic solver has another pass without friction.
        let smooth = options.solver == Solver::Classic && cloth.friction <= 0.0;
        let met = Kinds::of(self.scene.met(cloth.met_groups())).map(|k| Kinds { friction: k.friction && !smooth, ..k });
        let mut schedule = schedule((cloth, self.runs[index].tethers.per_particle as u32), met, wind, options);
        // Speeds are measured where cloth may fall asleep.
        if self.calm_below().is_some() {
            schedule.frame.extend([Pass::Speed, Pass::Fastest]);
        }
        schedule
    }

    /// Works out which passes run; to be called when colliders, wind, rest lengths or seams have changed.
    pub fn reschedule(&mut self) {
        self.recoat();
        for index in 0..self.runs.len() {
            self.runs[index].schedule = self.schedule(index, &self.control.options);
        }
        self.control.round = self.cost_of_round();
        self.fuse();
    }

    /// Works out how cloths meet colliders; whether the list of coats is another one now.
    fn recoat(&mut self) -> bool {
        let (coats, places) = Coats::new(&self.scene, &self.control.options);
        self.runs.iter_mut().zip(places).for_each(|(run, coat)| run.coat = coat);
        let changed = coats != self.coats;
        self.coats = coats;
        changed
    }

    /// The numbers of the first step of a frame and of the others, as far as they depend on the cloth.
    pub fn numbers(&self, index: usize) -> [Step<f64>; 2] {
        let (clock, cloth) = (&self.control.clock, &self.scene.cloths[index]);
        let [gravity, wind] = self.local(index);
        [clock.dt_old, clock.dt].map(|dt_old| {
            let step = Step::new(&StepInput {
                gravity: self.scene.gravity,
                wind: self.scene.wind.as_ref(),
                damping: cloth.damping,
                speed_limit: cloth.speed_limit,
                dt: clock.dt,
                dt_old,
                // The same for all steps of a frame: the air is computed in its first.
                time: clock.time,
            });
            // Noise drifts as it does in the world: its cells do not turn with the frame.
            let wind = if self.scene.wind.is_some() { wind } else { step.wind };
            Step { gravity, wind, ..step }
        })
    }

    /// A frame of `steps` steps of a cloth.
    pub fn frame(&self, cloth: usize, steps: u32) -> Frame<'_> {
        let options = &self.control.options;
        let swept = self.sweeps() || options.solver == Solver::Xpbd && self.leads();
        Frame {
            schedule: &self.runs[cloth].schedule,
            steps,
            rounds: options.iterations,
            hold: self.hold(cloth),
            pyramid: options.pyramid,
            numbers: self.numbers(cloth),
            swept: if swept { self.control.clock.dt } else { 0.0 },
        }
    }

    /// How the passes of a cloth's steps run together by tiles, where any do.
    pub fn order(&self, cloth: usize) -> Option<&Order> {
        let find = || {
            let tiled = self.control.options.fused && self.control.options.solver == Solver::Xpbd;
            let among = (&self.scene.cloths[cloth], self.solid_loops(cloth));
            order(among, &self.runs[cloth].schedule, self.room.as_ref().filter(|_| tiled)?)
        };
        self.runs.get(cloth)?.order.get_or_init(find).as_ref()
    }

    /// Bodies of all cloths at the start.
    pub fn bodies<T: Real>(&self) -> Vec<Body<T>> {
        let mut bodies = Vec::with_capacity(self.runs.len());
        for index in 0..self.runs.len() {
            let body = self.body_beside(index, &bodies);
            bodies.push(body);
        }
        bodies
    }

    /// The colliders as cloths meet them, a list for each of [`World::coats`], where they are as the last step of the frame ends.
    pub fn solids<T: Real>(&self) -> Vec<Vec<Solid<T>>> {
        let (mut solids, lag) = (self.coats.solids(&self.scene.colliders), T::of(self.lag()));
        if lag > T::of(0.0) {
            solids.iter_mut().flatten().filter(|solid| !solid.still).for_each(|solid| *solid = solid.posed(lag));
        }
        solids
    }

    /// Whether contact is swept with colliders that move.
    fn sweeps(&self) -> bool {
        let moves = |c: &Collider| [c.velocity, c.spin].as_flattened().iter().any(|x| *x != 0.0);
        self.control.options.solver == Solver::Xpbd && self.scene.colliders.iter().any(moves)
    }

    /// The time \[s\] from the end of the last step to the end of the frame, by which colliders that move are taken back; 0 if none moves.
    fn lag(&self) -> f64 {
        if self.sweeps() { self.control.clock.rest() } else { 0.0 }
    }

    /// To be called before colliders are uploaded: whether they are elsewhere than at the last upload, as they are if they have `changed`.
    pub fn repose(&mut self, changed: bool) -> bool {
        let lag = self.lag();
        std::mem::replace(&mut self.driven.lag, lag) != lag || changed
    }

    /// Of a cloth's colliders the first, where all lists lie one after the other.
    pub fn first_solid(&self, cloth: usize) -> usize {
        self.coats.first(self.runs[cloth].coat)
    }

    /// The number of colliders that a cloth meets.
    pub fn solid_count(&self, cloth: usize) -> usize {
        self.coats.count(self.runs[cloth].coat)
    }

    /// Iterations of loops for each particle of a cloth, for the colliders that it meets.
    fn solid_loops(&self, cloth: usize) -> u64 {
        loops::of_solids(self.scene.met(self.scene.cloths[cloth].met_groups()))
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
            home: self.runs[index].home,
            now,
            before,
            solids,
            gravity: self.local(index)[0].map(|x| x as f32),
            time: self.control.clock.time + seconds,
            dt: self.control.clock.dt,
            substeps: self.control.options.substeps,
        }
    }
}
