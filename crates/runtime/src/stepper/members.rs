//! Cloths that come and go while others keep moving.

use super::Stepper;
use crate::cloth::Cloth;
#[cfg(feature = "gpu")]
use crate::cpu::start::{Start, inverse_masses};
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu::{Gpu, guard};
use crate::handle::{ClothHandle, ClothRef};
use crate::options::Solver;
#[cfg(feature = "gpu")]
use crate::state::{ClothState, Head, Layout};
#[cfg(feature = "gpu")]
use crate::world::Action;
use crate::world::Left;

impl Stepper {
    /// Adds a cloth behind all others. It begins where its positions are, with its velocity, in the next frame; a state that was
    /// saved of the same cloth can be loaded at once ([`Stepper::set_state`]). A cut that waits for the next frame spares it.
    ///
    /// The other cloths go on with the same bits, asleep or awake, with two exceptions. First, substeps and rounds of polish
    /// that the host left open, with [`crate::Quality::Fixed`], rise for all cloths if this one asks for more
    /// ([`crate::Choice`] has the rules), as do substeps that are too few for cloth without tethers
    /// ([`crate::LONGEST_FREE`]); the first cloth of an empty scene decides them. Second, [`crate::Quality::Budget`] and
    /// [`crate::Quality::Error`] choose for all cloths together.
    ///
    /// Costs what the cloth costs in [`Stepper::new`], whatever the number of other cloths: its lists are uploaded, and tethers are found
    /// unless the bundle has them. Buffers of other cloths stay where they are
    /// ([`Stepper::buffers`]). On the GPU pipelines are compiled only for passes that no cloth had before.
    ///
    /// On the GPU a cloth takes the place of a removed one with the same images, and shares its dispatches. If there is none it gets new buffers,
    /// with room for as many more as the scene has of its kind, up to 65,536 particles: a hundred garments of 32 x 32 particles that are added one
    /// by one take 8 dispatches. No cloth takes a place beside a cut one.
    ///
    /// Errors on a cloth that cannot be stepped, and where it does not fit the device; then nothing has changed.
    ///
    /// ```
    /// use gimage_runtime::{Error, Flat, Options, Scene, Stepper};
    ///
    /// let mut stepper = Stepper::on_cpu(Scene::new("crowd"), Options::default())?;
    /// let first = stepper.add_cloth(Flat::square("cape", 9).cloth()?)?;
    /// let second = stepper.add_cloth(Flat::square("scarf", 9).cloth()?)?;
    /// stepper.advance(0.1)?;
    /// stepper.remove_cloth(first)?;
    /// stepper.advance(0.1)?;
    /// assert_eq!(stepper.positions(second), stepper.positions(0));
    /// assert!(matches!(stepper.set_asleep(first, true), Err(Error::NoCloth(_))));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn add_cloth(&mut self, mut cloth: Cloth) -> Result<ClothHandle> {
        self.check_device()?;
        let solver = self.world.control.options.solver;
        let left_out = solver == Solver::Classic && cloth.leave_body();
        let before = self.world.control.clone();
        let recoated = self.world.join(cloth)?;
        let index = self.world.runs.len() - 1;
        if let Err(error) = self.join_device(recoated) {
            self.world.leave(index);
            self.world.control = before;
            return Err(error);
        }
        if let Some((bodies, _)) = &mut self.cpu {
            let body = self.world.body_beside(index, bodies);
            bodies.push(body);
        }
        if left_out {
            self.world.warn_of_body(index);
        }
        Ok(self.world.handles[index])
    }

    /// Removes a cloth and returns its description on its present level, with the pins that it had. The other cloths go on with the same bits;
    /// numbers of substeps and rounds of polish that this cloth alone asked for fall to what the others ask for. Indices of the cloths
    /// behind it fall by one, also in findings and faults; its own are dropped, with its warnings. A script
    /// ([`crate::scene::Script`]) names cloths by their index at the start.
    ///
    /// Its buffers are freed when the host has dropped its copies and the device is done with them; cloths that share them
    /// are freed together. Another cloth may take its place in them: do not draw from them any more. Does not wait and uploads nothing. Errors if the stepper has no such cloth.
    pub fn remove_cloth(&mut self, cloth: impl Into<ClothRef>) -> Result<Cloth> {
        let index = self.world.find(cloth.into())?;
        let left = self.world.leave(index);
        self.leave_device(index, &left);
        if let Some((bodies, _)) = &mut self.cpu {
            bodies.remove(index);
        }
        Ok(left.cloth)
    }

    /// The handles of all cloths, in the order of the scene.
    pub fn handles(&self) -> &[ClothHandle] {
        &self.world.handles
    }

    /// The handle of a cloth. An error if there is no such cloth.
    pub fn handle(&self, cloth: impl Into<ClothRef>) -> Result<ClothHandle> {
        Ok(self.world.handles[self.world.find(cloth.into())?])
    }

    /// The place of a cloth in the list of cloths of [`Stepper::scene`] now. An error if there is no such cloth.
    pub fn index(&self, cloth: impl Into<ClothRef>) -> Result<usize> {
        self.world.find(cloth.into())
    }
}

