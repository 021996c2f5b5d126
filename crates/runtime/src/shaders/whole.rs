//! The shader of whole frames.

use super::apart::declared_alike;
use super::lists::{self, SCRATCH};
use super::parts::Parts;
use super::program::calls;
use super::rule::{Over, Rule, Whole, rule};
use super::{Slot, Source, Threads};
use crate::form::{Fused, Hold};
use crate::passes::{Pass, Schedule};

/// Whether all passes of a schedule can be part of a whole frame.
pub fn is_whole(schedule: &Schedule) -> bool {
    all(schedule).all(|p| !matches!(rule(*p).whole, Whole::No))
}

pub(super) fn all(schedule: &Schedule) -> impl Iterator<Item = &Pass> {
    let Schedule { gusts, air, step, coarse, relax, frame, .. } = schedule;
    gusts.iter().chain(air).chain(step).chain(coarse).chain(relax).chain(frame)
}

/// The rules of all passes and a loop for each, called in their order.
pub fn whole(fused: &Fused) -> Source {
    let schedule = &*fused.schedule;
    let files = [
        part!("step"),
        part!("grid"),
        part!("now"),
        part!("befores"),
        part!("by_rows"),
        part!("faults"),
        part!("jobs"),
    ];
    let mut parts = Parts::new(
        &files,
        &[Slot::Frame, Slot::Batch, Slot::Part, Slot::Jobs, Slot::Grids],
        &[Slot::Now, Slot::Before, Slot::Faults],
    );
    if schedule.coarse.iter().any(|p| matches!(p, Pass::Pyramid { .. })) {
        // A workgroup has all levels.
        parts = parts.constant("finest", 1);
    }
    let mut loops: Vec<(&str, &str)> = Vec::new();
    for pass in all(schedule) {
        let Rule { text, call, over, whole, parts: own, .. } = rule(*pass);
        match whole {
            Whole::No | Whole::Done => {}
            Whole::Call(_, own) => {
                let spare = match fused.hold {
                    Hold::Both | Hold::Wide => part!("spare_held"),
                    Hold::Narrow => part!("spare_narrow"),
                };
                parts = parts.and(own).files(&[spare, part!("whole_most")]);
            }
            Whole::Loop => {
                parts = parts.and(own).files(&[text]);
                let turn = turn(over).map(|turn| (turn, call));
                loops.extend(turn.filter(|turn| !loops.contains(turn)));
                if over == Over::Near {
                    let notes = if fused.full { part!("notes_stored") } else { part!("notes") };
                    parts = parts.files(&[notes]);
                }
            }
        }
    }
    // A workgroup reads its step from the numbers of the frame.
    parts.bindings.retain(|b| b.slot != Slot::Step);
    let declared: Vec<_> = parts.bindings.iter().flat_map(|b| declared(b.slot)).copied().collect();
    let slots = slots(schedule);
    let own: &[_] = match (slots, in_registers(fused)) {
        (0, _) => &[part!("own_none")],
        (_, true) => &[part!("anchor_own")],
        (_, false) => &[part!("anchor_placed"), part!("tether_stored"), part!("own_none")],
    };
    let parts = held(fused, parts.files(&declared).files(own)).files(&[pass!("fused")]);
    let step = |pass: &Pass, colour: &str| line(pass, colour, true);
    let (parts, declared, scratch) = lists::shared(parts, true);
    let coarse = match calls(&schedule.coarse, step) {
        none if none.is_empty() => none,
        calls => format!("  if (n % frame.pyramid == 0u) {{\n{calls}  }}\n"),
    };
    let program = format!(
        "\nconst PER_THREAD: u32 = {}u;\n\nconst SLOTS: u32 = {slots}u;\n\n{declared}\nfn gust_program(job: Job, local: u32) {{\n{}}}\n\nfn air_program(job: Job, local: u32) {{\n{}}}\n\nfn step_program(job: Job, local: u32) {{\n{}}}\n\nfn coarse_program(n: u32, job: Job, local: u32) {{\n{coarse}}}\n\nfn round_program(job: Job, local: u32) {{\n{}}}\n\n\
         fn frame_program(job: Job, local: u32) {{\n{}}}\n",
        per_thread(fused),
        calls(&schedule.gusts, step),
        calls(&schedule.air, step),
        calls(&schedule.step, step),
        calls(&schedule.relax, step),
        calls(&schedule.frame, |pass, colour| line(pass, colour, false)),
    );
    let (files, bindings, constants) = (parts.files, parts.bindings, parts.constants);
    Source { stem: "fused", files, loops, program, bindings, constants, threads: Threads::Cloth, scratch }
}

