//! Which cloths lie in the same buffers.

use super::Room;
use crate::cloth::{Cloth, Rest};
use crate::form::Hold;
use crate::options::{Options, Solver};
use crate::passes::soft_of;

/// From this number of cloths on, those that are too large for the memory of a workgroup run a workgroup each; fewer would leave most of a
/// device idle.
const MANY: usize = 16;

/// Cloths that lie in the same buffers, by index; in order.
pub fn arenas(cloths: &[Cloth], slots: impl Fn(usize) -> usize, options: &Options, room: &Room) -> Vec<Vec<usize>> {
    let mut arenas: Vec<(_, u64, Vec<usize>)> = Vec::new();
    let small = |c: &Cloth| room.hold(c.len(), 0) != Hold::Stored;
    let large = cloths.iter().filter(|c| !small(c)).count();
    for (index, cloth) in cloths.iter().enumerate() {
        if options.solver != Solver::Xpbd || !options.fused || (!small(cloth) && large < MANY) {
            continue;
        }
        let (image, rings) = (matches!(cloth.rest(), Rest::Image(_)), cloth.ring_count() > 0);
        let soft = soft_of(cloth);
        let fabric = (cloth.is_exact(), cloth.bending().is_some(), cloth.membrane().is_some());
        let kind = (image, rings, soft, slots(index), fabric);
        // No other buffer has more bytes per particle.
        let wide = if cloth.membrane().is_some() { 4 } else { 2 };
        let bytes = room_of(cloth.len()) as u64 * 8 * (slots(index) as u64).max(wide);
        let fits = |a: &&mut (_, u64, Vec<usize>)| a.0 == kind && a.1 + bytes <= room.bytes;
        match arenas.iter_mut().find(fits) {
            Some(arena) => {
                arena.1 += bytes;
                arena.2.push(index);
            }
            None => arenas.push((kind, bytes, vec![index])),
        }
    }
    arenas.into_iter().map(|a| a.2).collect()
}

/// Entries that a cloth takes up in the buffers of an arena: each begins where a binding may begin.
pub const fn room_of(particles: usize) -> usize {
    particles.next_multiple_of(64)
}
