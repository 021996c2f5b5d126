//! Speeds of cloth and colliders, and the substeps that they need.

use super::{FRAME_S, MAX_SUBSTEPS, is_pinned};
use crate::cloth::Cloth;
use crate::collider::solid::Solid;
use crate::number::real::dot;
use crate::scene::Scene;

/// Largest share of a collider's radius that fast cloth moves in a step.
const FAST_SHARE: f64 = 0.1;
/// The same for cloth that follows joints, which moves along with the body.
const WORN_SHARE: f64 = 0.25;

/// Substeps in which a cloth of this speed \[m/s\], and each collider that it meets, move by no more than a share of the thickness of the collider that moves, or that
/// is met.
pub fn for_speed(own: f64, cloth: &Cloth, scene: &Scene) -> u32 {
    let ratio = |s: Solid<f64>| (own + speed_of(&s)) / s.thickness();
    let most = scene.met(cloth.met_groups()).map(Solid::<f64>::new).map(ratio).fold(0.0, f64::max);
    let share = if cloth.follows_joints() { WORN_SHARE } else { FAST_SHARE };
    (most * FRAME_S / share).ceil().min(f64::from(MAX_SUBSTEPS)) as u32
}

/// Substeps in which no collider moves far past any cloth.
pub fn for_colliders(scene: &Scene) -> u32 {
    scene.cloths.iter().map(|cloth| for_speed(0.0, cloth, scene)).max().unwrap_or(0)
}

pub fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

pub fn own_speed(cloth: &Cloth) -> f64 {
    length(cloth.velocity.map(f64::from))
}

/// Largest speed \[m/s\] of a point of a collider that any cloth meets.
pub fn top_speed(scene: &Scene) -> f64 {
    scene.met(scene.collision_groups()).map(Solid::<f64>::new).map(|s| speed_of(&s)).fold(0.0, f64::max)
}

/// Largest speed \[m/s\] of a point of a collider.
fn speed_of(solid: &Solid<f64>) -> f64 {
    // The rim of a half-space that turns is far away.
    length(solid.velocity) + length(solid.spin) * solid.around().unwrap_or(0.0)
}

/// Speed \[m/s\] of a fall from the start onto the highest collider that it meets; 0 for pinned cloth.
pub fn fall(cloth: &Cloth, scene: &Scene) -> f64 {
    let g = scene.gravity.map(f64::from);
    let strength = length(g);
    if strength <= 0.0 || !scene.meets(cloth.met_groups()) || is_pinned(cloth) {
        return 0.0;
    }
    let height = |p: [f64; 3]| -dot(p, g) / strength;
    let sum: f64 = cloth.positions().iter().map(|p| height(p.map(f64::from))).sum();
    let solids = scene.met(cloth.met_groups()).map(Solid::<f64>::new);
    let tops = solids.map(|s| height(s.center) + s.around().unwrap_or(0.0));
    let drop = sum / f64::max(cloth.len() as f64, 1.0) - tops.fold(f64::NEG_INFINITY, f64::max);
    (2.0 * strength * drop.max(0.0)).sqrt()
}
