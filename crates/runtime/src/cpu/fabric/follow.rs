//! Twin of shaders/follow.wgsl: pinned particles that follow joints are where the skin is at the end of the step.

use super::limit::Limit;
use super::{Fabric, single};
use crate::cloth::Poses;
use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, V3, scale, sub};

/// The particles of a sheet that follow joints while they are pinned.
pub struct Follow<T> {
    /// Where each lies in [`Sheet::w`] and in [`Sheet::now`].
    pub places: Vec<[u32; 2]>,
    /// Where it is at the end of the frame \[m\].
    pub to: Vec<V3<T>>,
    /// How fast it gets there \[m/s\].
    pub drift: Vec<V3<T>>,
}

/// Moves them on, with `left` \[s\] of the frame to go after the step.
pub fn run<T: Real>(sheet: &mut Sheet<T>, follow: &Follow<T>, left: T) {
    for (([single, triple], to), drift) in follow.places.iter().zip(&follow.to).zip(&follow.drift) {
        let at = *triple as usize;
        if sheet.w[*single as usize] != T::of(0.0) {
            continue;
        }
        let was = sheet.at(at);
        (0..3).for_each(|c| sheet.before[at + 2 * c * sheet.half] = was[c]);
        sheet.put(at, sub(*to, scale(*drift, left)));
    }
}

impl<T: Real> Fabric<T> {
    /// From here on these particles, which are in ascending order, follow joints while they are
    /// pinned.
    pub fn join(&mut self, joined: &[u32]) {
        self.follows =
            self.sheets.iter().map(|_| Follow { places: Vec::new(), to: Vec::new(), drift: Vec::new() }).collect();
        for k in joined {
            let (sheet, triple) = self.place(*k as usize);
            let zero = [T::of(0.0); 3];
            let (half, follow) = (self.sheets[sheet as usize].half, &mut self.follows[sheet as usize]);
            follow.places.push([single(triple as usize, half) as u32, triple]);
            follow.to.push(zero);
            follow.drift.push(zero);
        }
    }

    /// The surface that the cloth is worn on goes where these poses put it, at `rate` \[1/s\] from where the last call put it.
    pub fn lead_surface(&mut self, poses: &Poses<T>, rate: T) {
        self.worn.iter_mut().for_each(|worn| worn.lead(poses, rate));
    }

    /// The joined particles, in the order of [`Fabric::join`], are at `ends` \[m\] at the end of the frame, and targets of limits where `at`
    /// puts particles, and spheres behind them where `behind` puts points that move as particles. Each goes there at `rate` \[1/s\] from where
    /// the last call put it.
    pub fn lead(
        &mut self,
        ends: &[V3<T>],
        at: impl Fn(&[u32]) -> Vec<V3<T>>,
        behind: impl Fn(&[(u32, [f32; 3])]) -> Vec<V3<T>>,
        rate: T,
    ) {
        let mut ends = ends.iter();
        for follow in &mut self.follows {
            for ((to, drift), end) in follow.to.iter_mut().zip(&mut follow.drift).zip(&mut ends) {
                *drift = scale(sub(*end, *to), rate);
                *to = *end;
            }
        }
        let each = self.limits.iter_mut().zip(&self.sheets).zip(&self.firsts);
        each.for_each(|((limit, sheet), first)| {
            let particles: Vec<u32> = limit.limited.iter().map(|k| *first as u32 + k).collect();
            limit.lead(sheet, &at(&particles), rate);
        });
        let each = self.backstops.iter_mut().zip(&self.sheets).zip(&self.firsts);
        each.for_each(|((backstop, sheet), first)| {
            let particles = backstop.texels().iter().map(|k| *first as u32 + k);
            let points: Vec<_> = particles.zip(backstop.rest.iter().copied()).collect();
            backstop.lead(sheet, &behind(&points), rate);
        });
    }

    /// From here on these are the targets \[m\] of the limits, and the limits, and the spheres of backstops, by texels.
    pub fn aim(&mut self, targets: &[[f32; 4]], spheres: &[[f32; 4]]) {
        let each = self.backstops.iter_mut().zip(&self.sheets).zip(&self.firsts);
        each.for_each(|((backstop, sheet), first)| backstop.aim(sheet, |k| spheres[first + k]));
        let each = self.limits.iter_mut().zip(&self.sheets).zip(&self.firsts);
        each.for_each(|((limit, sheet), first)| {
            *limit = Limit::new(sheet, |k| {
                let [x, y, z, most] = targets[first + k];
                ([x, y, z], most)
            });
        });
    }
}
