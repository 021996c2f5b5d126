//! States out and in: save games, rollback, level switches.

use super::Stepper;
use crate::cpu::bounds;
use crate::cpu::start::inverse_masses;
use crate::error::{Error, Result, StateProblem};
use crate::handle::ClothRef;
use crate::state::{ClothState, Head, Layout, Snapshot};
use crate::world::sleep::corners;
use crate::world::{Action, Kept};

impl Stepper {
    /// The state of a cloth after all calls so far: pins, cuts and transforms that wait for the next frame are done first.
    /// Saving does not change how the cloth moves on, but for [`crate::Cloth::contact`] on the CPU: the next step searches contact afresh, as the
    /// cloth does that continues from the state. Which particles are found may differ where many are near or fast.
    ///
    /// On the CPU a copy. On the GPU it submits a copy and waits for everything submitted before: a game uses
    /// [`Stepper::record_state`] there. Submit what was recorded before the call. Errors if there is no such cloth, and if
    /// reading back fails.
    pub fn state(&mut self, cloth: impl Into<ClothRef>) -> Result<ClothState> {
        let cloth = self.world.find(cloth.into())?;
        let mut states = self.guarded(|stepper| stepper.states(&[cloth]))?;
        let count = self.world.scene.cloths.len();
        let state = states.pop().ok_or(Error::NoSuch { what: "cloth", index: cloth, count })?;
        self.keep(cloth, &state);
        Ok(state)
    }

