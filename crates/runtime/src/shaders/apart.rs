//! The shader of a pass alone.

use super::lists;
use super::parts::Bound;
use super::rule::{Over, Rule, rule};
use super::{Slot, Source, Threads};
use crate::passes::Pass;

/// The rule, a loop over all of a cloth, and the buffers of one cloth.
pub(super) fn apart(pass: Pass) -> Source {
    let Rule { stem, text, call, over, parts, .. } = rule(pass);
    let own = matches!(over, Over::Own(_));
    let mut files = Vec::new();
    for bound in &parts.bindings {
        files.extend(common(bound));
        // A file with a loop of its own declares what it moves.
        files.extend(if own { &[] } else { declared(bound) });
    }
    if over == Over::Near {
        files.push(part!("notes"));
    }
    let (turn, threads): (Option<&str>, _) = match over {
        Over::Particles => (Some(turn!("apart_particles")), Threads::Particles),
        Over::Near => (Some(turn!("apart_near")), Threads::Particles),
        Over::Rings => (Some(turn!("apart_rings")), Threads::Rings),
        Over::Texels | Over::Placed => (Some(turn!("apart_texels")), Threads::Texels),
        Over::Springs { direction, .. } => (Some(turn!("apart_springs")), Threads::Half(direction == 0)),
        Over::Cells { .. } => (Some(turn!("apart_cells")), Threads::Quarter),
        Over::Groups(Threads::Layers) => (Some(turn!("apart_cloth")), Threads::Layers),
        Over::Groups(threads) => (Some(turn!("apart_groups")), threads),
        Over::Own(threads) => (None, threads),
    };
    if matches!(threads, Threads::Particles | Threads::Rings | Threads::Vertices | Threads::Patches) {
        files.push(part!("index"));
    }
    files.extend((!own).then_some(part!("one_cloth")));
    let parts = match over {
        Over::Springs { direction, parity } => parts.constant("direction", direction).constant("parity", parity),
        Over::Cells { column, row } => parts.constant("column", column).constant("line", row),
        _ => parts,
    };
    let parts = parts.files(&files).files(&[text]);
    let loops = turn.map(|turn| (turn, call)).into_iter().collect();
    let (files, bindings, constants) = (parts.files, parts.bindings, parts.constants);
    let program = format!("\n{}", lists::own(&bindings));
    Source { stem, files, loops, program, bindings, constants, threads, scratch: 0 }
}

/// Declarations that are the same for all passes of one dispatch each.
fn common(bound: &Bound) -> &'static [&'static str] {
    match bound.slot {
        Slot::Step => &[part!("step"), part!("step_bound")],
        Slot::Grids => &[part!("grid"), part!("grids")],
        _ => &[],
    }
}

/// Declarations of what rules name but do not declare, as it lies in buffers of a cloth.
pub(super) fn declared(bound: &Bound) -> &'static [&'static str] {
    match (bound.slot, bound.writes) {
        (Slot::Now, true) => &[part!("now"), part!("stored")],
        (Slot::Now, false) => &[part!("now_read")],
        (Slot::Before, true) => &[part!("befores"), part!("was_stored")],
        (Slot::Before, false) => &[part!("before")],
        (Slot::Lost, _) => &[part!("lost")],
        (Slot::Normals, false) => &[part!("normals_read")],
        (Slot::Sums, _) => &[part!("sums")],
        (Slot::Solids, _) => &[part!("solids_all")],
        (Slot::Nodes, false) => &[part!("nodes_read")],
        (Slot::Tethers, _) => &[part!("anchor_placed"), part!("tether_stored")],
        (slot, _) => declared_alike(slot),
    }
}

/// Declarations that are the same in all forms.
pub(super) fn declared_alike(slot: Slot) -> &'static [&'static str] {
    match slot {
        Slot::Normals => &[part!("normals")],
        Slot::Faults => &[part!("faults")],
        Slot::Nodes => &[part!("nodes")],
        Slot::Tethers => &[part!("tether_stored")],
        _ => &[],
    }
}
