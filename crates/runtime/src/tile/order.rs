//! A step whose passes run together where they can.

use crate::cloth::Cloth;
use crate::form::{Chain, Form, Tile};
use crate::fused::Room;
use crate::loops;
use crate::passes::{Pass, Schedule};
use crate::shaders::{self, Slot, Source};

/// The passes of a step of one cloth, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// All before the first relaxation, and that: for steps without passes on coarser grids.
    pub first: Vec<Form>,
    /// One more relaxation, or the first after passes on coarser grids.
    pub relax: Vec<Form>,
}

/// The dispatches of a frame of cloths that share them, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// In the first step of a frame, before all others.
    pub gusts: Vec<Form>,
    /// In steps with forces of air, before all that follow.
    pub air: Vec<Form>,
    /// Once a step, up to the first relaxation and with it. The last seams of a relaxation, and the passes after them, may be part of the next
    /// dispatch: that of the next step, of the next relaxation, or after the last step.
    pub first: Vec<Form>,
    /// The same in steps with passes on coarser grids.
    pub coarse: Vec<Form>,
    /// For each relaxation after it.
    pub relax: Vec<Form>,
    /// After the last step.
    pub last: Vec<Form>,
}

/// Passes of a step that may have dispatches of their own, beside its tiles, where a workgroup could run the whole frame. Each takes a GPU 2 to 5
/// microseconds, and a step in one workgroup takes 20 to 50.
const MAX_APART: usize = 8;

impl Sequence {
    /// Whether tiles do most of a step, or it has few passes.
    pub fn is_short(&self) -> bool {
        let tiles = self.first.iter().filter(|form| matches!(form, Form::Tile(_))).count();
        self.first.len() - tiles <= MAX_APART
    }

    /// The dispatches of a frame of `steps` steps of `rounds` relaxations, and how often each is made, if forces of air act in every
    /// `hold`-th step and passes on coarser grids run in every `pyramid`-th.
    pub fn forms(&self, [steps, rounds, hold, pyramid]: [u32; 4]) -> Vec<(Form, u32)> {
        let blows = steps.div_ceil(hold.max(1));
        let rare = if self.coarse.is_empty() { 0 } else { steps.div_ceil(pyramid.max(1)) };
        let begin = [(&self.gusts, u32::from(steps > 0)), (&self.air, blows), (&self.coarse, rare)];
        let lists = [(&self.first, steps - rare), (&self.relax, steps * (rounds - 1)), (&self.last, 1)];
        let made = begin.into_iter().chain(lists).filter(|(_, count)| *count > 0);
        made.flat_map(|(list, count)| list.iter().map(move |form| (form.clone(), count))).collect()
    }
}

/// Properties of cloths on which the sizes of their dispatches depend, beside passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Among<'a> {
    /// Columns and rows of grids.
    pub sides: &'a [[u32; 2]],
    /// [`loops::of_solids`] of the colliders that a cloth meets.
    pub solids: u64,
    /// [`loops::of_ring`] of its seams.
    pub ring: u64,
    /// Whether several cloths share the dispatches.
    pub shared: bool,
    /// Relaxations of a step.
    pub rounds: u32,
}

/// The order of the schedule of a cloth, and [`loops::of_solids`] of its colliders, if any of its passes can run together.
pub fn order((cloth, solids): (&Cloth, u64), schedule: &Schedule, room: &Room) -> Option<Order> {
    let sides: Vec<_> = cloth.grids().iter().map(|g| [g.width, g.height]).collect();
    let among = Among { sides: &sides, solids, ring: loops::of_ring(cloth), shared: false, rounds: 1 };
    let whole = [&schedule.step[..], &schedule.relax].concat();
    let order = Order { first: together(&whole, &among, room), relax: together(&schedule.relax, &among, room) };
    order.first.iter().chain(&order.relax).any(|f| matches!(f, Form::Tile(_))).then_some(order)
}

