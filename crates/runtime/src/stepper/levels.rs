//! Level of detail: cloths that go on with a coarser image, or with the finer one again.

use super::Stepper;
use crate::coarser::Motion;
use crate::cpu::start::inverse_masses;
use crate::error::Result;
use crate::handle::ClothRef;
use crate::state::{ClothState, Layout};

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
    /// On the GPU the call submits a copy and waits, as [`Stepper::state`]; cloths that change in one call share buffers and a
    /// dispatch as cloths of one scene do, so a crowd changes levels together, some frames apart. Memory of level 0 that is shared with
    /// other cloths is freed with the last of them.
    ///
    /// Errors if there is no such cloth, if it has no coarser image or is cut ([`crate::Error::Coarser`]), and on the device as
    /// [`Stepper::state`]; then nothing has changed.
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
        let new = self.guarded(|stepper| stepper.switch(&wanted.into_iter().collect::<Vec<_>>()))?;
        new.iter().for_each(|(cloth, state)| self.keep(*cloth, state));
        Ok(())
    }

    /// The particle of level 0 that each particle of a cloth on its present level is. Errors if there is no such cloth.
    pub fn level_samples(&self, cloth: impl Into<ClothRef>) -> Result<Vec<u32>> {
        Ok(self.world.samples(self.world.find(cloth.into())?))
    }

    fn switch(&mut self, wanted: &[(usize, u32)]) -> Result<Vec<(usize, ClothState)>> {
        let states = self.states(&wanted.iter().map(|(cloth, _)| *cloth).collect::<Vec<_>>())?;
        let mut switches = Vec::new();
        for ((cloth, level), state) in wanted.iter().zip(&states) {
            let motion = Motion { now: state.positions().to_vec(), before: state.previous().to_vec() };
            switches.push(self.world.switch(*cloth, *level, motion)?);
        }
        let (left, motions) = self.world.replace(switches);
        self.replace_on_device(&left);
        Ok(motions.into_iter().map(|(cloth, motion)| (cloth, self.begin_with(cloth, motion))).collect())
    }

    /// Lets the new image of a cloth begin with a motion. Returns its state.
    fn begin_with(&mut self, cloth: usize, motion: Motion) -> ClothState {
        let (of, run, settings) =
            (&self.world.scene.cloths[cloth], &self.world.runs[cloth], &self.world.control.options);
        let layout = Layout::of(of, &run.tethers, settings.solver);
        let mut head = self.world.head(cloth);
        head.layout = Layout { particles: layout.particles, ..Layout::default() };
        let lists = [&motion.now, &motion.before].into_iter().flatten().flatten();
        let state = ClothState::new(head, lists.map(|x| x.to_bits()).collect());
        let words = state.fit(&layout, &inverse_masses(of, settings.solver), self.world.control.clock.dt_old);
        match &mut self.cpu {
            Some((bodies, threads)) => {
                let mut body = self.world.body_beside(cloth, bodies);
                body.aim(&run.targets(of));
                body.load((of, &run.tethers), settings, &layout, &words);
                if let Some(gpu) = &mut self.gpu {
                    gpu.upload_one(cloth, &body, threads);
                }
                bodies[cloth] = body;
            }
            None => self.fill_on_device(cloth, &layout, &words),
        }
        ClothState::new(self.world.head(cloth), words)
    }
}

#[cfg(feature = "gpu")]
impl Stepper {
    fn replace_on_device(&mut self, left: &[crate::world::Left]) {
        let draw_only = self.cpu.is_some();
        if let Some(gpu) = &mut self.gpu {
            gpu.replace(&self.world, left, draw_only);
        }
    }

    fn fill_on_device(&mut self, cloth: usize, layout: &Layout, words: &[u32]) {
        self.gpu.iter_mut().for_each(|gpu| gpu.fill(cloth, layout, words));
    }
}

#[cfg(not(feature = "gpu"))]
impl Stepper {
    fn replace_on_device(&mut self, _: &[crate::world::Left]) {}

    fn fill_on_device(&mut self, _: usize, _: &Layout, _: &[u32]) {}
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
