//! Level of detail: cloths that go on with a coarser image, or with the finer one again.

use std::sync::{Arc, OnceLock};

use super::Stepper;
use crate::coarser::{Coarser, Motion};
use crate::cpu::start::inverse_masses;
#[cfg(feature = "gpu")]
use crate::error::Error;
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu::Carried;
use crate::handle::ClothRef;
use crate::state::{ClothState, Layout};
use crate::world::arrival::{Arrival, Surface};

impl Stepper {
    /// The level of a cloth: 0 is the image that it came with, each further level has about half the texels per side. Errors if there
    /// is no such cloth.
    pub fn level(&self, cloth: impl Into<ClothRef>) -> Result<u32> {
        Ok(self.world.level(self.world.find(cloth.into())?))
    }

    /// Lets a cloth go on with another level of its image. [`Stepper::set_levels`] does the same for several.
    pub fn set_level(&mut self, cloth: impl Into<ClothRef>, level: u32) -> Result<()> {
        self.set_levels(&[(cloth.into(), level)])
    }

    /// Lets cloths go on with other levels of their images, with the positions and velocities that they have. [`crate::level_at`]
    /// chooses a level by distance.
    ///
    /// A coarser image ([`crate::Cloth::coarser`]) begins near the finer surface, which moves where the finer image bends between two coarse
    /// texels; velocities are those of the texels that stay. A finer image begins on the triangles of the coarser one, and the surface
    /// stays where it is. Seams are closed, bit for bit. Handle, pins, settings, teleports and the time that runs stay; actions that wait are done first, and the cloth is
    /// awake. Pins that were set or freed on a coarse level are carried over to the texels around. The other cloths go on with the
    /// same bits: numbers of substeps and rounds of polish stay.
    ///
    /// From here on all calls about the cloth have the particles of its new image: its buffers are other ones
    /// ([`Stepper::buffers`]), [`Stepper::scene`] has the new image, and [`Stepper::level_samples`] says which particles of level 0 it
    /// has. A state is loaded on the level on which it was saved.
    ///
    /// The first switch of the first instance of a cloth makes the coarser image, about a microsecond per particle; instances share it.
    /// On the GPU nothing waits and nothing is read back: the call submits passes that carry positions and velocities, one dispatch per
    /// cloth and level, so submit what was recorded before the call. Their first use compiles them, unless they are prepared
    /// ([`crate::Ahead`]). Cloths that change in one call share buffers and
    /// dispatches of frames as cloths of one scene do, so a crowd changes levels together, some frames apart. Memory of level 0 that is shared with
    /// other cloths is freed with the last of them.
    ///
    /// After the loss of the device the cloth goes on from the last state that the host has seen ([`Stepper::recover`]), on its level
    /// now.
    ///
    /// Errors if there is no such cloth, and if it has no coarser image or is cut ([`crate::Error::Coarser`]); then nothing has changed. Errors
    /// on a device that is lost, or has no memory left for the new buffers: then recover.
    ///
    /// ```
    /// use gimage_runtime::{Error, Flat, Options, Scene, Stepper};
    ///
    /// let mut scene = Scene::new("far away");
    /// scene.cloths.push(Flat::square("cape", 33).cloth()?);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// stepper.advance(0.1)?;
    /// let fine = stepper.positions(0).unwrap_or_default().to_vec();
    /// stepper.set_level(0, 1)?;
    /// let samples = stepper.level_samples(0)?;
    /// let coarse = stepper.positions(0).unwrap_or_default();
    /// assert_eq!(coarse.len(), 17 * 17);
    /// assert!(coarse.iter().zip(samples).all(|(p, k)| (p[1] - fine[k as usize][1]).abs() < 1e-4));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn set_levels(&mut self, levels: &[(ClothRef, u32)]) -> Result<()> {
        let mut wanted = std::collections::BTreeMap::new();
        for (cloth, level) in levels {
            wanted.insert(self.world.find(*cloth)?, *level);
        }
        wanted.retain(|cloth, level| self.world.level(*cloth) != *level);
        if wanted.is_empty() {
            return Ok(());
        }
        wanted.keys().try_for_each(|cloth| self.world.scene.cloths[*cloth].refuse_cut())?;
        let wanted: Vec<_> = wanted.into_iter().collect();
        self.guarded(|stepper| if stepper.cpu.is_some() { stepper.switch(&wanted) } else { stepper.carry(&wanted) })
    }

    /// The particle of level 0 that each particle of a cloth on its present level is. Errors if there is no such cloth.
    pub fn level_samples(&self, cloth: impl Into<ClothRef>) -> Result<Vec<u32>> {
        Ok(self.world.samples(self.world.find(cloth.into())?))
    }

    /// Switches cloths that the CPU steps.
    fn switch(&mut self, wanted: &[(usize, u32)]) -> Result<()> {
        let states = self.states(&wanted.iter().map(|(cloth, _)| *cloth).collect::<Vec<_>>())?;
        let left: Vec<_> = wanted.iter().map(|(cloth, _)| self.departure(*cloth)).collect();
        let mut switches = Vec::new();
        for ((cloth, level), state) in wanted.iter().zip(&states) {
            let motion = Motion { now: state.positions().to_vec(), before: state.previous().to_vec() };
            switches.push(self.world.switch(*cloth, *level, Some(motion))?);
        }
        let motions: Vec<_> = switches.iter_mut().filter_map(|s| Some((s.index, s.motion.take()?))).collect();
        let left_behind = self.world.replace(switches);
        self.replace_drawn(&left_behind);
        motions.into_iter().for_each(|(cloth, motion)| self.begin_with(cloth, &motion));
        wanted.iter().zip(left).for_each(|((cloth, _), left)| self.arrive(*cloth, left));
        Ok(())
    }

    /// A cloth on the level that it is about to leave: its surface, the steps to the level, and the last change if that still shows.
    fn departure(&self, cloth: usize) -> Option<(Surface, Vec<Coarser>, Option<Arc<Arrival>>)> {
        let time = self.world.time_at(1.0);
        let earlier = self.world.runs[cloth].arrival.clone().filter(|arrival| arrival.share(time) > 0.0);
        Some((self.surface(cloth)?, self.world.steps(cloth), earlier))
    }

    /// Keeps how a cloth has changed its level, for meshes that are bound to it.
    fn arrive(&mut self, cloth: usize, left: Option<(Surface, Vec<Coarser>, Option<Arc<Arrival>>)>) {
        let Some(((left, steps, earlier), reached)) = left.zip(self.surface(cloth)) else { return };
        let (since, jumps) = (self.world.time_at(1.0), OnceLock::new());
        self.world.runs[cloth].arrival = Some(Arc::new(Arrival { since, steps, left, reached, earlier, jumps }));
    }

    /// A cloth that the CPU steps, as it is.
    fn surface(&self, cloth: usize) -> Option<Surface> {
        let (bodies, threads) = self.cpu.as_ref()?;
        let body = &bodies[cloth];
        Some(Surface { positions: body.now().to_vec(), normals: body.normals(threads).to_vec() })
    }

    /// Lets the new image of a cloth begin with a motion.
    fn begin_with(&mut self, cloth: usize, motion: &Motion) {
        let Some((bodies, threads)) = &mut self.cpu else { return };
        let (of, run, settings) =
            (&self.world.scene.cloths[cloth], &self.world.runs[cloth], &self.world.control.options);
        let layout = Layout::of(of, &run.tethers, settings.solver);
        let mut head = self.world.head(cloth);
        head.layout = Layout { particles: layout.particles, ..Layout::default() };
        let lists = [&motion.now, &motion.before].into_iter().flatten().flatten();
        let state = ClothState::new(head, lists.map(|x| x.to_bits()).collect());
        let words = state.fit(&layout, &inverse_masses(of, settings.solver), self.world.control.clock.dt_old);
        let mut body = self.world.body_beside(cloth, bodies);
        body.aim(&run.targets(of), &run.spheres(of));
        body.load((of, &run.tethers), settings, &layout, &words);
        if let Some(gpu) = &mut self.gpu {
            gpu.upload_one(cloth, &body, threads);
        }
        bodies[cloth] = body;
    }
}

