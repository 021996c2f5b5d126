//! The pipelines that frames and calls of a host will need.

use super::actions::cuts;
use super::cut_tethers::cut_tethers;
use super::lost::{guard, is_lost};
use super::pipelines::{Compiled, Shared};
use crate::cloth::Cloth;
use crate::error::{Error, Result};
use crate::form::Form;
use crate::passes::Pass;
use crate::plan::Plan;
use crate::world::{World, is_safe};

/// A request that a host may make of its cloths later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ahead {
    /// [`crate::Stepper::cut`], and the frames after it.
    Cuts,
    /// [`crate::Stepper::record_pick`].
    Picks,
    /// Pins that are set, moved or freed, and the frames after the last one is freed.
    Pins,
    /// [`crate::Stepper::transform`].
    Transforms,
    /// [`crate::Stepper::set_state`] and [`crate::Stepper::restore`]; for states of cut cloth beside [`Ahead::Cuts`].
    States,
    /// [`crate::Stepper::record_bounds`], and boxes around cloth that the host lets sleep ([`crate::Stepper::set_asleep`]).
    Bounds,
    /// [`crate::Stepper::index_buffer`].
    Indices,
    /// [`crate::Stepper::record_tangents`].
    Tangents,
    /// [`crate::Stepper::record_wrap`], but for vertices that blend to the skin, and [`crate::Stepper::render_index_buffer`].
    RenderMeshes,
    /// [`crate::Stepper::set_levels`]: the passes that carry motion. Those of a frame on a level are compiled by the first switch to it,
    /// unless cloths of other sizes have them.
    Levels,
    /// [`crate::Stepper::set_moving_frame`].
    MovingFrames,
}

impl Ahead {
    /// All of them.
    pub const ALL: &'static [Ahead] = &[
        Ahead::Cuts,
        Ahead::Picks,
        Ahead::Pins,
        Ahead::Transforms,
        Ahead::States,
        Ahead::Bounds,
        Ahead::Indices,
        Ahead::Tangents,
        Ahead::RenderMeshes,
        Ahead::Levels,
        Ahead::MovingFrames,
    ];
}

/// Forms that the frames of a world run, so that none waits for a compiler.
pub(super) fn frames(world: &World) -> Vec<Form> {
    let mut forms: Vec<Form> = Plan::new(world).passes.into_iter().map(|p| p.form).collect();
    if world.calm_below().is_some() && !world.scene.colliders.is_empty() {
        // Nor the frame in which a cloth among colliders first comes to rest.
        forms.push(Pass::Bounds.into());
    }
    for cloth in world.scene.cloths.iter().filter(|cloth| world.has_safe() && is_safe(cloth)) {
        forms.push(Pass::Faces { holes: cloth.is_cut() }.into());
        // Nor its first frame, nor the first one in which it sleeps.
        let begins = [(true, false), (false, true), (true, true)];
        forms.extend(begins.map(|(put, sleeps)| Pass::Gather { begins: true, put, sleeps }.into()));
    }
    let pinned = |c: &Cloth| c.particles().iter().any(|p| p.is_pinned());
    if world.scene.cloths.iter().any(pinned) {
        // Nor the first frame in which they move.
        forms.push(Pass::Place.into());
    }
    forms
}

/// The same with all rounds of polish that may be in force.
fn all_frames(world: &mut World, rounds: &[u32]) -> Vec<Form> {
    let mut forms = Vec::new();
    for rounds in rounds {
        world.polish(*rounds);
        forms.extend(frames(world));
    }
    forms
}

