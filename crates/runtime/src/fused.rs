//! Which cloths lie in the same buffers, so that they can share dispatches, and which of them run their whole frame in one, a workgroup
//! a cloth.
//!
//! A cloth whose positions fit the memory of a workgroup needs no dispatch a colour: barriers part the colours, and
//! between the first step and the last nothing but its previous positions leaves the workgroup. Cloths whose frames need
//! the same code are steps of one dispatch, however many and however different in size and material they are.

mod room;

use std::collections::BTreeSet;
use std::sync::Arc;

pub(crate) use room::NOTES;
pub use room::Room;

use crate::cloth::{Cloth, Rest};
use crate::form::{Fused, Hold};
use crate::levels;
use crate::options::{Options, Solver};
use crate::passes::{Pass, Schedule, Soft, has_levels, soft_of};
use crate::shaders::{self, HEAD, LISTED, Slot, listed};
use crate::tuning::MIN_THREADS as LEAST;

impl Fused {
    /// The whole frame of a schedule; `None` if the cloth does not fit the memory of a workgroup.
    pub(crate) fn of(cloth: &Cloth, schedule: &Arc<Schedule>, room: &Room) -> Option<Self> {
        let hold = room.hold(cloth.len(), 0)?;
        let many = schedule.relax.iter().any(|p| matches!(p, Pass::Contact(kinds) if kinds.many));
        Some(Fused {
            schedule: schedule.clone(),
            full: many && room.hold(cloth.len(), NOTES) != Some(hold),
            hold,
            places: (cloth.len() as u32).next_multiple_of(64),
            threads: (cloth.len() as u32 / room.per_thread())
                .next_power_of_two()
                .clamp(LEAST, room.tuning.for_whole(room.threads)),
        })
    }

    /// Storage buffers that the frame of a schedule binds; `None` if one of its passes cannot be part of a whole frame.
    pub(crate) fn buffers(schedule: &Arc<Schedule>) -> Option<usize> {
        let fused = Fused { schedule: schedule.clone(), full: false, hold: Hold::Narrow, places: 64, threads: LEAST };
        let uniform = |slot| matches!(slot, Slot::Frame | Slot::Batch | Slot::Part);
        let bound = |fused| shaders::whole(fused).bindings.iter().filter(|b| !uniform(b.slot)).count();
        shaders::is_whole(schedule).then(|| bound(&fused))
    }

    /// Without what may differ within a batch.
    pub(crate) fn kind(&self) -> Self {
        Fused { places: 0, threads: 0, ..self.clone() }
    }

    /// Whether the shader of another whole frame has room for it.
    #[cfg(feature = "gpu")]
    pub(crate) fn fits(&self, other: &Self) -> bool {
        self.places <= other.places && self.threads <= other.threads && self.kind() == other.kind()
    }

    /// Room for both.
    pub(crate) fn with(&self, other: &Self) -> Self {
        Fused { places: self.places.max(other.places), threads: self.threads.max(other.threads), ..self.clone() }
    }
}

/// Cloths that lie in the same buffers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roster {
    /// Their indices, in the order of their slots.
    pub cloths: Vec<usize>,
    /// The place of each in the buffers, in ascending order.
    pub slots: Vec<u32>,
    /// Columns and rows of the grids that tiles are made for: those of the cloths that do not fit a workgroup, of all if they do. They stay as
    /// cloths leave, so that no tile is compiled again.
    pub sides: Vec<[u32; 2]>,
    /// Places that no cloth has.
    pub spare: Vec<Spare>,
    /// Whether a cut has changed its lists. Then no cloth takes a place there.
    pub opened: bool,
}

/// A place in the buffers of an arena that a cloth may take which comes later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spare {
    pub slot: u32,
    pub like: Like,
}

/// The properties that a cloth has to have for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Like {
    /// Tethers of a particle, and a number that instances of a cloth share.
    pub instance: (usize, usize),
    pub exact: bool,
    pub limited: bool,
    pub backed: bool,
    /// Whether it is worn on the surface of a body.
    pub worn: bool,
    /// Whether it follows joints, and so has targets of its own.
    pub follows: bool,
}

impl Roster {
    /// That of cloths which have the first places.
    pub fn new(cloths: Vec<usize>, sides: Vec<[u32; 2]>) -> Self {
        Roster { slots: (0..cloths.len() as u32).collect(), cloths, sides, ..Roster::default() }
    }

