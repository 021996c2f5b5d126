//! The frame: which passes run, in what order, and why.

use crate::cloth::{Cloth, Rest};
use crate::collider::{Collider, Shape};
use crate::wind::{Wind, WindForce};

/// A pass over a cloth. Passes of one kind differ in constants only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Pass {
    /// Forces of air on triangles, into a field of accelerations.
    Wind {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Verlet step of the free particles.
    Integrate(Air),
    /// Springs of one direction (right, down, down-right, up-right) and parity, which share no particle.
    Springs {
        /// 0 to 3.
        direction: u32,
        /// 0 or 1.
        parity: u32,
        /// Whether rest lengths come from an image.
        image: bool,
    },
    /// Duplicates of seam points take one position.
    Seams,
    /// Particles leave the colliders.
    Colliders(Kinds),
    /// Normals from the triangles around a particle.
    Normals {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Duplicates of seam points take one normal.
    SeamNormals,
    /// The largest speed in each workgroup; only where cloth may fall asleep.
    Speed,
    /// The largest speed of all.
    Fastest,
    /// Triangles that a cut meets are taken away. This and all below run for one action, not every frame.
    Cut,
    /// Springs of those triangles lose their rest lengths.
    CutSprings,
    /// A set of particles is moved by a matrix.
    Transform,
    /// The nearest triangle on a ray, one candidate a workgroup.
    Pick {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// The nearest candidate of all.
    PickNearest,
}

/// How air enters the integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Air {
    /// Not at all.
    None,
    /// The same rule for every particle.
    Push,
    /// From the field of [`Pass::Wind`].
    Field,
}

/// Which code a collider pass needs; what no collider needs is not compiled in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Kinds {
    /// By the order of [`Shape`], with the two rules of ellipsoids apart.
    pub shapes: [bool; 6],
    /// Whether any collider has friction; only then are previous positions bound.
    pub friction: bool,
}

impl Kinds {
    /// What a list of colliders needs; `None` if it is empty.
    pub fn of(colliders: &[Collider]) -> Option<Self> {
        let mut kinds = Kinds::default();
        for c in colliders {
            let kind = match c.shape {
                Shape::HalfSpace => 0,
                Shape::Sphere { .. } => 1,
                Shape::Capsule { .. } => 2,
                Shape::Box { .. } => 3,
                Shape::Ellipsoid { closest: false, .. } => 4,
                Shape::Ellipsoid { closest: true, .. } => 5,
            };
            kinds.shapes[kind] = true;
            kinds.friction |= c.friction > 0.0;
        }
        (!colliders.is_empty()).then_some(kinds)
    }
}

/// The passes of a cloth, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// Once a step.
    pub step: Vec<Pass>,
    /// After these, `iterations` times a step.
    pub relax: Vec<Pass>,
    /// Once a frame in which a step was made.
    pub frame: Vec<Pass>,
}

/// The classic solver's frame for a cloth among colliders in wind: only passes that have something to do.
pub fn schedule(cloth: &Cloth, colliders: Option<Kinds>, wind: Option<&Wind>) -> Schedule {
    let air = match wind.map(|w| w.force) {
        None => Air::None,
        Some(WindForce::Push { .. }) => Air::Push,
        Some(WindForce::Triangles { .. }) => Air::Field,
    };
    let mut s = Schedule::default();
    // Reads neighbours, so it cannot be part of the step that moves them.
    s.step.extend((air == Air::Field).then_some(Pass::Wind { holes: cloth.is_cut() }));
    s.step.push(Pass::Integrate(air));
    s.relax.extend(springs(cloth));
    let seams = cloth.ring_count() > 0;
    s.relax.extend(seams.then_some(Pass::Seams));
    // Last, so that a frame ends outside of the colliders. Duplicates are equal here and stay so.
    s.relax.extend(colliders.map(Pass::Colliders));
    s.frame.push(Pass::Normals { holes: cloth.is_cut() });
    s.frame.extend(seams.then_some(Pass::SeamNormals));
    s
}

/// Up to eight passes: directions without springs and parities without room are left out.
fn springs(cloth: &Cloth) -> impl Iterator<Item = Pass> {
    let image = matches!(cloth.rest(), Rest::Image(_));
    let directions = cloth.directions();
    let side = |d: u32| cloth.grids().iter().map(|g| if d == 0 { g.width } else { g.height }).max().unwrap_or(0);
    let room = [0, 1, 2, 3].map(side);
    (0..8).map(|k| (k / 2, k % 2)).filter_map(move |(direction, parity)| {
        let d = direction as usize;
        (directions[d] && room[d] > parity + 1).then_some(Pass::Springs { direction, parity, image })
    })
}
