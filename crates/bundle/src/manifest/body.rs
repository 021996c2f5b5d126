//! The entry of the surface of a body.

use serde::{Deserialize, Serialize};

/// The lists of the body's surface, which are images of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BodyEntry {
    /// Vertices.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
    /// Sets of four joints per vertex, with as many weights; 0 for a body that rests.
    #[serde(default)]
    pub sets: u32,
}
