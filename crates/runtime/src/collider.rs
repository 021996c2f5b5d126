//! Colliders: solids that cloth does not enter.

mod from_bundle;
pub(crate) mod path;
pub(crate) mod solid;

pub use from_bundle::BodyCollider;
pub(crate) use from_bundle::FRICTION;

use gimage_bundle::manifest::MAX_COLLIDER_SIZE_M;

use crate::error::{Result, check};

/// The group of colliders that stand for a body: cloth with a [`crate::BodySurface`] does not meet those that are in no other.
///
/// [`BodyCollider::of_bundle`] puts the solids of a bundle that has a surface in this group alone, so that a scene can have both.
pub const BODY_GROUP: u32 = 1 << 31;

/// The shape of a collider in its local frame. All lengths in metres, above 0, at most 1e6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Everything at or below the plane through the centre with normal +y.
    HalfSpace,
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// All points within `radius` of the segment from -y to +y of length `2 half_height`.
    Capsule {
        /// Half the length of the segment.
        half_height: f32,
        /// Distance from the segment.
        radius: f32,
    },
    /// The convex hull of two balls at the ends of a segment from -y to +y: a cone between them that touches both.
    TaperedCapsule {
        /// Half the length of the segment.
        half_height: f32,
        /// Radii of the balls at -y and at +y; they differ by less than the length of the segment, as otherwise one ball holds the other.
        radii: [f32; 2],
    },
    /// A box; a particle leaves by the nearest face.
    Box {
        /// Half its sides along x, y, z.
        half: [f32; 3],
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Its half axes along x, y, z.
        radii: [f32; 3],
        /// False: a particle leaves along the ray from the centre, as the algorithm of 2005 does: cheap, and exact for
        /// a ball only. True: it goes to the closest point of the surface.
        closest: bool,
    },
}

/// A collider: a shape, its pose and its motion. Contact is inelastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collider {
    /// Its shape.
    pub shape: Shape,
    /// Its centre \[m\].
    pub center: [f32; 3],
    /// From its frame to the world, a unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
    /// Coulomb coefficient, at least 0; larger slides less.
    pub friction: f32,
    /// Velocity of the centre \[m/s\]; friction drags cloth along with the surface.
    pub velocity: [f32; 3],
    /// Angular velocity \[rad/s\] about the centre.
    pub spin: [f32; 3],
    /// The groups that it is in, a bit each. It meets the cloths whose [`crate::Cloth::collision_groups`] share a bit.
    /// Default all.
    pub collision_groups: u32,
}

impl Collider {
    /// A collider at rest at `center`, unrotated, without friction, in all groups.
    pub fn new(shape: Shape, center: [f32; 3]) -> Self {
        let rotation = [0.0, 0.0, 0.0, 1.0];
        let (velocity, spin, collision_groups) = ([0.0; 3], [0.0; 3], u32::MAX);
        Collider { shape, center, rotation, friction: 0.0, velocity, spin, collision_groups }
    }

    /// Whether cloth of some groups meets it.
    pub(crate) fn is_met(&self, collision_groups: u32) -> bool {
        self.collision_groups & collision_groups != 0
    }

    /// Refuses numbers that are not finite, sizes not above 0, friction below 0 and a rotation that is not a unit
    /// quaternion (to 1e-3).
    pub fn check(&self) -> Result<()> {
        let sizes = match self.shape {
            Shape::HalfSpace => [1.0; 3],
            Shape::Sphere { radius } => [radius; 3],
            Shape::Capsule { half_height, radius } => [half_height, radius, radius],
            Shape::TaperedCapsule { half_height, radii: [low, high] } => [half_height, low, high],
            Shape::Box { half } => half,
            Shape::Ellipsoid { radii, .. } => radii,
        };
        for size in sizes {
            let ok = |s| s > 0.0 && s <= MAX_COLLIDER_SIZE_M;
            check("the size of a collider [m]", f64::from(size), "above 0, at most 1e6", ok)?;
        }
        if let Shape::TaperedCapsule { half_height, radii: [low, high] } = self.shape {
            let differ = f64::from((low - high).abs());
            let what = "the difference of the radii of a tapered capsule [m]";
            check(what, differ, "below its length; use a ball", |d| d < 2.0 * f64::from(half_height))?;
        }
        check("the friction of a collider", f64::from(self.friction), "at least 0", |f| f >= 0.0)?;
        for x in [self.center, self.velocity, self.spin].as_flattened() {
            check("the place or motion of a collider", f64::from(*x), "finite", |_| true)?;
        }
        let norm = self.rotation.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        check("the length of a collider's rotation", norm, "1", |n| (n - 1.0).abs() < 1e-3)
    }
}