#[cfg(feature = "gpu")]
impl Stepper {
    fn check_device(&mut self) -> Result<()> {
        self.gpu.as_mut().map_or(Ok(()), Gpu::check)
    }

    /// Makes what the device needs for the last cloth, or nothing.
    fn join_device(&mut self, recoated: bool) -> Result<()> {
        let (world, draw_only) = (&self.world, self.cpu.is_some());
        let Some(gpu) = &mut self.gpu else { return Ok(()) };
        gpu.refuse(world)?;
        let device = gpu.handles().0.clone();
        let coming = guard(&device, || Ok(gpu.prepare(world, draw_only, recoated))).inspect_err(|_| gpu.refused())?;
        gpu.succeeded();
        if gpu.join(world, coming) {
            self.load_start();
        }
        Ok(())
    }

    /// Has the next frame load the start of the last cloth, which has taken the place of another.
    fn load_start(&mut self) {
        let cloth = self.world.runs.len() - 1;
        let (of, run, settings) =
            (&self.world.scene.cloths[cloth], &self.world.runs[cloth], &self.world.control.options);
        let layout = Layout::of(of, &run.tethers, settings.solver);
        let start = Start::<f32>::new(of, settings, self.world.control.clock.dt_old);
        let head = Head { layout: Layout { particles: of.len(), ..Layout::default() }, ..self.world.head(cloth) };
        let lists = [&start.now, &start.before].into_iter().flatten().flatten();
        let state = ClothState::new(head, lists.map(|x| x.to_bits()).collect());
        let words = state.fit(&layout, &inverse_masses(of, settings.solver), self.world.control.clock.dt_old);
        let aim = of.has_aims().then(|| self.world.aim(cloth));
        self.world.host.actions.push(Action::Load { cloth, layout, words });
        self.world.host.actions.extend(aim);
    }

    /// Frees what the device has of a cloth.
    fn leave_device(&mut self, index: usize, left: &Left) {
        let Some(gpu) = &mut self.gpu else { return };
        let device = gpu.handles().0.clone();
        let freed = guard(&device, || {
            gpu.leave(&self.world, index, left);
            Ok(())
        });
        // Other lists of colliders may be needed. The next frame tells.
        if let Err(error) = freed {
            gpu.fail(&error);
        }
    }
}

#[cfg(not(feature = "gpu"))]
impl Stepper {
    fn check_device(&mut self) -> Result<()> {
        Ok(())
    }

    fn join_device(&mut self, _: bool) -> Result<()> {
        Ok(())
    }

    fn leave_device(&mut self, _: usize, _: &Left) {}
}
