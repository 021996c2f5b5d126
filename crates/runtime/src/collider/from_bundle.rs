//! The solids of a bundle as colliders.

use gimage_bundle::Bundle;
use gimage_bundle::manifest::{ColliderEntry, ColliderShape};

use super::{BODY_GROUP, Collider, Shape};

/// Friction of a body: that of skin or of a lining.
pub(crate) const FRICTION: f32 = 0.3;

/// A collider that stands for a part of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCollider {
    /// The joint that it follows, by name; none for a body without joints.
    pub joint: Option<String>,
    /// The collider where the body is bound to its skeleton, as the cloth of the bundle is, with a friction of 0.3.
    pub collider: Collider,
}

impl BodyCollider {
    /// The solids that `gimage dress` stores in a bundle, in its order; shapes that this version does not know are left out. A scene checks
    /// their sizes. Those of a bundle with a [`crate::BodySurface`] are in [`BODY_GROUP`] alone, so that cloth that meets the surface does not meet them, but for
    /// those that stand for parts which the surface does not have.
    pub fn of_bundle(bundle: &Bundle) -> Vec<Self> {
        let of = |entry: &ColliderEntry| {
            let mut part = Self::of(entry)?;
            if bundle.body.is_some() && !entry.guessed {
                part.collider.collision_groups = BODY_GROUP;
            }
            Some(part)
        };
        bundle.manifest.colliders.iter().filter_map(of).collect()
    }

    fn of(entry: &ColliderEntry) -> Option<Self> {
        let float = |v: [f64; 3]| v.map(|x| x as f32);
        let shape = match entry.shape {
            ColliderShape::Sphere { radius } => Shape::Sphere { radius: radius as f32 },
            ColliderShape::Capsule { half_height, radius } => {
                Shape::Capsule { half_height: half_height as f32, radius: radius as f32 }
            }
            ColliderShape::TaperedCapsule { half_height, radii } => {
                Shape::TaperedCapsule { half_height: half_height as f32, radii: radii.map(|r| r as f32) }
            }
            ColliderShape::Box { half } => Shape::Box { half: float(half) },
            ColliderShape::Ellipsoid { radii } => Shape::Ellipsoid { radii: float(radii), closest: true },
            _ => return None,
        };
        let rotation = entry.rotation.map(|x| x as f32);
        let collider = Collider { rotation, friction: FRICTION, ..Collider::new(shape, float(entry.position)) };
        Some(BodyCollider { joint: entry.joint.clone(), collider })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_of_a_manifest_become_colliders() {
        let text = r#"[{"joint": "hips", "shape": {"capsule": {"half_height": 0.2, "radius": 0.1}}, "position": [1, 2, 3],
                        "rotation": [0, 0, 0.6, 0.8]},
                       {"shape": {"cone": {"radius": 1}}, "position": [0, 0, 0], "rotation": [0, 0, 0, 1]},
                       {"shape": {"ellipsoid": {"radii": [1, 2, 3]}}, "position": [0, 0, 0], "rotation": [0, 0, 0, 1]}]"#;
        let mut bundle = Bundle::new("a test");
        bundle.manifest.colliders = serde_json::from_str(text).unwrap();
        let found = BodyCollider::of_bundle(&bundle);
        assert_eq!((found.len(), found[0].joint.as_deref(), &found[1].joint), (2, Some("hips"), &None));
        let Collider { shape, center, rotation, friction, .. } = found[0].collider;
        assert_eq!(shape, Shape::Capsule { half_height: 0.2, radius: 0.1 });
        assert_eq!((center, rotation, friction), ([1.0, 2.0, 3.0], [0.0, 0.0, 0.6, 0.8], FRICTION));
        // A known shape must be whole.
        for shape in [r#"{"sphere": {"radius": "NaN"}}"#, r#"{"box": {"halves": [1, 1, 1]}}"#, "5"] {
            let text = format!(r#"[{{"shape": {shape}, "position": [0, 0, 0], "rotation": [0, 0, 0, 1]}}]"#);
            assert!(serde_json::from_str::<Vec<ColliderEntry>>(&text).is_err(), "{shape}");
        }
        assert_eq!(found[1].collider.shape, Shape::Ellipsoid { radii: [1.0, 2.0, 3.0], closest: true });
    }
}
