//! The entry of `render.glb`.

use serde::{Deserialize, Serialize};

/// The mesh of the source with its materials, whose vertices are bound to the pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RenderEntry {
    /// The file, always `render.glb`.
    pub file: String,
    /// Vertices of the scene, those of a mesh counted for each node that places it.
    #[serde(default)]
    pub vertices: u64,
    /// Those of them that are bound to a piece.
    #[serde(default)]
    pub bound: u64,
    /// The largest distance \[m\] of a bound vertex from its point on the surface, accessories that ride rigidly not counted.
    #[serde(default)]
    pub largest_offset: f64,
    /// Takes a position in the world of the file to the space of the bundle: unit, up axis and centring. Column by column.
    pub transform: [f64; 16],
}
