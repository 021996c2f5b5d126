//! The plan of a frame: its passes, dispatches and bindings.

use std::fmt;

use crate::cloth::Cloth;
use crate::form::{Form, Fused, Tile};
use crate::levels;
use crate::levels::joint::{COUNTS, Joint};
use crate::levels::safe::ROUNDS;
use crate::passes::{FOLLOW_STEPS, MEETING_STEPS, Pass, SEARCH_STEPS, Schedule, has_levels};
use crate::shaders::{Slot, list, source};
use crate::world::{Share, World, is_safe};

/// One pass of one cloth, or of all cloths with contact together.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPass {
    /// Index of the cloth; that of the first one for a pass of all cloths with contact.
    pub cloth: usize,
    /// The form in which the pass runs.
    pub form: Form,
    /// The shader file's stem.
    pub shader: &'static str,
    /// Workgroups in x, y, z.
    pub workgroups: [u32; 3],
    /// Dispatches per frame; 0 if it shares the dispatch of an earlier cloth.
    pub dispatches: u32,
    /// The bindings and their bytes.
    pub bindings: Vec<(&'static str, u64)>,
}

/// The passes of a frame of [`crate::Options::step`], in the order of their first run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The passes.
    pub passes: Vec<PlannedPass>,
}

impl Plan {
    pub(crate) fn new(world: &World) -> Self {
        let options = &world.control.options;
        let steps = options.substeps;
        let mut passes = Vec::new();
        for batch in world.batches() {
            let forms = match &batch.share {
                Share::Whole { fused, .. } => vec![(Form::Whole(fused.clone()), batch.parts(steps))],
                Share::Steps { sequence, hold, .. } => {
                    sequence.forms([steps, options.iterations, *hold, options.pyramid])
                }
            };
            let cloths = batch.members.iter().map(|m| world.arenas[batch.arena].cloths[*m]);
            for (k, cloth) in cloths.enumerate() {
                let own = |count: u32| if k == 0 { count } else { 0 };
                passes.extend(forms.iter().map(|(form, count)| planned(world, cloth, form.clone(), own(*count))));
            }
        }
        for cloth in (0..world.runs.len()).filter(|c| world.is_apart(*c)) {
            let forms = apart(world, cloth).into_iter();
            passes.extend(forms.map(|(form, dispatches)| planned(world, cloth, form, dispatches)));
        }
        passes.extend(together(world));
        // Each cloth has its own.
        let worn = (0..world.runs.len()).flat_map(|c| world.runs[c].schedule.worn.iter().map(move |pass| (c, *pass)));
        let awake = worn.filter(|(c, _)| !world.runs[*c].asleep);
        let worn: Vec<_> = awake.map(|(c, pass)| planned(world, c, pass.into(), u32::from(steps > 0))).collect();
        passes.splice(0..0, worn);
        Plan { passes }
    }

    /// The forms of the passes of a cloth in a frame.
    #[cfg(feature = "gpu")]
    pub(crate) fn forms(world: &World, cloth: usize) -> Vec<Form> {
        let options = &world.control.options;
        let run = &world.runs[cloth];
        let counted = match (&run.fused, &run.sequence) {
            (Some(fused), _) => vec![(Form::Whole(fused.clone()), 1)],
            (None, Some(sequence)) => sequence.forms([options.substeps, options.iterations, 1, options.pyramid]),
            (None, None) => apart(world, cloth),
        };
        let together = if run.fused.is_some() { Vec::new() } else { together(world) };
        let worn = run.schedule.worn.iter().map(|pass| Form::Apart(*pass));
        let own = counted.into_iter().map(|(form, _)| form);
        worn.chain(own).chain(together.into_iter().map(|pass| pass.form)).collect()
    }

    /// Dispatches per frame.
    pub fn dispatches(&self) -> u32 {
        self.passes.iter().map(|p| p.dispatches).sum()
    }

    /// Bytes of everything that is bound in a frame, each buffer counted once a cloth.
    pub fn bytes(&self) -> u64 {
        let mut seen = std::collections::BTreeMap::new();
        for pass in &self.passes {
            seen.extend(pass.bindings.iter().map(|(name, bytes)| ((pass.cloth, *name), *bytes)));
        }
        seen.values().sum()
    }
}

