//! Scenes: cloths, colliders and forces.

mod builtin;
#[cfg(feature = "scene-file")]
pub mod file;
mod motion;
mod script;

pub use builtin::builtin;
pub use motion::{Key, Motion, Pose, about};
pub use script::{Cut, PinnedSet, Script};

pub use crate::error::BUILTIN;

use crate::cloth::Cloth;
use crate::collider::Collider;
use crate::error::{Result, check};
use crate::wind::Wind;

/// A scene at its start.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// The cloths; two touch one another if both have [`Cloth::contact`].
    pub cloths: Vec<Cloth>,
    /// The colliders.
    pub colliders: Vec<Collider>,
    /// Acceleration of everything free \[m/s^2\].
    pub gravity: [f32; 3],
    /// Wind; none has no cost.
    pub wind: Option<Wind>,
    /// Duration of the scene in frames of 1/60 s.
    pub frames: u32,
}

impl Scene {
    /// An empty scene under Earth's gravity.
    pub fn new(name: &str) -> Self {
        Scene {
            name: name.into(),
            cloths: Vec::new(),
            colliders: Vec::new(),
            gravity: [0.0, -9.81, 0.0],
            wind: None,
            frames: 600,
        }
    }

    /// The colliders that cloth of some groups meets, in order.
    pub(crate) fn met(&self, collision_groups: u32) -> impl Iterator<Item = &Collider> {
        self.colliders.iter().filter(move |c| c.is_met(collision_groups))
    }

    /// Whether cloth of some groups meets any collider.
    pub(crate) fn meets(&self, collision_groups: u32) -> bool {
        self.met(collision_groups).next().is_some()
    }

    /// The groups of all cloths together.
    pub(crate) fn collision_groups(&self) -> u32 {
        self.cloths.iter().fold(0, |all, cloth| all | cloth.met_groups())
    }

    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        self.colliders.iter().try_for_each(Collider::check)?;
        self.wind.iter().try_for_each(Wind::check)?;
        for x in self.gravity {
            check("gravity [m/s^2]", f64::from(x), "finite", |_| true)?;
        }
        self.cloths.iter().try_for_each(Cloth::check)
    }
}