    /// That of a cloth that lies alone.
    pub fn alone(index: usize, cloth: &Cloth) -> Self {
        Roster::new(vec![index], sides(cloth).collect())
    }
}

fn sides(cloth: &Cloth) -> impl Iterator<Item = [u32; 2]> {
    cloth.grids().iter().map(|g| [g.width, g.height])
}

/// Cloths that lie in the same buffers.
///
/// `held` has the number of tethers of a particle, and a number that instances of a cloth share.
pub fn arenas(cloths: &[Cloth], held: impl Fn(usize) -> (usize, usize), options: &Options, room: &Room) -> Vec<Roster> {
    let mut arenas: Vec<Arena<_>> = Vec::new();
    for (index, cloth) in cloths.iter().enumerate() {
        if options.solver != Solver::Xpbd || !options.fused {
            continue;
        }
        let (image, rings) = (matches!(cloth.rest(), Rest::Image(_)), cloth.ring_count() > 0);
        let soft = soft_of(cloth);
        let aimed = (cloth.limits.is_some(), cloth.backstops.is_some(), cloth.follows_joints());
        let sewn = cloth.sewing().is_some();
        let worn = cloth.body().is_some();
        let fabric = (cloth.is_exact(), cloth.bending().is_some(), cloth.membrane().is_some(), aimed, sewn, worn);
        let (slots, instance) = held(index);
        let leveled = has_levels(cloth, options);
        let kind = (image, rings, soft, slots, fabric, leveled);
        // Those of lists that are only read, of what lasts, or of scratch: forces and velocities of air, multipliers of springs and of
        // bending, and pulls of stitches.
        let vectors = 2 + usize::from(soft != Soft::None) + usize::from(cloth.bending().is_some()) + usize::from(sewn);
        let places = room_of(cloth.len());
        let follows = u64::from(cloth.follows_joints());
        let own = u64::from(cloth.is_aimed()) + follows + u64::from(cloth.backstops.is_some()) * (1 + follows);
        let own = 16 * places as u64 * (own + u64::from(worn) * Slot::SurfacePlanes.vectors());
        let images = listed(cloth, slots, places) as u64 - listed(cloth, slots, 0) as u64 - own;
        let lists = listed(cloth, slots, 0) as u64 + own;
        let [rows, shared] = if leveled { levels::listed(cloth) } else { [0; 2] };
        let (lists, images) = (lists + rows as u64, images + shared as u64);
        let nodes = if leveled { 32 * levels::rows(cloth).1 } else { 0 };
        let vectors = (16 * places * vectors).max(nodes) as u64;
        if (lists + images + HEADS).max(vectors) > room.bytes {
            continue;
        }
        let more = |a: &Arena<_>| lists + if a.instances.contains(&instance) { 0 } else { images };
        let fits =
            |a: &&mut Arena<_>| a.kind == kind && a.lists + more(a) <= room.bytes && a.vectors + vectors <= room.bytes;
        match arenas.iter_mut().find(fits) {
            Some(arena) => {
                arena.lists += more(arena);
                arena.vectors += vectors;
                arena.instances.insert(instance);
                arena.cloths.push(index);
            }
            None => arenas.push(Arena {
                kind,
                lists: lists + images + HEADS,
                vectors,
                instances: BTreeSet::from([instance]),
                cloths: vec![index],
            }),
        }
    }
    let roster = |indices: Vec<usize>| {
        let of = |large: bool| {
            let chosen = indices.iter().map(|c| &cloths[*c]).filter(move |c| !large || room.hold(c.len(), 0).is_none());
            chosen.flat_map(sides).collect::<Vec<_>>()
        };
        let large = of(true);
        let sides = if large.is_empty() { of(false) } else { large };
        Roster::new(indices, sides)
    };
    arenas.into_iter().map(|a| roster(a.cloths)).collect()
}

/// Cloths that lie in the same buffers.
struct Arena<K> {
    /// The properties that they share.
    kind: K,
    /// Bytes of their lists that are only read, and of the largest other buffer.
    lists: u64,
    vectors: u64,
    /// Whose images are there.
    instances: BTreeSet<usize>,
    cloths: Vec<usize>,
}

/// Bytes of the shared lists of an arena beside their contents: where they begin, and what each is rounded up by.
pub const HEADS: u64 = 4 * HEAD as u64 + 16 * LISTED.len() as u64;

/// Entries that a cloth takes up in the buffers of an arena: each begins where a binding may begin.
pub const fn room_of(particles: usize) -> usize {
    particles.next_multiple_of(64)
}
