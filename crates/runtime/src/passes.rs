//! Passes: what one dispatch does to a cloth.

use crate::collider::{Collider, Shape};

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
    /// The same for cloth of a material, which keeps what is too small for a position to take up.
    Advance(Air),
    /// Multipliers of bending, of cloth that has any.
    Moments {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Duplicates of seam points take the sum of their multipliers.
    SeamMoments,
    /// Particles follow them.
    Bend,
    /// The cells of a membrane in every other column and row, of cloth of a material.
    Membrane {
        /// The first column, 0 or 1.
        column: u32,
        /// The first row, 0 or 1.
        row: u32,
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Springs of one direction (right, down, down-right, up-right) and parity, which share no particle.
    Springs {
        /// 0 to 3.
        direction: u32,
        /// 0 or 1.
        parity: u32,
        /// Whether rest lengths come from an image.
        image: bool,
    },
    /// Springs with compliance of one direction and parity.
    Stretch {
        /// 0 to 3.
        direction: u32,
        /// 0 or 1.
        parity: u32,
        /// Whether rest lengths come from an image.
        image: bool,
        /// Where compliance comes from.
        soft: Soft,
        /// Whether multipliers are summed over several relaxations.
        again: bool,
    },
    /// The multipliers of the last step end with it.
    Forget,
    /// No particle is farther from its anchors than along the surface.
    Tethers {
        /// Anchors per particle.
        slots: u32,
    },
    /// Lengths are limited on coarser grids of the cloth.
    Pyramid {
        /// Which spring directions there are.
        directions: [bool; 4],
        /// Whether nodes at a seam move as those on its other side.
        seams: bool,
        /// Whether any spring is cut.
        cut: bool,
    },
    /// Particles follow the coarser grids.
    Refine {
        /// Whether the cloth has seams.
        seams: bool,
        /// Whether any spring is cut.
        cut: bool,
    },
    /// Duplicates of seam points take one position.
    Seams,
    /// Duplicates of seam points take one position, and one previous position.
    SeamSteps,
    /// Particles leave the colliders.
    Colliders(Kinds),
    /// Swept: particles leave moving colliders that they are in or went through.
    Contact(Kinds),
    /// Particles that are nowhere are counted.
    Guard,
    /// Cloth with such particles goes back to the last good frame.
    Restore,
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
    /// The largest stretch of springs to the right and down; only where substeps are chosen by it.
    Strain {
        /// Whether rest lengths come from an image.
        image: bool,
        /// Where compliance comes from, which accounts for a part of it.
        soft: Soft,
    },
    /// Triangles that a cut meets are taken away. This and all below run for one action, not every frame.
    Cut,
    /// Springs of those triangles lose their rest lengths.
    CutSprings,
    /// Tethers that a cut crosses grow, or end.
    CutTethers {
        /// Anchors per particle.
        slots: u32,
        /// Whether there are seams.
        seams: bool,
    },
    /// Coarser grids are rebuilt from the rest lengths that are left.
    CutLevels,
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

impl Pass {
    /// Whether it is of springs to the right or down.
    pub(crate) fn is_structural(&self) -> bool {
        matches!(self, Pass::Stretch { direction: 0 | 1, .. })
    }
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

/// Where the compliance of springs comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Soft {
    /// There is none.
    None,
    /// The same for all springs of a cloth.
    Constant,
    /// From an image.
    Image,
}

/// Which code a collider pass needs; what no collider needs is not compiled in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Kinds {
    /// By the order of [`Shape`], with the two rules of ellipsoids apart.
    pub shapes: [bool; 6],
    /// Whether any collider has friction; only then are previous positions bound.
    pub friction: bool,
    /// Whether each workgroup skips colliders out of reach of its own particles; for
    /// [`Pass::Contact`] only.
    pub many: bool,
}

/// From this number of colliders on it is quicker to find out first which are near. On a software adapter, 64 x 64 particles and 8
/// steps: 6.6 ms per frame with, against 5.7 without for one collider out of reach, 7.7 for two and 143 for a hundred.
const MANY: usize = 2;

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
        kinds.many = colliders.len() >= MANY;
        (!colliders.is_empty()).then_some(kinds)
    }
}
