//! Several cloths as one surface, on the CPU.

use super::World;
use crate::cpu::body::Body;
use crate::cpu::fabric::seam_steps::Member;
use crate::cpu::truncation::surface::{Source, Surface};
use crate::number::real::Real;

/// The surface of some cloths.
pub struct Joined {
    pub surface: Surface,
    /// Least of the mean distances of neighbours of the cloths \[m\].
    pub spacing: f64,
    /// For each point and particle where it lies in its cloth.
    pub members: Vec<Member>,
}

impl World {
    /// That of the cloths with these indices.
    pub(super) fn join_surfaces<T: Real>(&self, cloths: &[usize], bodies: &[Body<T>]) -> Joined {
        let source = |index: &usize| {
            let (cloth, holes) = (&self.scene.cloths[*index], &*bodies[*index].holes);
            Source { index: *index, cloth, holes }
        };
        let surface = Surface::new(&cloths.iter().map(source).collect::<Vec<_>>());
        let spacing = |index: &usize| f64::from(self.scene.cloths[*index].spacing());
        let spacing = cloths.iter().map(spacing).fold(f64::INFINITY, f64::min);
        let member = |cloth: u32, particle: u32| {
            bodies[cloth as usize].fabric().map_or(Member::default(), |fabric| fabric.member(particle))
        };
        let members = surface.texels.iter().map(|texel| member(texel.cloth, texel.particle)).collect();
        Joined { surface, spacing, members }
    }
}
