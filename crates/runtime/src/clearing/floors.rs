//! How high above the surface of a body points are to be: outside, but for those beside pins that are inside.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::net::Net;
use super::obstacles::WOUND;
use crate::cloth::surface::Posed;
use crate::cloth::{Cloth, LEAST_CLEARANCE_M, MODELLED_INSIDE_M};
use crate::number::real::cast;

/// How much higher than a pin inside of a body a point that began inside is to be for each metre of cloth between both.
const RISE: f64 = 0.3;

/// The height \[m\] that each point of a net keeps from the surface of its body, if the cloth is not thinner. A point that began inside, near a pin that is
/// inside too, keeps its height or rises a little.
pub fn floors(cloth: &Cloth, net: &Net) -> Vec<f64> {
    let Some((surface, kept)) = cloth.modelled_on() else { return Vec::new() };
    let rest = Posed::at_rest(surface);
    let winding = rest.winding();
    let is_inside = |k: u32| winding.number(cast(cloth.at_rest(k as usize))) > WOUND;
    let depth = |point: usize| {
        let k = net.particles[point];
        let near = rest.near(cast(cloth.at_rest(k as usize)));
        if near.height < 0.0 && !near.is_beside && is_inside(k) { -near.height } else { 0.0 }
    };
    let pinned = (0..net.at.len()).map(|point| if net.free[point] { 0.0 } else { depth(point) }).collect();
    let allowed = spread(net, pinned);
    let mut floors: Vec<f64> = net.particles.iter().map(|k| f64::from(kept[*k as usize])).collect();
    for (point, floor) in floors.iter_mut().enumerate().filter(|(point, _)| net.free[*point]) {
        if *floor < -f64::from(MODELLED_INSIDE_M) && is_inside(net.particles[point]) {
            *floor = (*floor + net.reach[point]).min(f64::from(LEAST_CLEARANCE_M));
        }
        if allowed[point] > 0.0 {
            *floor = floor.min(-allowed[point].min(depth(point)));
        }
    }
    floors
}

/// A point that is reached with a depth.
#[derive(PartialEq)]
struct Reached {
    depth: f64,
    point: u32,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        self.depth.total_cmp(&other.depth).then(other.point.cmp(&self.point))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// For each point the largest depth that is left of that of any point, less by [`RISE`] for each metre along the links. O(n log n).
fn spread(net: &Net, mut depths: Vec<f64>) -> Vec<f64> {
    let mut heap: BinaryHeap<Reached> = BinaryHeap::new();
    for (point, depth) in depths.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
        heap.push(Reached { depth: *depth, point: point as u32 });
    }
    if heap.is_empty() {
        return depths;
    }
    let (starts, others) = net.neighbours();
    while let Some(Reached { depth, point }) = heap.pop() {
        if depth < depths[point as usize] {
            continue;
        }
        for (other, length) in &others[starts[point as usize] as usize..starts[point as usize + 1] as usize] {
            let left = depth - RISE * length;
            if left > depths[*other as usize] {
                depths[*other as usize] = left;
                heap.push(Reached { depth: left, point: *other });
            }
        }
    }
    depths
}
