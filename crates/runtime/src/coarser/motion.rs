//! Motion of a cloth, and its pins between the two images.

use std::sync::Arc;

use super::Coarser;
use crate::cloth::Cloth;
use crate::number::real::with_w;

/// Positions \[m\] of a cloth now and one step before; fourth components have no meaning.
#[derive(Clone, Debug)]
pub struct Motion {
    pub now: Vec<[f32; 4]>,
    pub before: Vec<[f32; 4]>,
}

impl Motion {
    /// Room for the motion of a cloth with these inverse masses: they are the fourth components, all else is 0.
    pub(crate) fn room(inverse_masses: Vec<f32>) -> Self {
        let now: Vec<_> = inverse_masses.into_iter().map(|w| with_w([0.0; 3], w)).collect();
        Motion { before: now.clone(), now }
    }
}

/// Where pins between coarse texels lie: fine particle, coarse particle, and the way from the latter \[m\].
pub type Beside = Vec<(u32, u32, [f32; 3])>;

impl Coarser {
    /// The coarse image of a cloth that has the images of the one that this was made of: where it is, with its pins and settings.
    pub(crate) fn instance(&self, fine: &Cloth) -> Cloth {
        let mut cloth = self.cloth.clone();
        let positions = self.map.take(fine.positions());
        cloth.rename(fine.name());
        if positions != cloth.positions() {
            cloth.put(positions);
        }
        let pins: Vec<bool> = fine.particles().iter().map(|p| p.is_pinned()).collect();
        cloth.set_pins(&self.map.pins(&pins));
        let limits = fine.limits.as_ref().map(|limits| self.map.take(limits));
        if limits.as_deref() != cloth.limits.as_deref() {
            cloth.limits = limits.map(Into::into);
        }
        let backstops = fine.backstops.as_ref().map(|backstops| self.map.take(backstops));
        if backstops.as_deref() != cloth.backstops.as_deref() {
            cloth.backstops = backstops.map(Into::into);
        }
        cloth.take_settings(fine);
        cloth.start_with(fine);
        cloth
    }

    /// The pins of a fine cloth that lie between coarse texels of which not all are pinned.
    pub(crate) fn beside(&self, fine: &Cloth, motion: &Motion) -> Beside {
        let coarse = |k: usize| self.map.samples[k] as usize;
        let pins: Vec<bool> = fine.particles().iter().map(|p| p.is_pinned()).collect();
        let held = self.map.pins(&pins);
        let each = (0..fine.len()).filter(|k| pins[*k]).filter_map(|k| {
            let stencil = &self.map.stencils[k];
            if stencil.parts().all(|(c, _)| held[c]) {
                return None;
            }
            let (c, _) = stencil.parts().filter(|(c, _)| held[*c]).max_by(|a, b| a.1.total_cmp(&b.1))?;
            let (p, q) = (motion.now[k], motion.now[coarse(c)]);
            Some((k as u32, c as u32, [0, 1, 2].map(|n| p[n] - q[n])))
        });
        each.collect()
    }

    /// The particles of the coarse image that are pinned where only these of the fine one are, both in ascending order.
    pub(crate) fn pinned_by(&self, fine: &[u32]) -> Arc<[u32]> {
        let mut pins = vec![false; self.map.stencils.len()];
        fine.iter().for_each(|k| pins[*k as usize] = true);
        self.map.pins(&pins).iter().zip(0..).filter(|(pin, _)| **pin).map(|(_, c)| c).collect()
    }

    /// Carries pins that have changed on the coarse image to the fine one: a fine particle is pinned if all coarse ones around it are.
    pub(crate) fn carry_pins(&self, fine: &mut Cloth, coarse: &Cloth) {
        let mut pins: Vec<bool> = fine.particles().iter().map(|p| p.is_pinned()).collect();
        let was = self.map.pins(&pins);
        let is: Vec<bool> = coarse.particles().iter().map(|p| p.is_pinned()).collect();
        if was == is {
            return;
        }
        for (pin, stencil) in pins.iter_mut().zip(&self.map.stencils) {
            if stencil.parts().any(|(c, _)| was[c] != is[c]) {
                *pin = stencil.parts().all(|(c, _)| is[c]);
            }
        }
        fine.set_pins(&pins);
    }
}

impl Cloth {
    /// Pins particles and frees the others.
    fn set_pins(&mut self, pinned: &[bool]) {
        let differs = |k: &u32| {
            self.particles()[*k as usize].exists() && self.particles()[*k as usize].is_pinned() != pinned[*k as usize]
        };
        let differ: Vec<u32> = (0..self.len() as u32).filter(differs).collect();
        for pin in [false, true] {
            self.hold_all(differ.iter().copied().filter(|k| pinned[*k as usize] == pin), pin);
        }
    }
}
