//! Positions and velocities between the two images.

use super::Coarser;
use crate::cloth::Cloth;

/// Rounds of the fit; even, as two lists take turns.
pub(crate) const FITS: usize = 4;

/// Positions \[m\] of a cloth now and one step before; fourth components have no meaning.
#[derive(Clone, Debug)]
pub struct Motion {
    pub now: Vec<[f32; 4]>,
    pub before: Vec<[f32; 4]>,
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

    /// The motion of the coarse image, `coarse`: the velocities of its texels, at places where its triangles are near the fine surface.
    pub(crate) fn restrict(&self, coarse: &Cloth, fine: &Motion) -> Motion {
        let mut motion = Motion { now: self.map.take(&fine.now), before: self.map.take(&fine.before) };
        self.fit(coarse, fine, &mut motion);
        motion
    }

    /// Moves free particles so that the triangles lie between the heights and depths of the fine surface, not at its texels: half as far
    /// from it at most. Least squares by Jacobi's method.
    fn fit(&self, coarse: &Cloth, fine: &Motion, motion: &mut Motion) {
        let points: Vec<usize> = coarse.points().into_iter().map(|k| k as usize).collect();
        let free: Vec<bool> = (0..coarse.len()).map(|k| coarse.inverse_mass(k) > 0.0).collect();
        let start = motion.now.clone();
        for _ in 0..FITS {
            let mut sums = vec![[0.0f64; 4]; coarse.len()];
            for (stencil, p) in self.map.stencils.iter().zip(&fine.now).filter(|(_, p)| p[3] >= 0.0) {
                let q = stencil.of(&motion.now);
                for (k, w) in stencil.parts() {
                    let (sum, w) = (&mut sums[points[k]], f64::from(w));
                    (0..3).for_each(|c| sum[c] += w * f64::from(p[c] - q[c]));
                    sum[3] += w;
                }
            }
            for k in (0..coarse.len()).filter(|k| free[*k]) {
                let sum = sums[points[k]];
                (0..3).for_each(|c| motion.now[k][c] += (sum[c] / sum[3].max(1e-9)) as f32);
            }
        }
        for ((was, p), from) in motion.before.iter_mut().zip(&motion.now).zip(&start) {
            (0..3).for_each(|c| was[c] += p[c] - from[c]);
        }
    }

    /// The motion of the fine image: that of the triangles of the coarse one. Duplicates of a seam point have the same bits.
    pub(crate) fn prolong(&self, coarse: &Motion) -> Motion {
        let list = |of: &[[f32; 4]]| -> Vec<[f32; 4]> {
            let at = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
            self.map.stencils.iter().map(|s| at(s.of(of))).collect()
        };
        Motion { now: list(&coarse.now), before: list(&coarse.before) }
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

    /// Puts such pins back where they lie beside the coarse ones.
    pub(crate) fn put_beside(&self, beside: &Beside, coarse: &Motion, fine: &mut Motion) {
        for (k, c, way) in beside {
            let at =
                |list: &[[f32; 4]]| [0, 1, 2, 3].map(|n| list[*c as usize][n] + way.get(n).copied().unwrap_or(0.0));
            fine.now[*k as usize] = at(&coarse.now);
            fine.before[*k as usize] = at(&coarse.before);
        }
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