/// The dispatches of a schedule, by cloths that share them.
pub fn sequence(among: &Among, schedule: &Schedule, room: &Room) -> Sequence {
    let alone = |pass: &Pass| Form::Together(*pass);
    let [gusts, air] = [&schedule.gusts, &schedule.air].map(|list| list.iter().map(alone).collect());
    let whole = [&schedule.step[..], &schedule.relax].concat();
    // Speeds are measured for each cloth at once.
    let last: Vec<_> = schedule.frame.iter().copied().filter(|p| *p != Pass::Fastest).collect();
    // Particles of any tile follow nodes, and nodes particles, so tiles end before these passes and behind them.
    let below = |step: Vec<Form>, relax: &[Pass]| match schedule.coarse[..] {
        [] => Vec::new(),
        _ => step.into_iter().chain(schedule.coarse.iter().map(alone)).chain(together(relax, among, room)).collect(),
    };
    let put_off = |tail: &[Pass]| {
        let end = |passes: &[Pass]| {
            let forms = together(&[tail, passes].concat(), among, room);
            forms.first().is_some_and(|form| length(form) >= tail.len()).then_some(forms)
        };
        let head = |passes: &[Pass]| end(&passes[..passes.len() - tail.len()]);
        let mut ends = end(last.get(..1)?)?;
        ends.extend(last[1..].iter().map(alone));
        let coarse = below(end(&schedule.step)?, &schedule.relax[..schedule.relax.len() - tail.len()]);
        Some([head(&whole)?, coarse, head(&schedule.relax)?, ends])
    };
    let rings = schedule.relax.iter().rposition(|p| *p == Pass::Seams);
    // Forces of air on triangles begin a step, and read neighbours.
    let put_off = rings.filter(|_| schedule.air.is_empty()).and_then(|n| put_off(&schedule.relax[n..]));
    let [first, coarse, relax, last] = put_off.unwrap_or_else(|| {
        let of = |passes: &[Pass]| together(passes, among, room);
        let coarse = below(of(&schedule.step), &schedule.relax);
        [of(&whole), coarse, of(&schedule.relax), last.iter().map(alone).collect()]
    });
    // Wind and coarser grids read previous positions between dispatches.
    let alone = among.shared && among.rounds == 1 && schedule.air.is_empty() && schedule.coarse.is_empty();
    let first = if alone { by_steps(first) } else { first };
    Sequence { gusts, air, first, coarse, relax, last }
}

/// The dispatches of a step. If they are one tile, no other pass comes between the steps of a frame.
fn by_steps(step: Vec<Form>) -> Vec<Form> {
    match &step[..] {
        [Form::Tile(tile)] => vec![Form::Tile(tile.clone().of_steps())],
        _ => step,
    }
}

/// How many passes a dispatch makes.
fn length(form: &Form) -> usize {
    match form {
        Form::Tile(tile) => tile.passes.len(),
        Form::Chain(chain) => chain.passes.len(),
        Form::Apart(_) | Form::Together(_) | Form::Whole(_) => 1,
    }
}

/// As many passes at a time as one dispatch can make, from the first on.
fn together(passes: &[Pass], among: &Among, room: &Room) -> Vec<Form> {
    let mut list = Vec::new();
    let mut left = passes;
    while let Some(first) = left.first() {
        let joined = |n: usize| {
            let chain = || Some(Form::Chain(chain(&left[..n], among, room)?));
            let tile = || Some(Form::Tile(tile(&left[..n], among, room)?));
            Some((chain().or_else(tile)?, n))
        };
        let alone = || if among.shared { Form::Together(*first) } else { Form::Apart(*first) };
        let (form, n) = (2..=left.len()).rev().find_map(joined).unwrap_or_else(|| (alone(), 1));
        list.push(form);
        left = &left[n..];
    }
    list
}

/// A tile that makes just these passes, if there is one that a device has room for.
fn tile(passes: &[Pass], among: &Among, room: &Room) -> Option<Tile> {
    let tile = Tile::of(passes, among.shared)?.fit(among.sides, room)?;
    let ends = loops::of_tile(&tile, [among.solids, among.ring]) <= u64::from(room.loops);
    (ends && fits(&shaders::tile(&tile), room)).then_some(tile)
}

/// The same in place, of passes that have no springs and begin with seams.
fn chain(passes: &[Pass], among: &Among, room: &Room) -> Option<Chain> {
    let chain = Chain::of(passes).filter(|_| among.shared)?;
    let ends = loops::of_chain(&chain, [among.solids, among.ring]) <= u64::from(room.loops);
    (ends && fits(&shaders::chain(&chain), room)).then_some(chain)
}

/// Whether a device can bind what a shader does.
fn fits(source: &Source, room: &Room) -> bool {
    let uniform = |slot| matches!(slot, Slot::Step | Slot::Frame | Slot::Batch | Slot::Part);
    source.bindings.iter().filter(|b| !uniform(b.slot)).count() <= room.buffers as usize
}
