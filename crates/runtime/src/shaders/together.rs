//! The shader of a pass alone over several cloths, and what all shaders of several cloths share.

use super::lists;
use super::parts::{Bound, Parts, writes};
use super::rule::{Over, Rule, over, residuals, rule};
use super::slot::LISTED;
use super::whole::{all, is_whole};
use super::{Slot, Source, Threads, apart};
use crate::passes::{Pass, Schedule};

/// Storage buffers that WebGPU promises on every device.
const BUFFERS: usize = 8;

/// Whether cloths can share the dispatches of all passes of a schedule: a pass with a loop of its own has a second one for several cloths, and
/// none binds a list that only a cloth alone has.
pub fn is_shared(schedule: &Schedule) -> bool {
    let looped =
        |p: &Pass| !matches!(over(*p), Over::Own(_)) || matches!(p, Pass::Speed | Pass::Fastest | Pass::Strain { .. });
    is_whole(schedule) && all(schedule).all(looped)
}

/// The rule, and a loop over the elements of all cloths.
pub(super) fn together(pass: Pass) -> Source {
    let Rule { stem, text, call, over, parts, .. } = rule(pass);
    let (text, parts) = match pass {
        Pass::Speed => {
            let files = [part!("larger"), part!("most")];
            (part!("shared_speed"), Parts::new(&files, &[Slot::Now, Slot::Before], &[Slot::Faults]))
        }
        Pass::Strain { image, soft } => {
            (part!("shared_strain"), residuals(image, soft).files(&[part!("most")]).bind(&[writes(Slot::Faults)]))
        }
        _ => (text, parts),
    };
    let (turn, threads): (Option<&str>, _) = match over {
        Over::Particles => (Some(turn!("shared_particles")), Threads::Particles),
        Over::Near => (Some(turn!("shared_near")), Threads::Particles),
        Over::Rings => (Some(turn!("shared_rings")), Threads::Rings),
        Over::Texels | Over::Placed => (Some(turn!("shared_texels")), Threads::Texels),
        Over::Springs { direction, .. } => (Some(turn!("shared_springs")), Threads::Half(direction == 0)),
        Over::Cells { .. } => (Some(turn!("shared_cells")), Threads::Quarter),
        Over::Groups(Threads::Layers) => (Some(turn!("shared_cloth")), Threads::Layers),
        Over::Groups(threads) => (Some(turn!("shared_groups")), threads),
        Over::Own(threads) => (None, threads),
    };
    let parts = match over {
        Over::Springs { direction, parity } => parts.constant("direction", direction).constant("parity", parity),
        Over::Cells { column, row } => parts.constant("column", column).constant("line", row),
        Over::Near => parts.files(&[part!("notes")]),
        _ => parts,
    };
    let parts =
        if matches!(threads, Threads::Particles | Threads::Rings) { parts.files(&[part!("index")]) } else { parts };
    let parts = several(parts, matches!(pass, Pass::Wind { .. }));
    let files: Vec<_> = parts.bindings.iter().flat_map(declared).copied().collect();
    let parts = clears(parts.files(&files).files(&[text]), turn.is_some() && is_early(pass));
    let (parts, program, _) = lists::shared(parts, false);
    let loops = turn.map(|turn| (turn, call)).into_iter().collect();
    let (files, bindings, constants) = (parts.files, parts.bindings, parts.constants);
    Source { stem, files, loops, program: format!("\n{program}"), bindings, constants, threads, scratch: 0 }
}

/// Adds the numbers of a frame and the cloth that a workgroup works for. `blows`: only in steps with forces of air.
pub(super) fn several(parts: Parts, blows: bool) -> Parts {
    let files = [part!("step"), part!("grid"), part!("jobs"), part!("member")];
    let slots = [Slot::Frame, Slot::Batch, Slot::Part, Slot::Jobs, Slot::Grids];
    let mut parts = Parts::new(&files, &slots, &[]).and(parts).constant("blows", u32::from(blows));
    // A workgroup reads its step from the numbers of the frame.
    parts.bindings.retain(|b| b.slot != Slot::Step);
    parts
}

/// Has a shader of a step clear the counters of the frame, where it may bind them too.
pub(super) fn clears(parts: Parts, early: bool) -> Parts {
    let uniform = |slot| matches!(slot, Slot::Frame | Slot::Batch | Slot::Part);
    let listed = |slot| LISTED.iter().any(|(s, _)| *s == slot);
    let own = parts.bindings.iter().filter(|b| !uniform(b.slot) && !listed(b.slot)).count();
    // The lists are one buffer more.
    if early && own + 1 < BUFFERS {
        return parts.files(&[part!("faults"), part!("clears")]).bind(&[writes(Slot::Faults)]);
    }
    parts.files(&[part!("clears_none")])
}

/// Whether a pass is part of a step.
fn is_early(pass: Pass) -> bool {
    !matches!(pass, Pass::Guard | Pass::Restore | Pass::Normals { .. } | Pass::SeamNormals)
}

/// Declarations of what rules name but do not declare, as it lies in buffers that cloths share.
pub(super) fn declared(bound: &Bound) -> &'static [&'static str] {
    match bound.slot {
        Slot::Solids => &[part!("solids_member")],
        _ => apart::declared(bound),
    }
}
