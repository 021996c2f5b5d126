//! Twin of shaders/fused.wgsl: the whole frame of a cloth. It is also that of cloths whose passes the GPU runs apart.

use super::body::Body;
use super::rows::Threads;
use crate::collider::solid::Solid;
use crate::number::real::Real;
use crate::passes::Schedule;
use crate::step::Step;

/// What a frame is made of.
pub struct Frame<'a, T> {
    /// Its passes.
    pub plan: &'a Schedule,
    /// Steps.
    pub steps: u32,
    /// Relaxations per step.
    pub rounds: u32,
    /// Whether a step has the passes on coarser grids.
    pub coarse: &'a dyn Fn(u32) -> bool,
    /// The numbers of a step.
    pub step: &'a dyn Fn(u32) -> Step<T>,
}

/// Every step, then what ends a frame.
pub fn run<T: Real>(body: &mut Body<T>, frame: &Frame<T>, threads: &Threads, solids: &[Solid<T>]) {
    let Frame { plan, steps, .. } = *frame;
    body.begin();
    for n in 0..steps {
        let relax = (0..frame.rounds).flat_map(|_| &plan.relax);
        let coarse = if (frame.coarse)(n) { &plan.coarse[..] } else { &[] };
        body.step(plan.step.iter().chain(coarse).chain(relax), threads, &(frame.step)(n), solids);
    }
    body.end();
    let last = (frame.step)(steps.saturating_sub(1));
    plan.frame.iter().for_each(|pass| _ = body.run(*pass, threads, &last, solids));
}
