//! manifest.json: the contents of a bundle, their source and their quality.
//!
//! Every map is ordered and every struct has a fixed order of fields, so that equal manifests are equal bytes. Unknown
//! fields are ignored on reading. Everything optional is left out where there is nothing to say, never `null`.

mod body;
mod collider;
mod piece;
mod quality;
mod render;
mod text;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use body::BodyEntry;
pub use collider::{ColliderEntry, ColliderShape, MAX_COLLIDER_SIZE_M, UnknownShape};
pub use piece::{ComponentEntry, Constants, Counts, Cut, PieceEntry, RungEntry, ShellEntry, Surface};
pub use quality::Quality;
pub use render::RenderEntry;
pub(crate) use text::{unreadable, within_cap};

/// The value of `format`.
pub const FORMAT: &str = "gimage-bundle";
/// The version of the format that this crate writes, and the only one it reads.
pub const VERSION: u32 = 1;
/// The name of the manifest's file.
pub const MANIFEST_FILE: &str = "manifest.json";
/// Most bytes of a manifest: 64 MiB.
pub const MAX_MANIFEST_BYTES: u64 = 64 << 20;

/// The contents of manifest.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always [`FORMAT`].
    pub format: String,
    /// Always [`VERSION`].
    pub version: u32,
    /// Program and version that made the bundle.
    pub generator: String,
    /// Unit of length; always `metre`.
    pub units: String,
    /// The file the bundle was made from.
    #[serde(default)]
    pub source: Source,
    /// Every option used, by its name.
    #[serde(default)]
    pub options: BTreeMap<String, Value>,
    /// The pieces, in the order of their particle indices.
    pub pieces: Vec<PieceEntry>,
    /// Surfaces that were split into several pieces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<ComponentEntry>,
    /// Components that are too small to be cloth, which ride on a piece.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub accessories: Vec<Accessory>,
    /// Solids in place of the body that the cloth is worn on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colliders: Vec<ColliderEntry>,
    /// The surface of that body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyEntry>,
    /// The skeleton that joint indices refer to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<Skeleton>,
    /// The mesh of the source, bound to the pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub render: Option<RenderEntry>,
    /// Changes to the source and other findings of the build.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repairs: Vec<Repair>,
    /// Quality of the whole bundle.
    #[serde(default, skip_serializing_if = "Quality::is_empty")]
    pub quality: Quality,
    /// Every file of the bundle but the manifest, by name. Filled in on encoding.
    #[serde(default)]
    pub files: BTreeMap<String, FileRecord>,
}

/// The file a bundle was made from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Source {
    /// Its name, without directories.
    pub file: String,
    /// Its SHA-256, 64 lower-case hexadecimal digits.
    pub sha256: String,
    /// Copyright lines and extra texts found in it, which travel with the bundle.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extras: Vec<String>,
}

/// A component that rides on a piece.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Accessory {
    /// Its name.
    pub name: String,
    /// Triangles.
    pub triangles: u32,
    /// Area \[m^2\].
    pub area: f64,
    /// Index of the piece it rides on.
    pub piece: u32,
    /// Anchor on the piece's grid, 0 to 1.
    pub u: f64,
    /// Anchor on the piece's grid, 0 to 1.
    pub v: f64,
    /// Distance \[m\] of its centre from the anchor along the normal.
    pub normal_offset: f64,
    /// Its centre at rest \[m\].
    pub center: [f64; 3],
    /// Why it is not a piece.
    pub reason: String,
}

/// The skeleton that joint indices refer to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Skeleton {
    /// The joints, in the order of their indices.
    pub joints: Vec<Joint>,
}

/// One joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Index of its parent among the joints; none for a root.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<u32>,
    /// Inverse bind matrix, column by column as in glTF, lengths in metres.
    pub inverse_bind: [f32; 16],
}

/// One change or observation of a stage.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Repair {
    /// `note`, `repair` or `warning`.
    pub severity: String,
    /// The stage by name.
    pub stage: String,
    /// The kind of thing, a fixed kebab-case name.
    pub kind: String,
    /// How often.
    pub count: u64,
    /// A few places, as words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub examples: Vec<String>,
    /// One sentence for people.
    pub message: String,
}

/// Length and checksum of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// SHA-256, 64 lower-case hexadecimal digits.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
}

impl Manifest {
    /// A manifest of this version without pieces.
    pub fn new(generator: &str) -> Self {
        Manifest {
            format: FORMAT.into(),
            version: VERSION,
            generator: generator.into(),
            units: "metre".into(),
            source: Source::default(),
            options: BTreeMap::new(),
            pieces: Vec::new(),
            components: Vec::new(),
            accessories: Vec::new(),
            colliders: Vec::new(),
            body: None,
            skeleton: None,
            render: None,
            repairs: Vec::new(),
            quality: Quality::default(),
            files: BTreeMap::new(),
        }
    }

    /// Particle slots (texels) in the bundle: the end of the last piece's range. Saturates.
    pub fn texels(&self) -> u32 {
        self.pieces.last().map_or(0, |p| p.first_particle.saturating_add(p.width.saturating_mul(p.height)))
    }
}

#[cfg(test)]
#[path = "manifest_tests.rs"]
mod tests;