/// The forms of the passes in the frame of a cloth that shares no dispatch, and their dispatches.
fn apart(world: &World, cloth: usize) -> Vec<(Form, u32)> {
    let (steps, rounds) = (world.control.options.substeps, world.control.options.iterations);
    let Schedule { near, gusts, air, step, coarse, relax, frame, .. } = &world.runs[cloth].schedule;
    let rare = steps.div_ceil(world.control.options.pyramid.max(1));
    let alone = |list: &[Pass]| list.iter().map(|pass| Form::Apart(*pass)).collect::<Vec<_>>();
    let search = (alone(near), steps.div_ceil(SEARCH_STEPS));
    let gusts = (alone(gusts), u32::from(steps > 0));
    let blows = (alone(air), steps.div_ceil(world.hold(cloth)));
    let lists = match world.order(cloth) {
        Some(order) => {
            let rare = if coarse.is_empty() { 0 } else { rare };
            let relax = (order.relax.clone(), steps * (rounds - 1) + rare);
            let first = (order.first.clone(), steps - rare);
            let rare = [(alone(step), rare), (alone(coarse), rare)];
            let lists = [search, gusts, blows].into_iter().chain(rare).chain([first, relax, (alone(frame), 1)]);
            lists.into_iter().filter(|l| l.1 > 0).collect::<Vec<_>>()
        }
        None => {
            vec![
                search,
                gusts,
                blows,
                (alone(step), steps),
                (alone(coarse), rare),
                (alone(relax), steps * rounds),
                (alone(frame), 1),
            ]
        }
    };
    let all = lists.into_iter().flat_map(|(list, count)| list.into_iter().map(move |form| (form, count)));
    let all: Vec<_> = match is_meeting(world, cloth) {
        true => among_others(all, steps).collect(),
        false => all.collect(),
    };
    let of = &world.scene.cloths[cloth];
    match world.has_safe() && is_safe(of) {
        true => held_back(of, all, steps),
        false => all,
    }
}

/// The forms of a cloth whose contact is safe.
fn held_back(cloth: &Cloth, forms: Vec<(Form, u32)>, steps: u32) -> Vec<(Form, u32)> {
    let begins = Pass::Gather { begins: true, put: false, sleeps: false };
    let ends = [Pass::Gather { begins: false, put: false, sleeps: false }, Pass::HoldBack { exact: cloth.is_exact() }];
    let begin = std::iter::once((begins.into(), 1)).chain(forms);
    begin.chain(ends.map(|pass| (pass.into(), steps))).collect()
}

/// Whether a cloth meets others.
fn is_meeting(world: &World, cloth: usize) -> bool {
    let meeting = world.meeting();
    meeting.len() > 1 && meeting.contains(&cloth)
}

/// The forms of a cloth that meets others: it shows itself every few steps, and its contact depends on the steps since then.
fn among_others(forms: impl Iterator<Item = (Form, u32)>, steps: u32) -> impl Iterator<Item = (Form, u32)> {
    let shows = steps.div_ceil(FOLLOW_STEPS);
    let each = forms.flat_map(move |(form, count)| match form {
        Form::Apart(Pass::Touch { .. }) => {
            let in_step = count.checked_div(steps).unwrap_or(0);
            let since = |n: u32| (n + 1, in_step * (steps + FOLLOW_STEPS - 1 - n).div_euclid(FOLLOW_STEPS));
            let some = (0..FOLLOW_STEPS).map(since).filter(|(_, count)| *count > 0);
            some.map(|(others, count)| (Pass::Touch { others }.into(), count)).collect()
        }
        other => vec![(other, count)],
    });
    std::iter::once((Pass::Shadow.into(), shows)).chain(each)
}

