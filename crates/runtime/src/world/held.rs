//! Findings of contact that no triangle crosses on the GPU, whose counts arrive some frames late.

use super::World;
use super::truncate::is_safe;
use crate::crossings::{self, Drawn};
#[cfg(feature = "gpu")]
use crate::findings::thrown;
use crate::findings::{Fate, Watchdog};
use crate::handle::ClothHandle;
#[cfg(feature = "gpu")]
use crate::number::real::with_w;

/// Where the host has seen cloths.
#[derive(Default)]
pub struct Seen {
    /// The most pins of a step so far that contact could not give way to.
    forced: usize,
    /// Cloths that it has examined before.
    known: Vec<ClothHandle>,
    /// The time of the scene \[s\], and the cloths that the host has examined then.
    time: f64,
    cloths: Vec<(ClothHandle, Vec<[f32; 4]>)>,
}

impl World {
    /// Takes in the most pins that left cloth no room, and the most particles that were too fast, of the steps of a frame.
    #[cfg(feature = "gpu")]
    pub fn note_held(&mut self, forced: usize, slowed: usize) {
        self.seen.forced = self.seen.forced.max(forced);
        if let (true, Some(cloth)) = (slowed > 0, self.scene.cloths.iter().position(is_safe)) {
            self.report(cloth, Fate::Slowed { particles: slowed });
        }
    }

    /// Counts the crossings of a cloth with itself, and with the others that the host has examined at this time, where it is examined for the first
    /// time and where pins left cloth no room.
    pub fn look_at_crossings(&mut self, cloth: usize, now: &[[f32; 4]]) {
        // Only the device knows which triangles of cut cloth are left.
        let of = &self.scene.cloths[cloth];
        if !is_safe(of) || of.is_cut() {
            return;
        }
        let first = !self.seen.known.contains(&self.handles[cloth]);
        if !first && self.seen.forced == 0 {
            return;
        }
        if first {
            // Those of cloths that have left go with the next new one.
            self.seen.known.retain(|known| self.handles.contains(known));
            self.seen.known.push(self.handles[cloth]);
        }
        let time = self.control.clock.time;
        if self.seen.time != time {
            (self.seen.time, self.seen.cloths) = (time, Vec::new());
        }
        let handle = self.handles[cloth];
        self.seen.cloths.retain(|(other, _)| *other != handle);
        self.seen.cloths.push((handle, now.to_vec()));
        let drawn = |(handle, now): &'_ (ClothHandle, Vec<[f32; 4]>)| {
            let index = self.handles.iter().position(|known| known == handle)?;
            Some((index, now.len() == self.scene.cloths[index].len()))
        };
        let there: Vec<_> = self.seen.cloths.iter().map(drawn).collect();
        let each = self.seen.cloths.iter().zip(&there);
        let drawn: Vec<Drawn> = each
            .filter_map(|((_, now), there)| Some(Drawn::at(&self.scene.cloths[there.filter(|t| t.1)?.0], now)))
            .collect();
        let Ok(found) = crossings::find(&drawn, 0) else { return };
        if found.total() + found.touching > 0 {
            let (pairs, touching, forced) = (found.total(), found.touching, self.seen.forced);
            self.report(cloth, Fate::Crossed { pairs, touching, forced });
        }
    }

    /// Looks for cloth that begins its first frame, of `steps` steps, inside colliders, where its positions are known only then: on the GPU. The
    /// first pose of cloth that follows joints is not known either.
    #[cfg(feature = "gpu")]
    pub fn look_at_starts(&mut self, steps: u32) {
        if steps == 0 {
            return;
        }
        let (time, dt) = (self.control.clock.time, self.control.clock.dt);
        let seconds = f64::from(steps) * dt;
        let mut solids = None;
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        for (index, run) in self.runs.iter().enumerate() {
            if !watchdog.take_put(index) || !watchdog.comes(index, time) || run.joints.is_some() || !self.meets(index) {
                continue;
            }
            let cloth = &self.scene.cloths[index];
            let at = |(k, p): (usize, &[f32; 3])| with_w(run.home.apply(*p), cloth.inverse_mass(k));
            let now: Vec<[f32; 4]> = cloth.positions().iter().enumerate().map(at).collect();
            let met = &solids.get_or_insert_with(|| self.solids())[run.coat];
            let thrown = thrown::search(&now, met, dt, seconds);
            watchdog.throw::<f32>(&self.sight(index, (&[], &[]), &[], seconds), thrown);
        }
        self.watchdog = watchdog;
    }

    /// Reports a failure of a cloth that its positions do not tell.
    pub fn report(&mut self, cloth: usize, fate: Fate) {
        let mut watchdog = std::mem::replace(&mut self.watchdog, Watchdog::new(0));
        watchdog.find::<f32>(&self.sight(cloth, (&[], &[]), &[], 0.0), fate);
        self.watchdog = watchdog;
    }
}
