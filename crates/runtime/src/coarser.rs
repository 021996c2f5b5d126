//! Coarser images of a cloth: about half the texels per side.
//!
//! Each coarse texel is a texel of the fine image. Corners stay corners and borders stay borders, so a side of 2n + 1 texels keeps n + 1 of
//! them, every other one, and a side of 2n texels keeps n + 1 of them, of which the last two are neighbours. The duplicates of a seam
//! point are kept or left out together, so seams of the coarse image close exactly. Where the two sides of a seam begin at odd and
//! at even texels, some cells at its ends are one texel wide. Inside of a grid, rows and columns follow from the borders.
//!
//! The fine image between coarse texels lies in the triangles that are drawn of the coarse image: switching to the fine image does
//! not move the surface.

mod border;
mod lattice;
mod lengths;
mod motion;
mod stitches;
mod table;

use std::sync::Arc;

use crate::cloth::{Anchor, Cloth, Grid, Mass, Particle, Parts, Tethers, Woven};
use crate::error::{Error, Result};
use crate::material::Material;
use lattice::Stencil;
pub(crate) use motion::{Beside, Motion};
#[cfg(all(test, feature = "gpu"))]
pub(crate) use table::lengths;
pub(crate) use table::{FITS, ROUNDS, Table};

/// A coarser image of a cloth, and how the particles of the two correspond. [`Cloth::coarser`] makes it; copies share it.
#[derive(Clone, Debug)]
pub struct Coarser {
    cloth: Cloth,
    map: Arc<Map>,
}

/// How particles correspond.
#[derive(Debug)]
struct Map {
    /// The fine particle of each coarse one.
    samples: Vec<u32>,
    /// Each fine particle in terms of coarse ones.
    stencils: Vec<Stencil>,
    /// The grids of the fine image.
    fine: Vec<Grid>,
}

