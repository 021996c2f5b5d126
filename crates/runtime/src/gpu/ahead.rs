//! The pipelines that frames and calls of a host will need.

use super::actions::cuts;
use super::cut_tethers::cut_tethers;
use super::lost::guard;
use super::pipelines::{Compiled, Shared};
use crate::cloth::Cloth;
use crate::error::Result;
use crate::form::Form;
use crate::passes::Pass;
use crate::plan::Plan;
use crate::world::World;

/// What a host may ask of its cloths later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ahead {
    /// [`crate::Stepper::cut`], and the frames after it.
    Cuts,
    /// [`crate::Stepper::record_pick`].
    Picks,
    /// Pins that are set, moved or freed.
    Pins,
    /// [`crate::Stepper::transform`].
    Transforms,
    /// [`crate::Stepper::record_bounds`].
    Bounds,
    /// [`crate::Stepper::index_buffer`].
    Indices,
    /// [`crate::Stepper::record_tangents`].
    Tangents,
}

impl Ahead {
    /// All of them.
    pub const ALL: [Ahead; 7] =
        [Ahead::Cuts, Ahead::Picks, Ahead::Pins, Ahead::Transforms, Ahead::Bounds, Ahead::Indices, Ahead::Tangents];
}

/// What the frames of a world run, so that none waits for a compiler.
pub(super) fn frames(world: &World) -> Vec<Form> {
    let mut forms: Vec<Form> = Plan::new(world).passes.into_iter().map(|p| p.form).collect();
    if world.calm_below().is_some() && !world.scene.colliders.is_empty() {
        // Nor the frame in which a cloth among colliders first comes to rest.
        forms.push(Pass::Bounds.into());
    }
    let pinned = |c: &Cloth| c.particles().iter().any(|p| p.is_pinned());
    if world.scene.cloths.iter().any(pinned) {
        // Nor the first frame in which they move.
        forms.push(Pass::Place.into());
    }
    forms
}

/// What else runs where the host asks for it. Cuts change the world: its cloths are cut from then on.
fn asked(world: &mut World, ahead: &[Ahead]) -> Vec<Form> {
    let mut passes = Vec::new();
    let cut = ahead.contains(&Ahead::Cuts);
    for holes in [Some(false), cut.then_some(true)].into_iter().flatten() {
        for what in ahead {
            match what {
                Ahead::Cuts => {}
                Ahead::Picks => passes.extend([Pass::Pick { holes }, Pass::PickNearest]),
                Ahead::Pins => passes.push(Pass::Place),
                Ahead::Transforms => passes.push(Pass::Transform),
                Ahead::Bounds => passes.push(Pass::Bounds),
                Ahead::Indices => passes.push(Pass::Indices { holes }),
                Ahead::Tangents => passes.push(Pass::Tangents { holes }),
            }
        }
    }
    let mut forms = Vec::new();
    if cut {
        for (cloth, run) in world.scene.cloths.iter().zip(&world.runs) {
            passes.extend(cuts(cloth, &world.control.options));
            passes.extend(cut_tethers(cloth, &run.tethers));
        }
        world.scene.cloths.iter_mut().for_each(Cloth::open);
        world.reschedule();
        forms = frames(world);
    }
    forms.extend(passes.into_iter().map(Form::from));
    forms
}

/// Pipelines that are still to be compiled, by [`crate::Stepper::prepare`]. It may go to another thread: frames that are recorded meanwhile
/// wait only if they need the very pipeline that is being compiled.
pub struct Preparation {
    /// None where nothing is compiled.
    shared: Option<Shared>,
    /// The last one is the next.
    forms: Vec<Form>,
}

impl Preparation {
    /// Of a world that is made for this, or none.
    pub(crate) fn new(of: Option<(&Shared, World, &[Ahead])>) -> Self {
        let Some((shared, mut world, ahead)) = of else { return Preparation { shared: None, forms: Vec::new() } };
        let mut forms: Vec<Form> = Vec::new();
        let all = frames(&world).into_iter().chain(asked(&mut world, ahead));
        for form in all {
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
    /// Errors on a device that is lost or has no memory left.
    pub fn run_one(&mut self) -> Result<Compiled> {
        let mut compiled = Compiled::default();
        if let (Some(shared), Some(form)) = (&self.shared, self.forms.pop()) {
            guard(shared.device(), || {
                shared.make(&form, &mut compiled);
                Ok(())
            })?;
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
