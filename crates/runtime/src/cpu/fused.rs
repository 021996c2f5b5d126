//! Twin of shaders/fused.wgsl: the whole frame of a cloth. It is also that of cloths whose passes the GPU runs apart.

use super::body::Body;
use super::rows::Threads;
use crate::collider::solid::Solid;
use crate::frame::Frame;
use crate::number::real::Real;

/// Every step, then what ends a frame.
pub fn run<T: Real>(body: &mut Body<T>, frame: &Frame, threads: &Threads, solids: &[Solid<T>]) {
    body.begin();
    (0..frame.steps).for_each(|n| step(body, frame, n, threads, solids));
    end(body, frame, threads, solids);
}

/// One step, after [`Body::begin`].
pub fn step<T: Real>(body: &mut Body<T>, frame: &Frame, n: u32, threads: &Threads, solids: &[Solid<T>]) {
    let Frame { schedule, rounds, .. } = *frame;
    let relax = (0..rounds).flat_map(|_| &schedule.relax);
    let begin = frame.near(n).iter().chain(frame.gusts(n)).chain(frame.air(n));
    let passes = begin.chain(&schedule.step).chain(frame.coarse(n)).chain(relax);
    body.step(passes, threads, &frame.step(n, n).cast(), solids);
}

/// The end of a frame, after its steps.
pub fn end<T: Real>(body: &mut Body<T>, frame: &Frame, threads: &Threads, solids: &[Solid<T>]) {
    body.end();
    let last = frame.steps.saturating_sub(1);
    let last = frame.step(last, last).cast();
    frame.schedule.frame.iter().for_each(|pass| _ = body.run(*pass, threads, &last, solids));
}