#[cfg(feature = "gpu")]
impl Stepper {
    /// Makes the buffers again for drawing what the CPU steps.
    fn replace_drawn(&mut self, left: &[crate::world::Left]) {
        if let Some(gpu) = &mut self.gpu {
            gpu.replace(&self.world, left, true);
        }
    }

    /// Switches cloths that the device steps: it carries their motion, and the host does not wait.
    fn carry(&mut self, wanted: &[(usize, u32)]) -> Result<()> {
        let gpu = self.gpu.as_mut().ok_or(Error::NoGpu("Stepper::set_levels"))?;
        let switch = |(cloth, level): &(usize, u32)| self.world.switch(*cloth, *level, None);
        let mut switches = wanted.iter().map(switch).collect::<Result<Vec<_>>>()?;
        let (device, queue) = (gpu.handles().0.clone(), gpu.handles().1.clone());
        let mut encoder = device.create_command_encoder(&Default::default());
        gpu.act_now(&mut self.world, &mut encoder);
        wanted.iter().for_each(|(cloth, _)| gpu.record_departure(&self.world, &mut encoder, *cloth));
        let carried: Vec<Carried> = switches
            .iter_mut()
            .map(|s| Carried { cloth: s.index, from: gpu.motion(s.index), legs: std::mem::take(&mut s.legs) })
            .collect();
        let left = self.world.replace(switches);
        gpu.replace(&self.world, &left, false);
        gpu.carry(&mut encoder, &carried);
        for (cloth, _) in wanted {
            gpu.record_arrival(&self.world, &mut encoder, *cloth)?;
        }
        queue.submit([encoder.finish()]);
        Ok(())
    }
}

#[cfg(not(feature = "gpu"))]
impl Stepper {
    fn replace_drawn(&mut self, _: &[crate::world::Left]) {}

    fn carry(&mut self, _: &[(usize, u32)]) -> Result<()> {
        Err(crate::error::Error::NoGpu("Stepper::set_levels"))
    }
}

/// The level for a cloth at a distance, for [`Stepper::set_levels`]: level k is for distances from `ranges[k - 1]` to `ranges[k]`, in
/// ascending order and in any unit. A cloth on level `now` goes to a finer one only if it is nearer than the range by the share
/// `margin`, 0 to 1, so that cloth at a range does not change back and forth. A distance that is not a number changes nothing.
///
/// ```
/// use gimage_runtime::level_at;
///
/// let ranges = [10.0, 25.0];
/// assert_eq!([2.0, 12.0, 60.0].map(|distance| level_at(distance, 0, &ranges, 0.1)), [0, 1, 2]);
/// assert_eq!([9.5, 8.5].map(|distance| level_at(distance, 1, &ranges, 0.1)), [1, 0]);
/// ```
pub fn level_at(distance: f64, now: u32, ranges: &[f64], margin: f64) -> u32 {
    if distance.is_nan() {
        return now;
    }
    let level = |scale: f64| ranges.iter().take_while(|range| distance >= **range * scale).count() as u32;
    let (coarsest, finest) = (level(1.0 - margin.clamp(0.0, 1.0)), level(1.0));
    now.clamp(finest, coarsest.max(finest))
}
