//! The plan of a frame: its passes, dispatches and bindings.

use std::fmt;

use crate::form::{Form, Fused, Tile};
use crate::passes::{Pass, SEARCH_STEPS, Schedule};
use crate::shaders::{Slot, source};
use crate::world::{Share, World};

/// One pass of one cloth.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPass {
    /// Index of the cloth.
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
        let steps = world.control.options.substeps;
        let mut passes = Vec::new();
        for batch in world.batches() {
            let forms = match &batch.share {
                Share::Whole { fused, .. } => vec![(Form::Whole(fused.clone()), batch.parts(steps))],
                Share::Steps { sequence, hold, .. } => sequence.forms(steps, world.control.options.iterations, *hold),
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
        Plan { passes }
    }

    /// The forms of the passes of a cloth in a frame.
    #[cfg(feature = "gpu")]
    pub(crate) fn forms(world: &World, cloth: usize) -> Vec<Form> {
        let (steps, rounds) = (world.control.options.substeps, world.control.options.iterations);
        let run = &world.runs[cloth];
        let counted = match (&run.fused, &run.sequence) {
            (Some(fused), _) => return vec![Form::Whole(fused.clone())],
            (None, Some(sequence)) => sequence.forms(steps, rounds, 1),
            (None, None) => apart(world, cloth),
        };
        counted.into_iter().map(|(form, _)| form).collect()
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
    let Schedule { near, air, step, coarse, relax, frame } = &world.runs[cloth].schedule;
    let rare = steps.div_ceil(world.control.options.pyramid.max(1));
    let alone = |list: &[Pass]| list.iter().map(|pass| Form::Apart(*pass)).collect::<Vec<_>>();
    let search = (alone(near), steps.div_ceil(SEARCH_STEPS));
    let blows = (alone(air), steps.div_ceil(world.hold(cloth)));
    let lists = match world.order(cloth) {
        Some(order) => {
            let rare = if coarse.is_empty() { 0 } else { rare };
            let relax = (order.relax.clone(), steps * (rounds - 1) + rare);
            let first = (order.first.clone(), steps - rare);
            let lists = [search, blows, (alone(step), rare), (alone(coarse), rare), first, relax, (alone(frame), 1)];
            lists.into_iter().filter(|l| l.1 > 0).collect::<Vec<_>>()
        }
        None => {
            vec![
                search,
                blows,
                (alone(step), steps),
                (alone(coarse), rare),
                (alone(relax), steps * rounds),
                (alone(frame), 1),
            ]
        }
    };
    lists.into_iter().flat_map(|(list, count)| list.into_iter().map(move |form| (form, count))).collect()
}

fn planned(world: &World, cloth: usize, form: Form, dispatches: u32) -> PlannedPass {
    let source = source(&form);
    let of = &world.scene.cloths[cloth];
    let slots = source.bindings.iter().map(|b| b.slot);
    let one = |slot: Slot| slot.bytes(of, world.runs[cloth].tethers.per_particle, world.solid_count(cloth));
    let bytes = |slot: Slot| one(slot) * if slot == Slot::Scratch { source.scratch as u64 } else { 1 };
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
