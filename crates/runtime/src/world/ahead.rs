//! The worlds that one may become by calls of the host, whose pipelines are compiled ahead.

use super::World;
use crate::choose::Wish;
use crate::cloth::Cloth;
use crate::error::Result;
use crate::fused::{Room, Roster, arenas};
use crate::options::{Options, Solver};
use crate::scene::Scene;

impl World {
    /// The world of a scene that this one may become, and the rounds of polish that may be in force then, `freed` where the host may free
    /// pins. A cloth of both, known by its name and its start, keeps what was made with it. A scene without such a cloth is that of
    /// another stepper.
    pub fn ahead(&self, scene: &Scene, options: &Options, freed: bool) -> Result<(World, Vec<u32>)> {
        let mut later = World::new(scene.clone(), options.clone())?;
        let kept = self.kept_in(&later);
        let any = kept.iter().any(Option::is_some);
        if let Some(room) = self.room {
            // A scene without a cloth of this one is that of another stepper.
            let room = if any { room } else { room.among(later.scene.cloths.len()) };
            later.make_room(room);
            if any {
                later.arenas = self.arenas_in(&later, &kept, &room);
            }
        }
        for (index, own) in kept.iter().enumerate() {
            let Some(own) = *own else { continue };
            later.scene.cloths[index].exact = self.scene.cloths[own].exact;
            later.runs[index].tethers = self.runs[own].tethers.clone();
        }
        let mut rounds = later.chosen_rounds(freed);
        if any && options == self.control.options.given() {
            let now = self.control.options.polish;
            rounds.push(now);
            let wishes = Wish::of(&later.control.options, &later.scene);
            let joins = kept.iter().zip(wishes).filter(|(own, _)| own.is_none());
            rounds.extend(joins.map(|(_, wish)| wish.polish.max(now)));
        }
        rounds.sort_unstable();
        rounds.dedup();
        later.reschedule();
        Ok((later, rounds))
    }

    /// Takes other rounds of polish.
    pub fn polish(&mut self, rounds: u32) {
        self.control.options.polish = rounds;
        self.reschedule();
    }

    /// For each cloth of another world its index in this one.
    fn kept_in(&self, later: &World) -> Vec<Option<usize>> {
        let mut next = 0;
        let find = |cloth: &Cloth| {
            let same = |own: &usize| {
                let own = &self.scene.cloths[*own];
                own.name() == cloth.name() && own.grids() == cloth.grids() && own.positions() == cloth.positions()
            };
            let own = (next..self.scene.cloths.len()).find(same);
            next = own.map_or(next, |own| own + 1);
            own
        };
        later.scene.cloths.iter().map(find).collect()
    }

    /// The arenas of a world in which some cloths of this one are: each that comes has its own.
    fn arenas_in(&self, later: &World, kept: &[Option<usize>], room: &Room) -> Vec<Roster> {
        let place = |own: &usize| kept.iter().position(|k| *k == Some(*own));
        let stay = self
            .arenas
            .iter()
            .map(|list| Roster::new(list.cloths.iter().filter_map(place).collect(), list.sides.clone()));
        let come = kept.iter().enumerate().filter(|(_, own)| own.is_none()).flat_map(|(index, _)| {
            let alone = std::slice::from_ref(&later.scene.cloths[index]);
            let held = later.runs[index].instance();
            arenas(alone, |_| held, &later.control.options, room)
                .into_iter()
                .map(move |_| Roster::alone(index, &alone[0]))
        });
        stay.chain(come).filter(|list| !list.cloths.is_empty()).collect()
    }

    /// The rounds that are chosen for the scene, and for the same without the pins of some cloths: always those of one of its cloths.
    fn chosen_rounds(&self, freed: bool) -> Vec<u32> {
        let given = self.control.options.given();
        let mut rounds = vec![self.control.choice.polish];
        if freed && given.polish.is_none() && given.substeps.is_none() && given.solver == Solver::Xpbd {
            let mut free = self.scene.clone();
            for cloth in &mut free.cloths {
                let all = (0..cloth.len() as u32).filter(|k| cloth.particles()[*k as usize].is_pinned());
                cloth.hold_all(all.collect::<Vec<_>>().into_iter(), false);
            }
            let wishes = [&self.scene, &free].map(|scene| Wish::of(given, scene));
            rounds.extend(wishes.iter().flatten().map(|wish| wish.polish));
        }
        rounds
    }
}
