//! The step of a cloth as data: which passes there are. All forms of a frame are made from them.

mod schedule;

pub use schedule::{FOLLOW_STEPS, MEETING_STEPS, SEARCH_STEPS, Schedule, schedule};
pub(crate) use schedule::{has_levels, soft_of};

use crate::cloth::Skinning;
use crate::collider::{Collider, Shape};

/// A pass over a cloth. Passes of one kind differ in constants only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Pass {
    /// The velocity of the air at each particle, in gusts.
    Gust,
    /// Forces of air on triangles, into a field of accelerations.
    Wind {
        /// Whether the air moves as [`Pass::Gust`] found, or alike everywhere.
        gusts: bool,
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Verlet step of the free particles.
    Integrate(Air),
    /// The same for cloth of a material, which keeps what is too small for a position to take up.
    IntegrateExact(Air),
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
    /// Springs without compliance of one direction and parity, in a round of polish but the last: they move farther than their
    /// lengths ask, which the rounds after them make use of.
    Polish {
        /// 0 or 1.
        direction: u32,
        /// 0 or 1.
        parity: u32,
        /// Whether rest lengths come from an image.
        image: bool,
    },
    /// The multipliers of the last step end with it.
    Forget,
    /// No particle is farther from its anchors than along the surface.
    Tethers {
        /// Anchors per particle.
        slots: u32,
    },
    /// Pinned particles of cloth that follows joints are where the skin is at the end of the step.
    Follow,
    /// No particle is farther from its position at rest than its limit.
    Limit {
        /// Whether it is a distance from the skin, which moves.
        moves: bool,
    },
    /// No particle is farther behind its position at rest, or behind the skin, than its backstop.
    Backstop {
        /// Whether it is behind the skin, which moves.
        moves: bool,
    },
    /// The pull of each stitch between grids, of cloth that has any.
    Stitch {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Particles follow their stitches.
    Sew,
    /// Lengths are limited on coarser grids of the cloth.
    Pyramid {
        /// Which spring directions there are.
        directions: [bool; 4],
        /// Whether nodes at a seam move as those on its other side.
        seams: bool,
        /// Whether any spring is cut.
        cut: bool,
        /// The finest level that one workgroup has, 1 for all: those below are passes of their own.
        finest: u32,
    },
    /// Lengths are limited on one coarser grid with too many nodes for one workgroup.
    CoarseLevel {
        /// The level, from 1 for the finest.
        level: u32,
        /// Which spring directions there are.
        directions: [bool; 4],
        /// Whether any spring is cut.
        cut: bool,
    },
    /// Nodes of such a grid at a seam move as those on its other side.
    CoarseTies {
        /// The level, from 1 for the finest.
        level: u32,
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
    /// Boxes around tiles of particles of cloth that has contact with cloth.
    Leaves,
    /// Boxes around these, level by level.
    Tree,
    /// The nearest particles that each may meet before the next search.
    Partners {
        /// Whether the cloth has seams.
        seams: bool,
    },
    /// How far contact with cloth moves each particle.
    Touch {
        /// Steps since it was last seen where other cloths are, at most [`FOLLOW_STEPS`]; 0 for cloth that meets no other.
        others: u32,
    },
    /// Particles go there.
    Separate,
    /// A cloth as other cloths see it for some steps.
    Shadow,
    /// Boxes around all that the particles of each tile pass until the next search for particles of other cloths, of all cloths with contact.
    Extents,
    /// The nearest particles of other cloths that each particle may meet until then, of all cloths with contact.
    Others,
    /// The features of each cell of cloth whose contact is safe, where these may be others.
    Faces {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Where a step takes the particles of cloth whose contact is safe.
    Gather {
        /// Whether a frame begins: free particles are there already.
        begins: bool,
        /// Whether pins are, too: those that only a host has moved go there in the first step.
        put: bool,
        /// Whether the cloth is asleep.
        sleeps: bool,
    },
    /// How far particles want to go in a round, and boxes around all that they may reach, of all cloths whose contact is safe.
    Paths,
    /// Puts these particles as near to there as they can be without a crossing.
    Truncate,
    /// Particles of cloth whose contact is safe go where they were put.
    HoldBack {
        /// Whether the cloth keeps what is too small for a position to take up.
        exact: bool,
    },
    /// Particles leave the colliders.
    Colliders(Kinds),
    /// Swept: particles leave moving colliders that they are in or went through.
    Contact(Kinds),
    /// The vertices of the surface of a body that a cloth is worn on, at the start and at the end of a frame.
    SurfacePose {
        /// Sets of four joints per vertex; 0 for a surface that rests.
        sets: u32,
        /// How vertices move between joints.
        skinning: Skinning,
    },
    /// Boxes around the patches of that surface.
    SurfaceBoxes,
    /// The planes of that surface that particles meet in a frame.
    SurfaceSearch,
    /// Particles leave these planes.
    SurfaceContact,
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
    /// Triangles that a cut meets are taken away. This and all below run when they are asked for, not every frame.
    Cut,
    /// Springs of those triangles lose their rest lengths.
    CutSprings,
    /// Tethers that a cut crosses grow, or end.
    CutTethers {
        /// Anchors per particle.
        slots: u32,
        /// Whether there are seams.
        seams: bool,
        /// Whether there are stitches.
        sewn: bool,
        /// Whether one workgroup goes from texel to texel, round by round, not each thread one round for its texel.
        walks: bool,
    },
    /// Coarser grids are rebuilt from the rest lengths that are left.
    CutLevels,
    /// A set of particles is moved by a matrix.
    Transform,
    /// A set of particles is put at given positions, or pinned, or freed.
    Place,
    /// The frame of reference has moved: the velocities of free particles change.
    Inertia,
    /// Joints have moved: where they put all particles.
    Skin {
        /// Sets of four joints per particle.
        sets: u32,
        /// How particles move between joints.
        skinning: Skinning,
    },
    /// A coarser image of the cloth goes on from the motion of the finer one.
    Restrict,
    /// A finer image of the cloth goes on from the motion of the coarser one.
    Prolong,
    /// The nearest triangle on a ray, one candidate a workgroup.
    Pick {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// The nearest candidate of all.
    PickNearest,
    /// The box around the cloth. For hosts that ask, and as cloth among colliders comes to rest.
    Bounds,
    /// The triangles that are left, as an index buffer has them. After a cut, where a host has asked for it.
    Indices {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// Tangents along the texture. For hosts that ask.
    Tangents {
        /// Whether any triangle is cut away.
        holes: bool,
    },
    /// The vertices of a mesh that is bound to the cloth. For hosts that ask.
    Wrap {
        /// Whether the cloth has changed its level a short time ago.
        jumps: bool,
    },
    /// How far the vertices of such a mesh would jump as the cloth changes its level.
    Jump,
    /// The triangles of such a mesh that are left after a cut. For hosts that ask.
    WrapIndices,
    /// The vertices of such a mesh that are on the skin, or between the skin and the cloth. For hosts that ask.
    Blend {
        /// Sets of four joints per vertex.
        sets: u32,
        /// How vertices move between joints.
        skinning: Skinning,
    },
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
    /// By their kind, with the two rules of ellipsoids apart.
    pub shapes: [bool; 7],
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
    /// The kinds of some colliders; `None` without colliders.
    pub fn of<'a>(colliders: impl IntoIterator<Item = &'a Collider>) -> Option<Self> {
        let (mut kinds, mut count) = (Kinds::default(), 0);
        for c in colliders {
            let kind = match c.shape {
                Shape::HalfSpace => 0,
                Shape::Sphere { .. } => 1,
                Shape::Capsule { .. } => 2,
                Shape::Box { .. } => 3,
                Shape::Ellipsoid { closest: false, .. } => 4,
                Shape::Ellipsoid { closest: true, .. } => 5,
                Shape::TaperedCapsule { .. } => 6,
            };
            kinds.shapes[kind] = true;
            kinds.friction |= c.friction > 0.0;
            count += 1;
        }
        kinds.many = count >= MANY;
        (count > 0).then_some(kinds)
    }
}
