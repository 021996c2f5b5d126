//! Solids in place of a body.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A solid that stands for a part of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColliderEntry {
    /// The joint that it follows, by name; none for a body without joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Its shape.
    pub shape: ColliderShape,
    /// Its centre \[m\], where the character stands as its file has it.
    pub position: [f64; 3],
    /// Its rotation there, a unit quaternion (x, y, z, w).
    pub rotation: [f64; 4],
    /// Whether it stands for a part of the body that the file leaves out beneath clothes: the surface of the body in the bundle does not have it either.
    #[serde(default, skip_serializing_if = "is_false")]
    pub guessed: bool,
}

fn is_false(x: &bool) -> bool {
    !x
}

/// A shape in its own frame, around the origin. Sizes are in metres, above 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ColliderShape {
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// All points nearer than `radius` to a segment of the y axis.
    Capsule {
        /// Half the length of the segment.
        half_height: f64,
        /// Its radius.
        radius: f64,
    },
    /// The convex hull of two balls at the ends of a segment of the y axis.
    TaperedCapsule {
        /// Half the length of the segment.
        half_height: f64,
        /// Radii of the balls at -y and at +y, which differ by less than the length of the segment.
        radii: [f64; 2],
    },
    /// A box.
    Box {
        /// Half its sides.
        half: [f64; 3],
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Its radii.
        radii: [f64; 3],
    },
    /// A shape of a later version.
    #[serde(untagged)]
    Unknown(UnknownShape),
}

/// Largest size of a collider \[m\]: squares of it are far from the largest f32.
pub const MAX_COLLIDER_SIZE_M: f64 = 1e6;

/// Largest difference of the length of a rotation from 1.
const MAX_ROTATION_ERROR: f64 = 1e-3;

impl ColliderEntry {
    /// The rule that the entry breaks, in words without its place; `None` for a sound entry and for shapes that are not known.
    pub fn fault(&self) -> Option<String> {
        let sizes = match &self.shape {
            ColliderShape::Sphere { radius } => vec![*radius],
            ColliderShape::Capsule { half_height, radius } => vec![*half_height, *radius],
            ColliderShape::TaperedCapsule { half_height, radii: [low, high] } => vec![*half_height, *low, *high],
            ColliderShape::Box { half } => half.to_vec(),
            ColliderShape::Ellipsoid { radii } => radii.to_vec(),
            ColliderShape::Unknown(_) => Vec::new(),
        };
        let sound = |size: &f64| *size > 0.0 && *size <= MAX_COLLIDER_SIZE_M;
        if let Some(size) = sizes.iter().find(|size| !sound(size)) {
            return Some(format!("the size {size} m is not above 0 and at most {MAX_COLLIDER_SIZE_M} m"));
        }
        if let ColliderShape::TaperedCapsule { half_height, radii: [low, high] } = &self.shape
            && (low - high).abs() >= 2.0 * half_height
        {
            return Some(format!(
                "the radii {low} m and {high} m differ by the length of {} m or more",
                2.0 * half_height
            ));
        }
        if let Some(x) = self.position.iter().find(|x| x.is_nan() || x.abs() > f64::from(f32::MAX)) {
            return Some(format!("the position {x} m is not a finite number of 32 bits"));
        }
        let length = self.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unit = (length - 1.0).abs() <= MAX_ROTATION_ERROR;
        (!unit).then(|| format!("the rotation is a quaternion of length {length}, not 1"))
    }
}

/// A shape that this version does not know: an object with one field of another name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Value")]
pub struct UnknownShape(Value);

impl TryFrom<Value> for UnknownShape {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let names: Vec<&str> =
            value.as_object().map_or(Vec::new(), |fields| fields.keys().map(String::as_str).collect());
        match names[..] {
            [name] if !["sphere", "capsule", "tapered_capsule", "box", "ellipsoid"].contains(&name) => {
                Ok(UnknownShape(value))
            }
            _ => Err(format!("{value} is not the shape of a collider")),
        }
    }
}