/// The passes of all cloths with contact together.
fn together(world: &World) -> Vec<PlannedPass> {
    let meeting = world.meeting();
    // The last one that falls asleep ends them.
    let awake = |cloth: &usize| !world.runs[*cloth].asleep;
    let safe = |cloth: &usize| awake(cloth) && is_safe(&world.scene.cloths[*cloth]);
    let (meets, holds) = (meeting.len() > 1 && meeting.iter().any(awake), meeting.iter().any(safe));
    if !meets && !holds {
        return Vec::new();
    }
    let cloths: Vec<_> = meeting.iter().map(|cloth| &world.scene.cloths[*cloth]).collect();
    let joint = Joint::of(&cloths, &vec![0.0; cloths.len()]);
    let boxes = if world.has_safe() { joint.boxes_of_cells() } else { joint.boxes };
    let steps = world.control.options.substeps;
    let one = |(what, workgroups, dispatches): (Pass, [u32; 3], u32)| {
        let source = source(&what.into());
        let bytes = |slot: Slot| match slot {
            Slot::Grids => 32 * joint.grids.len() as u64,
            Slot::Kin => 4 * joint.table.len() as u64,
            Slot::Boxes => 32 * boxes as u64,
            Slot::Counts => 4 * COUNTS as u64,
            Slot::Part => 16,
            other => cloths.iter().map(|cloth| other.bytes(cloth, 0, 0)).sum(),
        };
        let slots = source.bindings.iter().map(|b| b.slot);
        // Lists of the same name of the cloth itself are others.
        let name = |slot: Slot| match slot {
            Slot::Grids => "joint_grids",
            Slot::Kin => "joint_kin",
            Slot::Homes => "joint_homes",
            Slot::Boxes => "joint_boxes",
            Slot::Shadows => "joint_shadows",
            Slot::Others => "joint_others",
            Slot::Goals => "joint_goals",
            Slot::Places => "joint_places",
            Slot::Faces => "joint_faces",
            other => other.name(),
        };
        PlannedPass {
            cloth: meeting[0],
            form: what.into(),
            shader: source.stem,
            workgroups,
            dispatches,
            bindings: slots.map(|slot| (name(slot), bytes(slot))).collect(),
        }
    };
    let (tiles, texels) = (list(joint.tiles), list(16 * joint.tiles));
    let mut all = Vec::new();
    if meets {
        let searches = steps.div_ceil(MEETING_STEPS);
        all.extend([
            (Pass::Extents, tiles, searches),
            (Pass::Tree, [1; 3], searches),
            (Pass::Others, texels, searches),
        ]);
    }
    if holds {
        let rounds = steps * ROUNDS;
        all.extend([(Pass::Paths, texels, rounds), (Pass::Tree, [1; 3], rounds), (Pass::Truncate, texels, rounds)]);
    }
    all.into_iter().map(one).collect()
}

fn planned(world: &World, cloth: usize, form: Form, dispatches: u32) -> PlannedPass {
    let source = source(&form);
    let of = &world.scene.cloths[cloth];
    let slots = source.bindings.iter().map(|b| b.slot);
    let one = |slot: Slot| slot.bytes(of, world.runs[cloth].tethers.per_particle, world.solid_count(cloth));
    let coarse = has_levels(of, &world.control.options).then(|| levels::listed(of).iter().sum::<usize>() as u64);
    let bytes = |slot: Slot| match slot {
        Slot::Scratch => one(slot) * source.scratch as u64,
        Slot::Lists => one(slot) + coarse.unwrap_or(0),
        _ => one(slot),
    };
    PlannedPass {
        cloth,
        form,
        shader: source.stem,
        workgroups: source.workgroups(of),
        dispatches,
        bindings: slots.map(|slot| (slot.name(), bytes(slot))).collect(),
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for p in &self.passes {
            let [x, y, z] = p.workgroups;
            let bound: Vec<_> = p.bindings.iter().map(|(name, bytes)| format!("{name} {bytes}")).collect();
            let variant = match &p.form {
                Form::Apart(Pass::Springs { direction, parity, .. }) => {
                    format!(" {} {}", ["right", "down", "down-right", "up-right"][*direction as usize & 3], parity)
                }
                Form::Whole(Fused { threads, .. }) => format!(" in workgroup memory, {threads} threads"),
                Form::Tile(Tile { shape, threads, .. }) => {
                    let [[x, y], [wide, high]] = [shape.inner, shape.room];
                    format!(" of {x} x {y} in {wide} x {high}, {threads} threads")
                }
                _ => String::new(),
            };
            let groups = format!("{x} x {y} x {z}");
            let name = format!("{}{variant}", p.shader);
            writeln!(f, "cloth {} {name:<22} {:>5} x ({groups}): {}", p.cloth, p.dispatches, bound.join(", "))?;
        }
        writeln!(f, "{} dispatches, {} bytes bound", self.dispatches(), self.bytes())
    }
}
