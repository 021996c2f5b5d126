//! A step whose passes run together where they can.

use crate::cloth::Cloth;
use crate::form::{Form, Tile};
use crate::fused::Room;
use crate::loops;
use crate::passes::{Pass, Schedule};
use crate::shaders::{self, Slot};

/// The passes of a step of one cloth, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// All before the first relaxation, and that: for steps without passes on coarser grids.
    pub first: Vec<Form>,
    /// One more relaxation, or the first after passes on coarser grids.
    pub relax: Vec<Form>,
}

/// The order of the schedule of a cloth, and [`loops::of_solids`] of its colliders, if any of its passes can run together.
pub fn order(among: (&Cloth, u64), schedule: &Schedule, room: &Room) -> Option<Order> {
    let whole = [&schedule.step[..], &schedule.relax].concat();
    let together = |passes: &[Pass]| together(passes, among, room);
    let order = Order { first: together(&whole), relax: together(&schedule.relax) };
    order.first.iter().chain(&order.relax).any(|f| matches!(f, Form::Tile(_))).then_some(order)
}

/// As many passes at a time as one dispatch can make, from the first on.
fn together(passes: &[Pass], among: (&Cloth, u64), room: &Room) -> Vec<Form> {
    let mut list = Vec::new();
    let mut left = passes;
    while let Some(first) = left.first() {
        let tile = |n: usize| {
            let tile = Tile::of(&left[..n])?.fit(among.0.grids(), room)?;
            let bindings = shaders::tile(&tile).bindings;
            let bound = bindings.iter().filter(|b| b.slot != Slot::Step).count();
            let ends = loops::of_tile(&tile, among) <= u64::from(room.loops);
            (ends && bound <= room.buffers as usize).then_some((Form::Tile(tile), n))
        };
        let (form, n) = (2..=left.len()).rev().find_map(tile).unwrap_or((Form::Apart(*first), 1));
        list.push(form);
        left = &left[n..];
    }
    list
}
