//! Twin of shaders/cut_tethers.wgsl: after a cut tethers stay where they are still true, grow where the way to the pin
//! has become longer, and end where there is none.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::route::{Held, UNSUPPORTED, far};
use crate::number::real::Real;

/// Follows a cut that has changed rest lengths from `old` to `rest`; says whether any tether has changed.
///
/// First those go whose way is no longer there, and all whose way led by them; then they take the shortest way that is
/// left, nearest first. A particle that no pin reaches has no tether.
pub fn run<T: Real>(held: &mut Held<T>, old: &[[T; 4]], rest: &[[T; 4]]) -> bool {
    let lost = doubt(held, old, rest);
    lengthen(held, rest, &lost);
    lost.contains(&true)
}

/// Ends the tethers that nothing supports any more, and says which: nearest first, as each rests on nearer ones alone.
fn doubt<T: Real>(held: &mut Held<T>, old: &[[T; 4]], rest: &[[T; 4]]) -> Vec<bool> {
    let (before, mut lost) = (held.most.clone(), vec![false; held.most.len()]);
    let (mut queue, mut listed) = (BinaryHeap::new(), vec![false; held.most.len()]);
    // Tethers of texel `k` that may rest on one of length `above`; pins hang on themselves.
    let mut add = |held: &Held<T>, k: usize, above: T, queue: &mut BinaryHeap<_>| {
        let slots = k * held.slots..(k + 1) * held.slots;
        for (t, (most, listed)) in slots.clone().zip(held.most[slots.clone()].iter().zip(&mut listed[slots])) {
            if *most > above && *most < far() && !std::mem::replace(listed, true) {
                queue.push(Reverse((most.get().to_bits(), t)));
            }
        }
    };
    let zero = T::of(0.0);
    for k in 0..rest.len() {
        // The other ends of its springs are beside it, and the third corners of triangles beside them.
        if (0..4).any(|d| old[k][d] > zero && rest[k][d] <= zero) {
            held.beside(k, |n| held.beside(n, |m| add(held, m, zero, &mut queue)));
        }
    }
    while let Some(Reverse((_, t))) = queue.pop() {
        let (k, own) = (t / held.slots, held.most[t]);
        if lost[t] {
            continue;
        }
        let after = held.support(rest, &held.most, k, t);
        if after == 0 || (after < UNSUPPORTED && after == held.support(old, &before, k, t)) {
            continue;
        }
        let mut members = Vec::new();
        held.ring(k, |m| members.push(m * held.slots + t % held.slots));
        for t in members {
            (held.most[t], lost[t]) = (far(), true);
        }
        held.beside(k, |n| add(held, n, own, &mut queue));
    }
    lost
}

/// Finds the shortest way of those that are lost: Dijkstra's order, and again where one turns out shorter later.
fn lengthen<T: Real>(held: &mut Held<T>, rest: &[[T; 4]], lost: &[bool]) {
    let mut queue = BinaryHeap::new();
    for t in (0..lost.len()).filter(|t| lost[*t]) {
        take(held, rest, t, &mut queue);
    }
    while let Some(Reverse((bits, t))) = queue.pop() {
        if held.most[t].get().to_bits() != bits {
            continue;
        }
        let mut around = Vec::new();
        held.beside(t / held.slots, |n| {
            let slots = n * held.slots..(n + 1) * held.slots;
            let farther = |u: &usize| held.most[*u] > held.most[t] && held.groups[*u] == held.groups[t];
            around.extend(slots.filter(|u| lost[*u] && farther(u)));
        });
        around.into_iter().for_each(|u| take(held, rest, u, &mut queue));
    }
}

/// Gives a tether, and those of its duplicates, the shortest way there is now.
fn take<T: Real>(held: &mut Held<T>, rest: &[[T; 4]], t: usize, queue: &mut BinaryHeap<Reverse<(u64, usize)>>) {
    let (k, s) = (t / held.slots, t % held.slots);
    let way = held.nearest(rest, k, held.groups[t]);
    if way.0 < far() && way < (held.most[t], held.anchors[t]) {
        let mut members = Vec::new();
        held.ring(k, |m| members.push(m * held.slots + s));
        members.into_iter().for_each(|t| (held.most[t], held.anchors[t]) = way);
        queue.push(Reverse((way.0.get().to_bits(), t)));
    }
}

#[cfg(test)]
#[path = "cut_tethers_tests.rs"]
mod tests;
