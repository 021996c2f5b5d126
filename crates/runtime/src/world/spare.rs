//! Places in the buffers that cloths share: those that cloths have left, and room for more, are for later cloths with the same images.
//!
//! A game that adds garments one by one has them in few dispatches, and one that removes and adds them in as many as at the start.

use std::sync::Arc;

use super::World;
use crate::fused::{Like, Roster, Spare, arenas};

/// Particles of the cloths for which an added cloth makes room beside its own, at most: 4 MiB of positions and normals.
const MOST_SPARE: usize = 1 << 16;

impl World {
    /// The properties of a cloth that a place depends on.
    fn like(&self, index: usize) -> Like {
        let (cloth, run) = (&self.scene.cloths[index], &self.runs[index]);
        let (exact, limited, follows) = (cloth.is_exact(), cloth.limits.is_some(), cloth.follows_joints());
        let (backed, worn) = (cloth.backstops.is_some(), cloth.body().is_some());
        Like { instance: run.instance(), exact, limited, backed, worn, follows }
    }

    /// Finds a place for the last cloth: one that another has left, or in new buffers with room for as many more as there are of its kind.
    pub(super) fn find_place(&mut self, index: usize) {
        let Some(room) = self.room else { return };
        let like = self.like(index);
        for roster in self.arenas.iter_mut().filter(|roster| !roster.opened) {
            if let Some(n) = roster.spare.iter().position(|spare| spare.like == like) {
                let Spare { slot, .. } = roster.spare.remove(n);
                let at = roster.slots.partition_point(|s| *s < slot);
                roster.cloths.insert(at, index);
                roster.slots.insert(at, slot);
                return self.drop_images();
            }
        }
        let (cloth, run) = (&self.scene.cloths[index], &self.runs[index]);
        let others = self.runs[..index].iter().filter(|other| other.is_instance_of(run)).count();
        let copies = others.clamp(1, (MOST_SPARE / cloth.len().max(1)).max(1));
        let found = arenas(&vec![cloth.clone(); copies], |_| like.instance, &self.control.options, &room);
        let Some(first) = found.first() else { return };
        let spare = (1..first.cloths.len() as u32).map(|slot| Spare { slot, like }).collect();
        self.arenas.push(Roster { spare, ..Roster::alone(index, cloth) });
        self.keep_images(index);
    }

    /// Takes a cloth out of its arena, as [`World::leave_arena`], and leaves its place to others.
    pub(super) fn leave_place(&mut self, index: usize) -> Option<(usize, usize)> {
        let (like, cut) = (self.like(index), self.scene.cloths[index].is_cut());
        let arena = self.arenas.iter().position(|roster| roster.cloths.contains(&index));
        if let Some(roster) = arena.map(|arena| &mut self.arenas[arena]).filter(|roster| !cut && !roster.opened) {
            let member = roster.cloths.iter().position(|c| *c == index);
            roster.spare.extend(member.map(|member| Spare { slot: roster.slots[member], like }));
            self.keep_images(index);
        }
        let place = self.leave_arena(index);
        self.drop_images();
        place
    }

    /// Takes in that cuts change the lists of arenas with cut cloth.
    pub(super) fn close_places(&mut self) {
        let cloths = &self.scene.cloths;
        for roster in self.arenas.iter_mut().filter(|r| r.cloths.iter().any(|c| cloths[*c].is_cut())) {
            (roster.opened, roster.spare) = (true, Vec::new());
        }
        self.drop_images();
    }

    /// Keeps the images of a cloth for others that come when it has left.
    fn keep_images(&mut self, index: usize) {
        if let Some(images) = &self.runs[index].images
            && !self.spare_images.iter().any(|kept| Arc::ptr_eq(kept, images))
        {
            self.spare_images.push(images.clone());
        }
    }

    /// Drops the images that no place is kept for.
    fn drop_images(&mut self) {
        let arenas = &self.arenas;
        let wanted = |address: usize| arenas.iter().flat_map(|r| &r.spare).any(|s| s.like.instance.1 == address);
        self.spare_images.retain(|images| wanted(Arc::as_ptr(images) as usize));
    }
}
