//! Lists that instances of a cloth share, and what they take.

use super::Fabric;
use super::anchors::Places;
use crate::memory::Tally;
use crate::number::real::Real;

impl<T: Real> Fabric<T> {
    /// Takes the lists that are only read from that of another instance of the same cloth, in place of its own.
    pub fn share(&mut self, other: &Self) {
        for (own, others) in self.springs.iter_mut().flatten().zip(other.springs.iter().flatten()) {
            (own.rest, own.soft) = (others.rest.clone(), others.soft.clone());
        }
        for (own, others) in self.plates.iter_mut().zip(&other.plates) {
            (own.weights, own.compliance) = (others.weights.clone(), others.compliance.clone());
            own.bound = others.bound.clone();
        }
        (self.cells, self.masses) = (other.cells.clone(), other.masses.clone());
        (self.tethers, self.anchors) = (other.tethers.clone(), other.anchors.clone());
        self.places = Places::default();
        (self.members, self.starts) = (other.members.clone(), other.starts.clone());
        if let (Some(own), Some(others)) = (&mut self.stitches, &other.stitches) {
            own.threads = others.threads.clone();
            (own.moved, own.entries) = (others.moved.clone(), others.entries.clone());
        }
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        for springs in self.springs.iter().flatten() {
            tally.image(springs.rest.list());
            tally.image(springs.soft.list());
            tally.state(&springs.sums);
        }
        for plate in &self.plates {
            plate.weights.lists().iter().for_each(|list| tally.image(list));
            tally.image(&plate.compliance);
            tally.image(&plate.bound);
            tally.state(&plate.moments);
        }
        self.cells.iter().flat_map(|cells| &cells.inverse).for_each(|list| tally.image(list));
        for slot in self.tethers.iter().flat_map(|held| &held.slots) {
            tally.image(&slot.most);
            tally.image(&slot.anchor);
            tally.image(&slot.block);
        }
        if let Some(stitches) = &self.stitches {
            tally.image(&stitches.threads);
            tally.image(&stitches.moved);
            tally.image(&stitches.entries);
            tally.state(&stitches.pulls);
            tally.state(&stitches.holds);
        }
        tally.image(&self.anchors);
        self.places.planes.iter().flatten().for_each(|list| tally.state(list));
        tally.image(&self.members);
        tally.image(&self.masses);
        for sheet in &self.sheets {
            [&sheet.now, &sheet.before, &sheet.lost, &sheet.w].into_iter().for_each(|list| tally.state(list));
            tally.state(&sheet.alike);
        }
        self.limits.iter().for_each(|limit| limit.tally(tally));
        self.backstops.iter().for_each(|backstop| backstop.tally(tally));
        for follow in &self.follows {
            tally.state(&follow.places);
            [&follow.to, &follow.drift].into_iter().for_each(|list| tally.state(list));
        }
        self.meeting.iter().for_each(|meeting| meeting.tally(tally));
        self.fields.iter().chain(&self.airs).for_each(|list| tally.state(list));
        [&self.field, &self.airs_of_texels].into_iter().for_each(|list| tally.state(list));
        self.worn.iter().for_each(|worn| worn.tally(tally));
    }
}
