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
            [name] if !["sphere", "capsule", "box", "ellipsoid"].contains(&name) => Ok(UnknownShape(value)),
            _ => Err(format!("{value} is not the shape of a collider")),
        }
    }
}
