//! Scripts: the motion of colliders and pins, and cuts, over time.

use super::Scene;
use super::motion::{Motion, Pose};
/// Particles that are pinned together.
#[derive(Clone, Debug, PartialEq)]
pub struct PinnedSet {
    /// Index of the cloth.
    pub cloth: usize,
    /// The particles and where each is at the start \[m\].
    pub particles: Vec<(usize, [f32; 3])>,
    /// How they move together: turned about `pivot`, then moved by the position. `None` stays.
    pub motion: Option<Motion>,
    /// The point that they turn about \[m\].
    pub pivot: [f32; 3],
    /// When \[s\] they are let go.
    pub release: Option<f64>,
}

impl PinnedSet {
    /// The particles, as [`crate::Stepper::set_pins`] takes them.
    pub fn indices(&self) -> Vec<u32> {
        self.particles.iter().map(|(k, _)| u32::try_from(*k).unwrap_or(u32::MAX)).collect()
    }
}

/// A cut along the triangle of an eye and two points that it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// When \[s\].
    pub time: f64,
    /// The triangle's corners \[m\].
    pub triangle: [[f32; 3]; 3],
}

/// Everything that happens. The order within a frame is the order of the fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// The motion of each collider of the scene; `None`, or a list that ends before, stays.
    pub colliders: Vec<Option<Motion>>,
    /// Pinned particles that move or are let go.
    pub pins: Vec<PinnedSet>,
    /// Cuts through all cloths.
    pub cuts: Vec<Cut>,
}

impl Script {
    /// Whether nothing ever happens.
    pub fn is_empty(&self) -> bool {
        self.colliders.iter().all(Option::is_none) && self.pins.is_empty() && self.cuts.is_empty()
    }

    /// Puts colliders where they are at time 0, at rest. To be called before a stepper takes the scene.
    pub fn start(&self, scene: &mut Scene) {
        for (collider, motion) in scene.colliders.iter_mut().zip(&self.colliders) {
            if let Some(motion) = motion {
                let Pose { position, rotation } = motion.at(0.0);
                (collider.center, collider.rotation) = (position, rotation);
            }
        }
    }
}