/// The passes that calls of a host run on cloths that have holes or none.
fn asked(world: &World, ahead: &[Ahead], holes: bool) -> Vec<Pass> {
    let mut passes = Vec::new();
    for what in ahead {
        match what {
            Ahead::Cuts => {}
            Ahead::Picks => passes.extend([Pass::Pick { holes }, Pass::PickNearest]),
            Ahead::Pins => passes.push(Pass::Place),
            Ahead::Transforms => passes.push(Pass::Transform),
            Ahead::States => {
                let drawn = |p: &&Pass| matches!(p, Pass::Normals { .. } | Pass::SeamNormals);
                passes.extend(world.runs.iter().flat_map(|run| run.schedule.frame.iter().filter(drawn)));
            }
            Ahead::Bounds => passes.push(Pass::Bounds),
            Ahead::Indices => passes.push(Pass::Indices { holes }),
            Ahead::Tangents => passes.push(Pass::Tangents { holes }),
            Ahead::RenderMeshes => {
                passes.push(Pass::Wrap { jumps: false });
                passes.extend(holes.then_some(Pass::WrapIndices));
                if ahead.contains(&Ahead::Levels) {
                    passes.extend([Pass::Wrap { jumps: true }, Pass::Jump]);
                }
            }
            Ahead::MovingFrames => passes.push(Pass::Inertia),
            Ahead::Levels => passes.extend([Pass::Restrict, Pass::Prolong]),
        }
    }
    passes
}

/// All that runs in a world with some rounds of polish; `cut` where its cloths are cut, or will be.
fn all(world: &mut World, rounds: &[u32], ahead: &[Ahead], cut: bool) -> Vec<Form> {
    let mut forms = all_frames(world, rounds);
    let mut passes = asked(world, ahead, false);
    if cut {
        for (cloth, run) in world.scene.cloths.iter().zip(&world.runs) {
            passes.extend(cuts(cloth, &world.control.options));
            passes.extend(cut_tethers(cloth, &run.tethers).into_iter().flatten());
        }
        world.scene.cloths.iter_mut().for_each(Cloth::open);
        forms.extend(all_frames(world, rounds));
        passes.extend(asked(world, ahead, true));
    }
    forms.extend(passes.into_iter().map(Form::from));
    forms
}

/// Pipelines that are still to be compiled, by [`crate::Stepper::prepare`]. It may go to another thread: frames that are recorded meanwhile
/// wait only if they need the very pipeline that is being compiled. With OpenGL, where one thread at a time uses a device, all of them wait,
/// and wgpu panics after a second: there, compile on the thread that records.
#[must_use = "nothing is compiled before it runs"]
pub struct Preparation {
    /// None where nothing is compiled.
    shared: Option<Shared>,
    /// The last one is the next.
    forms: Vec<Form>,
}

impl Preparation {
    /// Without any pipeline.
    pub(crate) fn none() -> Self {
        Preparation { shared: None, forms: Vec::new() }
    }

    /// Of a world that is made for this, and the rounds of polish that it may have; `cut` where its cloths are cut already.
    pub(super) fn new(shared: &Shared, (mut world, rounds): (World, Vec<u32>), ahead: &[Ahead], cut: bool) -> Self {
        let mut forms: Vec<Form> = Vec::new();
        for form in all(&mut world, &rounds, ahead, cut || ahead.contains(&Ahead::Cuts)) {
            if !forms.contains(&form) && !shared.has(&form) {
                forms.push(form);
            }
        }
        forms.reverse();
        Preparation { shared: Some(shared.clone()), forms }
    }

    /// Pipelines that are left.
    pub fn left(&self) -> usize {
        self.forms.len()
    }

    /// Compiles the next one, as a loading screen may do in each frame. Nothing is compiled if none is left, or another thread was faster.
    /// Errors on a device that is lost or has no memory left: then the pipeline is still left.
    pub fn run_one(&mut self) -> Result<Compiled> {
        let mut compiled = Compiled::default();
        if let (Some(shared), Some(form)) = (&self.shared, self.forms.last()) {
            let made = guard(shared.device(), || {
                shared.make(form, &mut compiled);
                // A lost device compiles nothing, and raises no error.
                if is_lost(shared.device()) { Err(Error::DeviceLost) } else { Ok(()) }
            });
            if let Err(error) = made {
                shared.forget(form);
                return Err(error);
            }
            self.forms.pop();
        }
        Ok(compiled)
    }

    /// Compiles all that are left.
    pub fn run(mut self) -> Result<Compiled> {
        let mut all = Compiled::default();
        while self.left() > 0 {
            let one = self.run_one()?;
            all.pipelines += one.pipelines;
            all.ms += one.ms;
        }
        Ok(all)
    }
}