/// The call of a pass, and the barriers around it: of what positions lie in, and of buffers.
fn line(pass: &Pass, colour: &str, steps: bool) -> String {
    let Rule { call, over, whole, parts, .. } = rule(*pass);
    match whole {
        Whole::No | Whole::Done => String::new(),
        Whole::Call(name, _) => format!("  {name}_all(job, local);\n"),
        Whole::Loop => {
            let moves = parts.bound(Slot::Now).is_some_and(|b| b.writes);
            let after = if moves { "  sync();\n" } else { "" };
            let shared = hands_over(over, &parts);
            // Previous positions that other threads write or read may lie in a buffer.
            let before = parts.bound(Slot::Before).filter(|_| !is_own(over));
            let barrier = |there| if there { "  storageBarrier();\n" } else { "" };
            let first = barrier(before.is_some() || shared);
            let last = barrier(!moves || !steps || shared || before.is_some_and(|b| b.writes));
            format!("{first}  {call}_all(job, local{colour});\n{after}{last}")
        }
    }
}

/// Whether a pass writes lists of a frame, which lie in a buffer, that other threads read or write in other passes. The sums of a spring
/// are its own thread's in all its passes.
fn hands_over(over: Over, parts: &Parts) -> bool {
    let written = |slot: &Slot| parts.bound(*slot).is_some_and(|b| b.writes);
    !matches!(over, Over::Springs { .. }) && SCRATCH.iter().any(written)
}

/// Whether the thread of a particle makes all calls for it.
fn is_own(over: Over) -> bool {
    matches!(over, Over::Particles | Over::Near | Over::Placed)
}

fn turn(over: Over) -> Option<&'static str> {
    match over {
        Over::Particles => Some(turn!("whole_particles")),
        Over::Near => Some(turn!("whole_near")),
        Over::Rings => Some(turn!("whole_rings")),
        Over::Texels => Some(turn!("whole_texels")),
        Over::Placed => Some(turn!("whole_placed")),
        Over::Groups(_) => Some(turn!("whole_groups")),
        Over::Springs { .. } => Some(turn!("whole_springs")),
        Over::Cells { .. } => Some(turn!("whole_cells")),
        Over::Own(_) => None,
    }
}

/// Most particles of a thread whose previous positions and tethers are in registers: compilers make the code of every pass as often.
const MOST_OWN: u32 = 4;

/// Particles of a thread, at most.
fn per_thread(fused: &Fused) -> u32 {
    fused.places.div_ceil(fused.threads.max(1))
}

/// Tethers of a particle.
fn slots(schedule: &Schedule) -> u32 {
    let slots = |pass: &Pass| if let Pass::Tethers { slots } = pass { Some(*slots) } else { None };
    all(schedule).find_map(slots).unwrap_or(0)
}

/// Whether a frame asks for the previous position of a particle only where it runs for that particle. Forces of air on triangles read those
/// of neighbours, seams behind coarser grids those of duplicates, and passes over texels give particles to threads in another order.
fn keeps_own(schedule: &Schedule) -> bool {
    let Schedule { air, step, coarse, .. } = schedule;
    air.is_empty() && !step.contains(&Pass::Follow) && !coarse.contains(&Pass::SeamSteps)
}

/// Whether registers have what is a particle's own.
fn in_registers(fused: &Fused) -> bool {
    per_thread(fused) <= MOST_OWN && keeps_own(&fused.schedule)
}

/// Where positions are during the frame.
fn held(fused: &Fused, parts: Parts) -> Parts {
    let parts = parts.constant("threads", fused.threads);
    let parts = match fused.hold {
        Hold::Both | Hold::Wide => parts.files(&[part!("held")]),
        Hold::Narrow => parts.files(&[part!("held_narrow")]).constant("numbers", 3 * fused.places),
    };
    let parts = parts.constant("places", fused.places);
    if in_registers(fused) {
        return parts.files(&[part!("was_own")]);
    }
    let parts = parts.files(&[part!("was_many")]);
    if fused.hold == Hold::Both {
        return parts.files(&[part!("was_held")]).constant("befores", 3 * fused.places);
    }
    parts.files(&[part!("was_stored")])
}

/// Declarations of what rules name but do not declare, as it lies in buffers that cloths share.
fn declared(slot: Slot) -> &'static [&'static str] {
    match slot {
        Slot::Lost => &[part!("lost")],
        Slot::Sums => &[part!("sums")],
        Slot::Solids => &[part!("solids_own")],
        // Beside what is in registers.
        Slot::Tethers => &[],
        other => declared_alike(other),
    }
}
