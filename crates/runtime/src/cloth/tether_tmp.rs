//! Temporary.
use super::{Cloth, Particle};
#[derive(Clone, Copy)]
pub struct Anchor { pub particle: u32, pub distance: f32 }
pub struct Held { pub per_particle: usize, pub anchors: Vec<Anchor> }
impl Cloth {
    pub fn tether_slots(&self) -> usize { let n = self.particles().iter().filter(|p| matches!(p, Particle::Pinned { .. })).count(); if n > 4 { 1 } else { n } }
    pub fn tethers(&self, _most: usize) -> Held {
        let g = &self.grids()[0]; let w = g.width as usize;
        let pins: Vec<usize> = (0..self.len()).filter(|k| matches!(self.particles()[*k], Particle::Pinned { .. })).collect();
        let h = 1.0 / (w as f32 - 1.0);
        let d = |a: usize, b: usize| { let x = (a % w) as f32 - (b % w) as f32; let y = (a / w) as f32 - (b / w) as f32; (x * x + y * y).sqrt() * h };
        let slots = self.tether_slots();
        let mut out = Vec::new();
        for k in 0..self.len() {
            let mut all: Vec<_> = pins.iter().map(|p| Anchor { particle: *p as u32, distance: d(k, *p) }).collect();
            all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            out.extend_from_slice(&all[..slots]);
        }
        Held { per_particle: slots, anchors: out }
    }
}