impl Cloth {
    /// Makes a coarser image with about half the texels per side: an odd side of n texels keeps (n + 1) / 2 of them, an even one n / 2 + 1.
    ///
    /// Every coarse texel takes position, particle kind, limit, texture coordinates and compliance of a texel of this cloth. Masses are
    /// distributed among the coarse particles around each particle, so their sum stays. Rest lengths are measured along the springs. Pins
    /// between coarse texels go to the nearest one. Tethers of the bundle stay if all pins that they lead to are coarse texels, else they are
    /// found again. Cloth of a material gets the membrane and the bending of the same material on the coarse grid. Duplicates of seam
    /// points stay duplicates.
    ///
    /// Costs about a microsecond per particle. Errors if the cloth is cut, if no grid can be coarser ([`Error::Coarser`]), and as
    /// [`Cloth::new`].
    ///
    /// ```
    /// use gimage_runtime::Flat;
    ///
    /// let fine = Flat::square("towel", 33).cloth()?;
    /// let coarser = fine.coarser()?;
    /// let coarse = coarser.cloth();
    /// assert_eq!((coarse.grids()[0].width, coarse.grids()[0].height), (17, 17));
    /// assert!((coarse.total_mass() - fine.total_mass()).abs() < 1e-6);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn coarser(&self) -> Result<Coarser> {
        let refuse = |problem| Err(Error::Coarser { cloth: self.name().into(), problem });
        self.refuse_cut()?;
        let Some(sides) = border::sides(self) else {
            return refuse(
                "its seams leave opposite sides of a grid with different numbers of texels; build it with more texels",
            );
        };
        let (mut grids, mut at): (Vec<Grid>, Vec<[u32; 2]>) = Default::default();
        for (grid, sides) in self.grids().iter().zip(&sides) {
            let (coarse, texels) = lattice::texels(grid, sides, at.len() as u32);
            grids.push(coarse);
            at.extend(texels);
        }
        // Less than that saves nothing worth a switch.
        if 4 * at.len() > 3 * self.len() {
            return refuse("its seams, or the size of its grids, leave no coarser image; build it with more texels");
        }
        let fine_of = |(fine, coarse): (&Grid, &Grid)| {
            let (fine, texels) = (fine.clone(), at[coarse.range()].to_vec());
            texels.into_iter().map(move |[x, y]| fine.first + y * fine.width + x)
        };
        let samples: Vec<u32> = self.grids().iter().zip(&grids).flat_map(fine_of).collect();
        let mut known = vec![false; self.len()];
        if samples.iter().any(|k| std::mem::replace(&mut known[*k as usize], true)) {
            return refuse("its seams would leave cells without an area; build it with more texels");
        }
        let Some(mut particles) = self.linked(&samples) else {
            return refuse("a seam inside of a grid has duplicates that a coarser image does not share");
        };
        let there = |k: u32| particles.get(k as usize).is_some_and(|p| p.exists());
        let mut stencils = Vec::new();
        for (fine, coarse) in self.grids().iter().zip(&grids) {
            if !coarse.range().any(|k| there(k as u32)) {
                return refuse("no texel of a coarser grid has a particle; build it with more texels");
            }
            stencils.extend(lattice::stencils(fine, coarse, &at[coarse.range()], there));
        }
        let stencils = lattice::complete(self, stencils, (&grids, &samples), there);
        let map = Map { samples, stencils, fine: self.grids().to_vec() };
        let pinned: Vec<bool> = self.particles().iter().map(|p| p.is_pinned()).collect();
        hold(&mut particles, &map.pins(&pinned));
        let parts = Parts {
            name: self.name().into(),
            positions: map.take(self.positions()),
            rest: lengths::rest(self, &grids, (&at, &map.take(&self.points())), |k| particles[k].exists()),
            mass: self.share_masses(&map, &particles),
            grids,
            particles,
        };
        self.finish(parts, map)
    }

    /// Errors if the cloth is cut.
    pub(crate) fn refuse_cut(&self) -> Result<()> {
        let problem = "it is cut; change levels before the first cut";
        if self.is_cut() { Err(Error::Coarser { cloth: self.name().into(), problem }) } else { Ok(()) }
    }

    /// Takes the settings of another image of the same cloth.
    pub(crate) fn take_settings(&mut self, other: &Cloth) {
        self.velocity = other.velocity;
        self.damping = other.damping;
        self.speed_limit = other.speed_limit;
        self.thickness = other.thickness;
        self.friction = other.friction;
        self.collision_groups = other.collision_groups;
        self.contact = other.contact;
        self.inertia = other.inertia;
        self.skinning = other.skinning;
    }

    /// The kinds of coarse particles, with seam links; pins are the fine ones of the samples. `None` where only some duplicates of a point
    /// are samples.
    fn linked(&self, samples: &[u32]) -> Option<Vec<Particle>> {
        let mut coarse = vec![None; self.len()];
        samples.iter().enumerate().for_each(|(c, k)| coarse[*k as usize] = Some(c as u32));
        let kind = |k: &u32| {
            if self.particles()[*k as usize].exists() { Particle::Free { next: None } } else { Particle::None }
        };
        let mut particles: Vec<Particle> = samples.iter().map(kind).collect();
        for ring in 0..self.ring_count() {
            let members: Vec<Option<u32>> = self.ring(ring).iter().map(|k| coarse[*k as usize]).collect();
            let kept: Vec<u32> = members.iter().copied().flatten().collect();
            if !kept.is_empty() && kept.len() < members.len() {
                return None;
            }
            for (n, k) in kept.iter().enumerate() {
                particles[*k as usize] = Particle::Free { next: Some(kept[(n + 1) % kept.len()]) };
            }
        }
        Some(particles)
    }

    /// Masses of coarse particles, duplicates with that of their whole point.
    fn share_masses(&self, map: &Map, particles: &[Particle]) -> Mass {
        let mut mass = vec![0.0; map.samples.len()];
        for (stencil, m) in map.stencils.iter().zip(crate::levels::masses(self)) {
            stencil.parts().for_each(|(k, w)| mass[k] += f64::from(w) * m);
        }
        // Each duplicate so far has the share of its own side.
        let mut seen = vec![false; mass.len()];
        for first in 0..mass.len() {
            let mut ring = vec![first];
            while let Some(next) = particles[ring[ring.len() - 1]].next().filter(|n| *n as usize != first) {
                ring.push(next as usize);
            }
            if !std::mem::replace(&mut seen[first], true) {
                let sum: f64 = ring.iter().map(|k| mass[*k]).sum();
                ring.iter().for_each(|k| (mass[*k], seen[*k]) = (sum, true));
            }
        }
        // A particle that no other is near still needs a mass.
        let least = self.total_mass() / self.len().max(1) as f64 * 1e-3;
        Mass::Image(mass.into_iter().map(|m| m.max(least) as f32).collect())
    }

    /// The coarse cloth of its parts, with all else that this cloth has.
    fn finish(&self, parts: Parts, map: Map) -> Result<Coarser> {
        let mut cloth = Cloth::new(parts)?;
        cloth.coarse = true;
        cloth.keep_grain(self.grain().map(|uv| map.take(uv)));
        if let Some(membrane) = self.membrane() {
            let Woven { stiffness: [warp, weft, shear], bend, density } = membrane.woven;
            let mass = cloth.total_mass();
            cloth.set_material(&Material { warp, weft, shear, bend, density, ..Material::default() })?;
            cloth.set_total_mass(mass)?;
        }
        cloth.take_settings(self);
        cloth.compliance = lengths::compliance(self, &map.samples);
        cloth.limits = self.limits.as_ref().map(|limits| map.take(limits).into());
        cloth.backstops = self.backstops.as_ref().map(|backstops| map.take(backstops).into());
        cloth.set_stitches_that_fit(map.stitches(self, &cloth));
        cloth.take_skin(self, &map.samples);
        cloth.take_body(self, &map.samples);
        cloth.keep_tethers(self.stored_tethers().and_then(|held| map.tethers(held)));
        Ok(Coarser { cloth, map: Arc::new(map) })
    }
}

