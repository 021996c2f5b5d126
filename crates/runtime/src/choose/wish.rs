//! The numbers that each cloth asks for.

use super::{hung, in_step, needs, top_speed};
use crate::cloth::Cloth;
use crate::options::Options;
use crate::scene::Scene;

/// The numbers that one cloth asks for as long as it is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Steps per [`Options::step`], of cloth and colliders at rest.
    pub substeps: u32,
    /// The same of cloth that is stirred; 0 if it makes no difference.
    pub stirred: u32,
    /// Rounds of polish.
    pub polish: u32,
}

impl Wish {
    /// The numbers of all cloths of a scene.
    pub fn of(given: &Options, scene: &Scene) -> Vec<Self> {
        let moves = top_speed(scene);
        let wish = |cloth: &Cloth| {
            let (lasting, fast) = needs(cloth, given, scene, moves);
            let polish = fast.map_or(lasting.polish, |f| f.polish.max(lasting.polish));
            let stirred = match hung::stirred(cloth, &lasting) {
                0 => 0,
                substeps => in_step(substeps, given.step),
            };
            Wish { substeps: in_step(lasting.substeps, given.step), stirred, polish }
        };
        scene.cloths.iter().map(wish).collect()
    }

    /// The largest numbers of some cloths; none of no cloth.
    pub fn most(all: &[Self]) -> Option<Self> {
        all.iter().copied().reduce(|a, b| Wish {
            substeps: a.substeps.max(b.substeps),
            stirred: a.stirred.max(b.stirred),
            polish: a.polish.max(b.polish),
        })
    }
}
