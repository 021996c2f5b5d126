//! What is to be stepped: cloths, colliders and forces.

mod builtin;
#[cfg(feature = "scene-file")]
pub mod file;
mod motion;
mod script;

pub use builtin::{BUILTIN, builtin};
pub use motion::{Key, Motion, Pose, about};
pub use script::{Cut, PinnedSet, Script};

use crate::cloth::Cloth;
use crate::collider::Collider;
use crate::error::{Result, check};
use crate::wind::Wind;

/// A scene at its start.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// The cloths; they do not touch one another.
    pub cloths: Vec<Cloth>,
    /// What the cloths do not enter.
    pub colliders: Vec<Collider>,
    /// Acceleration of everything free \[m/s^2\].
    pub gravity: [f32; 3],
    /// Moving air; without it nothing is spent on air.
    pub wind: Option<Wind>,
    /// Frames of 1/60 s after which the scene has shown what it is for.
    pub frames: u32,
}

impl Scene {
    /// An empty scene under the earth's gravity.
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