    /// Puts a cloth into a state that [`Stepper::state`] returned, or that the host has changed
    /// ([`ClothState::set_motion`]). The state may come from another stepper on either backend, if its cloth has the same grids and
    /// particles. With the same backend and settings the cloth continues with the same bits. Pins, cuts and sleep become
    /// the state's; pins, cuts and transforms that wait for the next frame do not touch the cloth. If steps have another length by now,
    /// previous positions are scaled so that velocities stay.
    ///
    /// On the CPU it takes effect at once. On the GPU it is one upload, 48 bytes per particle and more (see
    /// [`ClothState`]), copied at the start of the next frame that is recorded. If the cloth or the state is cut, the
    /// buffers that cuts change are made again, and the cloth's passes are scheduled.
    ///
    /// Errors if there is no such cloth, if the state does not fit it ([`Error::State`]), and on a number that is not finite;
    /// then nothing has changed.
    pub fn set_state(&mut self, cloth: impl Into<ClothRef>, state: &ClothState) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        state.check(&self.world.scene.cloths[cloth], &self.world.runs[cloth].tethers)?;
        self.guarded(|stepper| {
            stepper.make_ready(&[(cloth, &state.head, state.pinned())]);
            stepper.put(cloth, state);
            Ok(())
        })?;
        self.keep(cloth, state);
        Ok(())
    }

    /// The states of all cloths, of the clock, and of what chooses substeps: [`Stepper::state`] for all cloths, with one wait.
    /// Colliders, wind, gravity and settings are the host's, and are not in it.
    pub fn snapshot(&mut self) -> Result<Snapshot> {
        let all: Vec<usize> = (0..self.world.scene.cloths.len()).collect();
        let cloths = self.guarded(|stepper| stepper.states(&all))?;
        let snapshot = Snapshot { control: self.world.save_control(), cloths };
        self.keep_all(&snapshot);
        Ok(snapshot)
    }

    /// Puts all cloths, the clock and what chooses substeps into the state of a snapshot, as [`Stepper::set_state`]. Numbers of
    /// substeps and rounds of polish that the host has given stay. Errors as there, and if the scene has another number of
    /// cloths ([`StateProblem::Cloths`], with the name of the scene); then nothing has changed.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        let (found, expected) = (snapshot.cloths.len(), self.world.scene.cloths.len());
        if found != expected {
            let problem = StateProblem::Cloths { found, expected };
            return Err(Error::State { cloth: format!("of scene {}", self.world.scene.name), problem });
        }
        for ((state, cloth), run) in snapshot.cloths.iter().zip(&self.world.scene.cloths).zip(&self.world.runs) {
            state.check(cloth, &run.tethers)?;
        }
        self.guarded(|stepper| {
            let heads = snapshot.cloths.iter().enumerate().map(|(cloth, state)| (cloth, &state.head, state.pinned()));
            stepper.make_ready(&heads.collect::<Vec<_>>());
            stepper.world.resume_control(&snapshot.control);
            for (cloth, state) in snapshot.cloths.iter().enumerate() {
                stepper.put(cloth, state);
            }
            Ok(())
        })?;
        self.keep_all(snapshot);
        Ok(())
    }

    /// Keeps what a cloth continues from if the device is lost; the lists are shared with the state.
    pub(super) fn keep(&mut self, cloth: usize, state: &ClothState) {
        if self.cpu.is_none() {
            self.world.runs[cloth].kept = Some(Kept { level: self.world.level(cloth), state: state.clone() });
        }
    }

    fn keep_all(&mut self, snapshot: &Snapshot) {
        snapshot.cloths.iter().enumerate().for_each(|(cloth, state)| self.keep(cloth, state));
        self.world.kept = Some(snapshot.control);
    }

    /// The states of some cloths.
    pub(super) fn states(&mut self, cloths: &[usize]) -> Result<Vec<ClothState>> {
        let Some((bodies, threads)) = &mut self.cpu else { return self.read_states(cloths) };
        self.world.act(bodies, threads);
        self.world.safe.iter_mut().for_each(|safe| safe.forget());
        self.world.tangles.forget();
        let save = |cloth: &usize| {
            let head = self.world.head(*cloth);
            bodies[*cloth].forget_contact();
            let words = bodies[*cloth].save(&head.layout);
            ClothState::new(head, words)
        };
        Ok(cloths.iter().map(save).collect())
    }

    #[cfg(not(feature = "gpu"))]
    fn read_states(&mut self, _: &[usize]) -> Result<Vec<ClothState>> {
        Err(Error::NoGpu("Stepper::state"))
    }

    /// Makes cloths ready for the lists of their states; `heads` has their pins too.
    pub(super) fn make_ready(&mut self, heads: &[(usize, &Head, Vec<u32>)]) {
        let cut: Vec<usize> = heads.iter().map(|h| h.0).filter(|c| self.world.scene.cloths[*c].is_cut()).collect();
        let is_cut = |(cloth, head, _): &&(usize, &Head, _)| head.layout.cut || cut.contains(cloth);
        let renewed: Vec<usize> = heads.iter().filter(is_cut).map(|h| h.0).collect();
        for (cloth, head, pinned) in heads {
            self.forget_bounds(*cloth);
            self.world.take(*cloth, head, pinned);
            if self.world.scene.cloths[*cloth].has_aims() {
                let aim = self.world.aim(*cloth);
                self.world.host.actions.push(aim);
            }
        }
        if renewed.is_empty() {
            return;
        }
        self.world.reschedule();
        if let Some(gpu) = &mut self.gpu {
            for cloth in renewed {
                gpu.renew(&self.world, cloth);
                gpu.forget_indices(cloth);
            }
        }
    }

    /// Hands the lists of a state over to what steps.
    pub(super) fn put(&mut self, cloth: usize, state: &ClothState) {
        if self.world.runs[cloth].asleep || self.world.runs[cloth].calm.seconds() > 0.0 {
            let sought = self.world.seek(cloth);
            self.world.found(cloth, &sought, corners(bounds::run(state.positions(), state.previous())));
        }
        self.world.forget_pins(cloth, state.positions());
        let (of, run, settings) =
            (&self.world.scene.cloths[cloth], &self.world.runs[cloth], &self.world.control.options);
        let layout = Layout::of(of, &run.tethers, settings.solver);
        let words = state.fit(&layout, &inverse_masses(of, settings.solver), self.world.control.clock.dt_old);
        match &mut self.cpu {
            Some((bodies, threads)) => {
                self.world.tangles.forget();
                bodies[cloth].load((of, &run.tethers), settings, &layout, &words);
                if let Some(joints) = &run.joints {
                    bodies[cloth].join(&joints.joined);
                    bodies[cloth].lead(of, &joints.joined, joints.now(), 0.0);
                }
                // Cloth that is asleep is not uploaded with the next frame.
                if let Some(gpu) = self.gpu.as_mut().filter(|_| run.asleep) {
                    gpu.upload_one(cloth, &bodies[cloth], threads);
                }
            }
            None => self.world.host.actions.push(Action::Load { cloth, layout, words }),
        }
    }
}
