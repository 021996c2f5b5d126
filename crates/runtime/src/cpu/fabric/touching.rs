//! Contact of a cloth with other cloths, and with a body that it is worn on.

use super::Fabric;
use super::meeting::Meeting;
use super::meeting::patrol::Suspect;
use super::meeting::shadow::{Dawn, Shadow};
use super::seam_steps::Member;
use crate::cpu::surface::Worn;
use crate::cpu::untangle::loose::Loose;
use crate::number::real::{Real, V3, add, dot, scale, sub};

impl<T: Real> Fabric<T> {
    /// The position of a particle.
    #[inline]
    pub fn at(&self, member: Member) -> V3<T> {
        self.sheets[member.sheet as usize].at(member.at as usize)
    }

    /// Puts a particle at a position; the previous one is changed so that of the motion along the change only what led into it ends.
    pub fn hold_back(&mut self, member: Member, to: V3<T>) {
        let sheet = &mut self.sheets[member.sheet as usize];
        let at = member.at as usize;
        let change = sub(to, sheet.at(at));
        let long = dot(change, change).sqrt();
        if long <= T::of(0.0) {
            return;
        }
        let was: V3<T> = [0, 1, 2].map(|c| sheet.before[at + 2 * c * sheet.half]);
        let ahead = dot(sub(sheet.at(at), was), change) / long;
        // Contact pushes and lets previous positions follow: a push that is held back must leave no speed the other way.
        let follows = (ahead + long).min(long).max(T::of(0.0)) / long;
        let was = add(was, scale(change, follows));
        sheet.put(at, to);
        for (c, was) in was.into_iter().enumerate() {
            let place = at + 2 * c * sheet.half;
            sheet.before[place] = was;
            if let Some(lost) = sheet.lost.get_mut(place) {
                *lost = T::of(0.0);
            }
        }
    }

    /// Moves a particle without a change of its velocity.
    pub fn shift(&mut self, member: Member, way: V3<T>) {
        let sheet = &mut self.sheets[member.sheet as usize];
        let at = member.at as usize;
        sheet.put(at, add(sheet.at(at), way));
        for (c, way) in way.into_iter().enumerate() {
            let place = at + 2 * c * sheet.half;
            sheet.before[place] = sheet.before[place] + way;
        }
    }

    /// From the next step on contact with cloth does not push particles away from those that they may pass.
    pub fn loosen(&mut self, loose: impl Fn(u32) -> Loose) {
        self.meeting.iter_mut().for_each(|meeting| meeting.loosen(&loose));
    }

    /// Takes in which particles are near a line along which cloths cross at rest: these keep the whole distance.
    pub fn cross_at_rest(&mut self, is_crossed: impl Fn(u32) -> bool) {
        self.meeting.iter_mut().for_each(|meeting| meeting.cross_at_rest(&is_crossed));
    }

    /// Begins the looks for cloth that crosses in a frame.
    pub fn begin_patrol(&mut self) {
        self.meeting.iter_mut().for_each(Meeting::begin_patrol);
    }

    /// Pairs of particles around which cloth may cross, found in this frame.
    pub fn suspects(&self) -> &[Suspect] {
        self.meeting.as_ref().and_then(|meeting| meeting.patrol.as_ref()).map_or(&[], |patrol| &patrol.suspects)
    }

    /// The particle of a place in the lists of contact.
    pub fn particle_at(&self, place: u32) -> Option<u32> {
        self.meeting.as_ref()?.tiles.texel.get(place as usize).copied().filter(|particle| *particle != u32::MAX)
    }

    /// The first duplicate of a particle of cloth that has contact.
    pub fn point(&self, particle: u32) -> u32 {
        let first = |meeting: &Meeting<T>| meeting.kin.first.get(particle as usize).copied();
        self.meeting.as_ref().and_then(first).unwrap_or(particle)
    }

    /// The shadow of cloth that has contact, for other cloths in a frame.
    pub fn shadow(&mut self, dawn: &Dawn<T>) -> Option<Shadow<T>> {
        self.meeting.as_mut().map(|meeting| meeting.shadow(dawn))
    }

    /// Takes in the shadows of all cloths, its own at `own`. Returns the cloths that are asleep and wake.
    pub fn meet(&mut self, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<usize> {
        self.meeting.as_mut().map_or(Vec::new(), |meeting| meeting.meet(shadows, own))
    }

    /// Takes in where particles of other cloths that it may meet are now.
    pub fn follow_others(&mut self, shadows: &[Option<Shadow<T>>], own: usize) {
        self.meeting.iter_mut().for_each(|meeting| meeting.follow(shadows, own));
    }

    /// Searches contact afresh in the next step.
    pub fn forget_contact(&mut self) {
        self.meeting.iter_mut().for_each(Meeting::forget);
        self.forget_surface();
    }

    /// Searches the nearest points of a body afresh in the next step, where particles may be anywhere.
    pub fn forget_surface(&mut self) {
        self.worn.iter_mut().for_each(Worn::forget);
    }

    /// Takes back its shadow.
    pub fn keep(&mut self, shadow: Shadow<T>) {
        if let Some(meeting) = &mut self.meeting {
            meeting.keep(shadow);
        }
    }
}
