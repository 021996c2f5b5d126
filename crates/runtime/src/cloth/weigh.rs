//! The mass of a whole cloth.

use std::sync::Arc;

use super::{Cloth, Mass};
use crate::error::{Result, check};

impl Cloth {
    /// Mass \[kg\] of the whole cloth; a seam point counts once.
    pub fn total_mass(&self) -> f64 {
        let exists = |k: &usize| self.parts.particles[*k].exists();
        let all: f64 = (0..self.len()).filter(exists).map(|k| f64::from(self.mass(k))).sum();
        let again = |ring: &[u32]| ring.iter().skip(1).map(|k| f64::from(self.mass(*k as usize))).sum::<f64>();
        let rings = self.ring_starts.windows(2).map(|r| &self.ring_members[r[0] as usize..r[1] as usize]);
        all - rings.map(again).sum::<f64>()
    }

    /// Scales all masses, so that the whole cloth has `kilograms`. Errors unless that is above 0, and on masses so small
    /// that they have no inverse.
    pub fn set_total_mass(&mut self, kilograms: f64) -> Result<()> {
        check("the mass of a cloth [kg]", kilograms, "above 0", |m| m > 0.0)?;
        let by = kilograms / self.total_mass();
        let scaled = |m: f32| (f64::from(m) * by) as f32;
        let mass = match &*self.parts.mass {
            Mass::Constant(m) => Mass::Constant(scaled(*m)),
            Mass::Image(m) => Mass::Image(m.iter().map(|m| scaled(*m)).collect()),
        };
        self.weigh(mass)
    }

    /// Other masses \[kg\], one a particle. Errors as [`Cloth::new`].
    pub(crate) fn set_masses(&mut self, masses: Vec<f32>) -> Result<()> {
        self.weigh(Mass::Image(masses))
    }

    fn weigh(&mut self, mass: Mass) -> Result<()> {
        super::check::masses(self.name(), &mass, self.particles())?;
        self.parts.mass = Arc::new(mass);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::Flat;

    #[test]
    fn the_whole_has_the_mass_asked_for() {
        let mut cloth = Flat::square("x", 5).cloth().unwrap();
        assert!((cloth.total_mass() - 0.2).abs() < 1e-6);
        cloth.set_total_mass(3.0).unwrap();
        assert!((cloth.total_mass() - 3.0).abs() < 1e-6 && (cloth.mass(0) - 0.12).abs() < 1e-6);
        assert!(cloth.set_total_mass(0.0).is_err() && cloth.set_total_mass(1e-42).is_err());
    }
}