/// Pins particles, or frees them.
fn hold(particles: &mut [Particle], pinned: &[bool]) {
    for (particle, pinned) in particles.iter_mut().zip(pinned).filter(|(p, _)| p.exists()) {
        let next = particle.next();
        *particle = if *pinned { Particle::Pinned { next } } else { Particle::Free { next } };
    }
}

impl Map {
    /// Values of the samples in a list of the fine image.
    fn take<T: Copy>(&self, fine: &[T]) -> Vec<T> {
        self.samples.iter().map(|k| fine[*k as usize]).collect()
    }

    /// Which coarse particles are pinned if these fine ones are: those of pinned texels, and the nearest to every pin that has none
    /// around it.
    fn pins(&self, fine: &[bool]) -> Vec<bool> {
        let mut pinned = self.take(fine);
        let own = pinned.clone();
        for (stencil, _) in self.stencils.iter().zip(fine).filter(|(_, pinned)| **pinned) {
            if !stencil.parts().any(|(k, _)| own[k]) {
                let nearest = stencil.parts().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
                nearest.into_iter().for_each(|(k, _)| pinned[k] = true);
            }
        }
        pinned
    }

    /// Tethers of the fine image, if all their anchors are samples.
    fn tethers(&self, fine: &Tethers) -> Option<Tethers> {
        let mut coarse = vec![None; self.stencils.len()];
        self.samples.iter().enumerate().for_each(|(c, k)| coarse[*k as usize] = Some(c as u32));
        let anchor = |a: &Anchor| match a.exists() {
            true => Some(Anchor { particle: coarse[a.particle as usize]?, ..*a }),
            false => Some(Anchor::NONE),
        };
        let anchors = self.samples.iter().flat_map(|k| fine.of(*k as usize)).map(anchor).collect::<Option<Vec<_>>>()?;
        Some(Tethers { per_particle: fine.per_particle, anchors })
    }
}

impl Coarser {
    /// The coarse cloth.
    pub fn cloth(&self) -> &Cloth {
        &self.cloth
    }

    /// The particle of the fine cloth that each particle of the coarse cloth is.
    pub fn samples(&self) -> &[u32] {
        &self.map.samples
    }

    /// The grids of the fine cloth.
    pub(crate) fn fine_grids(&self) -> &[Grid] {
        &self.map.fine
    }

    /// The number of particles of the fine cloth.
    pub(crate) fn fine_len(&self) -> usize {
        self.map.stencils.len()
    }
}

#[cfg(test)]
#[path = "coarser/tests.rs"]
mod tests;
