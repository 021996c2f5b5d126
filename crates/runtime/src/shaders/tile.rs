//! The parts of the shader that makes several passes of a step by tiles.

use super::{
    BOUND, BY_ROWS, CONTACT, GRID, SOLIDS, STEP, Slot, Source, Threads, air, reads, rule, shapes, spring_parts, writes,
};
use crate::passes::Soft;
use crate::tile::Tile;

/// Only what these passes need is compiled in and bound.
pub(super) fn source(tile: Tile) -> Source {
    let Tile { shape, threads, .. } = tile;
    let mut files = vec![GRID, BY_ROWS];
    let mut bindings = vec![reads(Slot::Grids), reads(Slot::Now), writes(Slot::Next)];
    let mut constants = vec![("threads", f64::from(threads)), ("places", f64::from(shape.room[0] * shape.room[1]))];
    let numbers = [("stride", shape.room[0]), ("inner_x", shape.inner[0]), ("inner_y", shape.inner[1])];
    let more = [("around_x", shape.around[0]), ("around_y", shape.around[1])];
    let lacks = [("lacks_x", shape.lacks[0]), ("lacks_y", shape.lacks[1])];
    constants.extend(numbers.into_iter().chain(more).chain(lacks).map(|(name, n)| (name, f64::from(n))));
    constants.extend(["first", "last"].into_iter().zip(tile.tethers).map(|(name, on)| (name, f64::from(u8::from(on)))));
    if tile.air.is_some() || tile.contact.is_some() || tile.soft != Soft::None {
        files.extend([STEP, BOUND]);
        bindings.push(reads(Slot::Step));
    }
    if let Some(of) = tile.air {
        files.extend(air(of));
        if tile.exact {
            files.extend([part!("tile_lost"), part!("verlet_exact")]);
            bindings.extend([reads(Slot::Lost), writes(Slot::Losing)]);
        } else {
            files.extend([part!("tile_lost_none"), part!("verlet")]);
        }
        files.push(part!("tile_moves"));
        bindings.extend([reads(Slot::Before), writes(Slot::Passed)]);
        bindings.extend((of == crate::passes::Air::Field).then_some(reads(Slot::Field)));
    } else {
        files.push(part!("tile_moves_none"));
    }
    if tile.slots > 0 {
        files.extend([part!("tether"), part!("tile_tethers")]);
        bindings.push(reads(Slot::Tethers));
        constants.push(("slots", f64::from(tile.slots)));
    } else {
        files.push(part!("tile_tethers_none"));
    }
    if tile.colours > 0 {
        let sums = || {
            let bound = vec![reads(Slot::Sums), writes(Slot::Summing)];
            (vec![part!("tile_sums"), part!("again")], bound)
        };
        let (springs, read) = spring_parts(tile.image, tile.soft, if tile.again { sums() } else { rule(false) });
        files.extend(springs);
        files.push(part!("tile_springs"));
        constants.extend(tile.again.then(|| ("forget", f64::from(u8::from(tile.forget)))));
        bindings.extend(read);
        constants.extend([("colours", f64::from(tile.colours)), ("polish", f64::from(tile.polish))]);
    } else {
        files.push(part!("tile_springs_none"));
    }
    if !tile.again {
        files.push(part!("tile_sums_none"));
    }
    if let Some(kinds) = tile.contact {
        files.push(SOLIDS);
        files.extend(CONTACT);
        if kinds.many {
            files.extend([part!("notes"), part!("near"), part!("tile_near")]);
        } else {
            files.extend([part!("near_all"), part!("tile_near_all")]);
        }
        files.push(part!("tile_contact"));
        bindings.push(reads(Slot::Solids));
        constants.extend(shapes(kinds));
        if tile.air.is_none() {
            files.push(part!("before"));
            bindings.push(reads(Slot::Before));
        }
    } else {
        files.push(part!("tile_contact_none"));
    }
    files.push(pass!("tile"));
    Source { stem: "tile", files, bindings, constants, threads: Threads::Tiles(shape) }
}
