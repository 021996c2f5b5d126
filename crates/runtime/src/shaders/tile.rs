//! The shader of several passes by tiles.

use super::apart::declared_alike;
use super::chain::{sewn, tail, tails};
use super::lists;
use super::parts::{Parts, reads, writes};
use super::program::calls;
use super::rule::{Over, Rule, over, rule};
use super::together::{clears, several};
use super::{Slot, Source, Threads};
use crate::form::{Tile, TileSpan};
use crate::passes::Pass;

/// Where in a tile's work its passes are.
pub struct Stages<'a> {
    /// The seams that it begins with, and what follows them in the same step.
    pub tail: &'a [Pass],
    /// While particles are taken in: the integration, and what acts on each particle alone.
    pub arrive: &'a [Pass],
    /// Up to the last springs.
    pub middle: &'a [Pass],
    /// On what the tile owns.
    pub leave: &'a [Pass],
}

/// The passes of a tile by where they are.
pub fn stages(passes: &[Pass]) -> Stages<'_> {
    let (tail, rest) = passes.split_at(tail(passes));
    let springs = |p: &Pass| matches!(over(*p), Over::Springs { .. });
    let early = |p: &Pass| springs(p) || matches!(p, Pass::Contact(_));
    let first = rest.iter().position(early).unwrap_or(rest.len());
    let last = rest.iter().rposition(springs).map_or(first, |n| n + 1);
    Stages { tail, arrive: &rest[..first], middle: &rest[first..last], leave: &rest[last..] }
}

/// The rules of all passes, called in their order: on particles as they are taken in, on all that the tile has, on what it
/// owns.
pub fn tile(tile: &Tile) -> Source {
    let Stages { tail, arrive, middle, leave } = stages(&tile.passes);
    let mut parts = Parts::new(&[part!("grid"), part!("by_rows")], &[Slot::Grids], &[Slot::Next]);
    for pass in tile.passes.iter().filter(|p| **p != Pass::Seams) {
        let Rule { text, over, parts: own, .. } = rule(*pass);
        parts = parts.and(own).files(&[text]);
        match over {
            Over::Near => parts = parts.files(&[part!("notes")]),
            Over::Springs { .. } => parts = parts.files(&[part!("tile_colours")]),
            _ => {}
        }
    }
    let parts = match tail {
        [] => parts.files(&[part!("tile_plain")]),
        _ => sewn(parts, tail, [part!("tile_sewn"), part!("tile_all_near"), part!("tile_all_far")]),
    };
    let mut loops: Vec<(&str, &str)> = Vec::new();
    for pass in middle.iter().chain(leave) {
        let Rule { call, over, .. } = rule(*pass);
        let turn = match over {
            Over::Springs { .. } => turn!("tile_springs"),
            Over::Near => turn!("tile_near"),
            _ => turn!("tile_particles"),
        };
        if !loops.contains(&(turn, call)) {
            loops.push((turn, call));
        }
    }
    let call = |pass: &Pass| rule(*pass).call;
    let program = format!(
        "\nfn arrive_program(k: u32) {{\n{}}}\n\nfn middle_program(local: u32) {{\n{}}}\n\nfn leave_program(local: u32) {{\n{}}}\n",
        calls(arrive, |pass, _| format!("  {}(k);\n", call(pass))),
        calls(middle, |pass, colour| format!("  {}_all(local{colour});\n  workgroupBarrier();\n", call(pass))),
        calls(leave, |pass, _| format!("  {}_own(local);\n", call(pass))),
    );
    let program = tails(tail) + &program;
    let parts = parts.files(&[if ahead(tile) { part!("tile_ahead") } else { part!("tile_step") }]);
    let shape = tile.shape;
    let parts = if tile.shared {
        several(parts, false)
    } else {
        parts.files(&[part!("grids"), part!("one_cloth"), part!("tile_alone")])
    };
    let parts = apart_from_others(tile, parts).files(&[pass!("tile")]).constant("threads", tile.threads);
    let numbers = [("places", shape.room[0] * shape.room[1]), ("stride", shape.room[0])];
    let inner = [("inner_x", shape.inner[0]), ("inner_y", shape.inner[1])];
    let around = [("around_x", shape.around[0]), ("around_y", shape.around[1])];
    let lacks = [("lacks_x", shape.lacks[0]), ("lacks_y", shape.lacks[1])];
    let numbers = numbers.into_iter().chain(inner).chain(around).chain(lacks);
    let parts = numbers.fold(parts, |parts, (name, n)| parts.constant(name, n));
    let (parts, declared) = if tile.shared {
        let (parts, declared, _) = lists::shared(clears(parts.files(&[part!("tile_member")]), true), false);
        (parts, declared)
    } else {
        let declared = lists::own(&parts.bindings);
        (parts, declared)
    };
    let (files, bindings, constants) = (parts.files, parts.bindings, parts.constants);
    let program = format!("\n{declared}{program}");
    Source { stem: "tile", files, loops, program, bindings, constants, threads: Threads::Tiles(shape), scratch: 0 }
}

/// Whether a tile begins the next step.
fn ahead(tile: &Tile) -> bool {
    tile.span == TileSpan::Ahead
}

/// A tile writes its changes elsewhere, as its neighbours read the particles around their own.
fn apart_from_others(tile: &Tile, mut parts: Parts) -> Parts {
    let moves = parts.bound(Slot::Before).is_some_and(|b| b.writes);
    let (exact, sums) = (parts.binds(Slot::Lost), parts.binds(Slot::Sums));
    let files: Vec<_> = parts.bindings.iter().flat_map(|b| declared(b.slot, tile.shared)).copied().collect();
    let changed = [Slot::Now, Slot::Before, Slot::Lost, Slot::Sums];
    parts.bindings.iter_mut().filter(|b| changed.contains(&b.slot)).for_each(|b| b.writes = false);
    let parts = parts.files(&files).bind(&[reads(Slot::Now)]);
    let parts = match (moves, parts.binds(Slot::Before)) {
        (true, _) => {
            let lost = if exact { part!("tile_lost") } else { part!("tile_lost_none") };
            let moves = if ahead(tile) { part!("tile_moves_ahead") } else { part!("tile_moves") };
            let packed = tile.span != TileSpan::Part;
            let earlier = if packed { part!("earlier_packed") } else { part!("earlier_stored") };
            parts.files(&[earlier, moves, lost]).bind(&[writes(Slot::Passed)])
        }
        (false, true) => parts.files(&[part!("tile_moves_none"), part!("before")]),
        (false, false) => parts.files(&[part!("tile_moves_none")]),
    };
    let parts = if exact { parts.bind(&[writes(Slot::Losing)]) } else { parts };
    if sums {
        let forgets = u32::from(tile.forgets());
        return parts.files(&[part!("tile_sums")]).bind(&[writes(Slot::Summing)]).constant("forgets", forgets);
    }
    parts.files(&[part!("tile_sums_none")])
}

/// Declarations of what rules name but do not declare.
fn declared(slot: Slot, shared: bool) -> &'static [&'static str] {
    match slot {
        Slot::Step => &[part!("step"), part!("step_bound")],
        Slot::Solids if shared => &[part!("solids_member")],
        Slot::Solids => &[part!("solids_all")],
        other => declared_alike(other),
    }
}
