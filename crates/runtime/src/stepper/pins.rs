//! Pins: which particles are held, and where.

use super::Stepper;
use crate::cpu::place::Placed;
use crate::cpu::start::inverse_masses;
use crate::error::{Error, Result};
use crate::handle::ClothRef;
use crate::options::Solver;

/// Fewest particles for which the inverse masses of the whole cloth are worked out at once.
const MIN_FOR_ALL: usize = 16;

impl Stepper {
    /// Puts particles, and their seam duplicates, at absolute positions \[m\] and at rest, one position per particle, at the
    /// start of the next frame. Meant for pinned particles: a free one moves on from there. Positions do not change within a
    /// frame, so a pin moves by steps of a frame, and fast ones pull at the cloth: pins that ride on something follow it over the substeps
    /// ([`crate::Cloth::bind_to_joint`]). Of several positions for one particle the last counts. Wakes the cloth.
    ///
    /// On the GPU 24 bytes per particle in the upload of the frame, and one dispatch, however many particles there are; calls for one cloth that
    /// follow one another share them. On the CPU about 20 ns per particle.
    ///
    /// Errors if there is no such cloth or particle, if the lists differ in length, on a position that is not finite, and on a pinned
    /// particle that follows joints ([`Stepper::set_joints`]);
    /// then nothing has changed.
    ///
    /// ```
    /// use gimage_runtime::{Flat, Options, Scene, Select, Stepper};
    ///
    /// let mut cloth = Flat::square("flag", 17).cloth()?;
    /// let pole = cloth.select(&Select::Texels { piece: None, from: [0, 0], to: [0, 16] })?;
    /// cloth.pin(&pole)?;
    /// let start: Vec<[f32; 3]> = pole.iter().map(|k| cloth.positions()[*k as usize]).collect();
    /// let mut scene = Scene::new("flag");
    /// scene.cloths.push(cloth);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// for frame in 1..=60 {
    ///     let up = 0.01 * frame as f32;
    ///     let at: Vec<[f32; 3]> = start.iter().map(|p| [p[0], p[1] + up, p[2]]).collect();
    ///     stepper.set_pins(0, &pole, &at)?;
    ///     stepper.advance(1.0 / 60.0)?;
    /// }
    /// assert!((stepper.positions(0).unwrap_or_default()[0][1] - start[0][1] - 0.6).abs() < 1e-6);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn set_pins(&mut self, cloth: impl Into<ClothRef>, particles: &[u32], at: &[[f32; 3]]) -> Result<()> {
        let cloth = self.world.find(cloth.into())?;
        let of = &self.world.scene.cloths[cloth];
        if at.len() != particles.len() {
            let (found, expected) = (at.len(), particles.len());
            return Err(Error::Length { cloth: of.name().into(), what: "positions", found, expected });
        }
        let all = of.with_duplicates(particles)?;
        if let Some(n) = at.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            let index = particles[n] as usize;
            return Err(Error::NotFinite { cloth: of.name().into(), what: "position", index });
        }
        self.refuse_joined(cloth, all.iter().map(|[k, _]| *k))?;
        self.world.note_pins(cloth, all.iter().map(|[k, n]| (*k, at[*n as usize])));
        self.place(
            cloth,
            all.into_iter().map(|[particle, n]| Placed { particle, at: Some(at[n as usize]), inverse_mass: None }),
        );
        Ok(())
    }

    /// Pins particles where they are, and their seam duplicates, at the start of the next frame. Tethers stay those of the
    /// initial pins; cloth that had no pin gets the substeps and rounds of cloth that hangs by its springs ([`Choice`](crate::Choice)). Cloth that comes with its pins
    /// ([`Cloth::pin`](crate::Cloth::pin)) needs fewer. A particle of cloth that follows joints is on the skin again if it was pinned at the start. The same cost as [`Stepper::set_pins`], whose upload it shares. Wakes the cloth. Errors if there is no such
    /// cloth or particle; then nothing has changed.
    pub fn pin(&mut self, cloth: impl Into<ClothRef>, particles: &[u32]) -> Result<()> {
        self.hold(cloth.into(), particles, true)
    }

    /// Frees particles, as [`Stepper::pin`] pins them. A released pin holds nothing until it is pinned again.
    pub fn unpin(&mut self, cloth: impl Into<ClothRef>, particles: &[u32]) -> Result<()> {
        self.hold(cloth.into(), particles, false)
    }

    /// Pins one particle where it is, or frees it: [`Stepper::pin`] or [`Stepper::unpin`].
    pub fn set_pinned(&mut self, cloth: impl Into<ClothRef>, particle: usize, pinned: bool) -> Result<()> {
        let (cloth, particle) = self.particle(cloth.into(), particle)?;
        self.hold(cloth.into(), &[particle], pinned)
    }

    /// Puts one particle at `at` \[m\] and at rest: [`Stepper::set_pins`].
    pub fn set_position(&mut self, cloth: impl Into<ClothRef>, particle: usize, at: [f32; 3]) -> Result<()> {
        let (cloth, particle) = self.particle(cloth.into(), particle)?;
        self.set_pins(cloth, &[particle], &[at])
    }

    /// The index of a cloth, and that of a particle as lists of pins have it.
    fn particle(&self, cloth: ClothRef, index: usize) -> Result<(usize, u32)> {
        let cloth = self.world.find(cloth)?;
        let count = self.world.scene.cloths[cloth].len();
        let particle = u32::try_from(index).map_err(|_| Error::NoSuch { what: "particle", index, count })?;
        Ok((cloth, particle))
    }

    fn hold(&mut self, cloth: ClothRef, particles: &[u32], pinned: bool) -> Result<()> {
        let cloth = self.world.find(cloth)?;
        let all = self.world.scene.cloths[cloth].with_duplicates(particles)?;
        let was_held = self.world.is_held(cloth);
        self.world.scene.cloths[cloth].hold_all(all.iter().map(|[k, _]| *k), pinned);
        let (of, solver) = (&self.world.scene.cloths[cloth], self.world.control.options.solver);
        let every = if all.len() < MIN_FOR_ALL { Vec::new() } else { inverse_masses(of, solver) };
        let share = |k: u32| if solver == Solver::Xpbd { of.ring_of(k).map_or(1, <[_]>::len) } else { 1 };
        let one = |k: u32| of.inverse_mass(k as usize) * share(k) as f32;
        let weigh = |[k, _]: [u32; 2]| {
            let w = every.get(k as usize).copied().unwrap_or_else(|| one(k));
            Placed { particle: k, at: None, inverse_mass: Some(w) }
        };
        let rows: Vec<_> = all.into_iter().map(weigh).collect();
        self.place(cloth, rows);
        if !pinned {
            self.world.control.follow.stir();
        }
        let is_held = self.world.is_held(cloth);
        if is_held != was_held {
            // Tethers are made for the pins that a cloth comes with.
            self.world.scene.cloths[cloth].untethered |= is_held;
            self.world.decide();
        }
        Ok(())
    }

    fn place(&mut self, cloth: usize, rows: impl IntoIterator<Item = Placed>) {
        self.world.wake(cloth);
        self.world.host.place(cloth, rows);
    }
}
