//! manifest.json: the contents of a bundle, their source and their quality.
//!
//! Every map is ordered and every struct has a fixed order of fields, so that equal manifests are equal bytes. Unknown
//! fields are ignored on reading. Everything optional is left out where there is nothing to say, never `null`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::budget;
use crate::error::{Error, Result};
use crate::map::{check_file_name, check_size};

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
    /// Reserved: collision shapes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colliders: Vec<Value>,
    /// The skeleton that joint indices refer to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<Skeleton>,
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

/// One piece: one connected surface on one grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PieceEntry {
    /// Its original name; file names are derived from it.
    pub name: String,
    /// Texels in a row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Bundle-wide index of texel (0, 0).
    pub first_particle: u32,
    /// File of each map, by the map's name. Filled in on encoding.
    pub maps: BTreeMap<String, String>,
    /// Values that are the same at every particle.
    #[serde(default)]
    pub constants: Constants,
    /// Counts of the contents of the images.
    #[serde(default)]
    pub counts: Counts,
    /// How well the piece matches the source.
    #[serde(default, skip_serializing_if = "Quality::is_empty")]
    pub quality: Quality,
    /// The cut that made the surface a disk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// The surface before it was cut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// All attempts in order, if the first image did not pass; else empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<RungEntry>,
    /// Index of the component that it is a part of, if one was split into several pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part_of: Option<u32>,
}

/// One attempt to make the image of a piece, and its result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RungEntry {
    /// How the attempt differs: `first`, `whole-mesh`, `next-cut`, ...
    pub rung: String,
    /// A lower bound of its PSNR \[dB\]; none if the attempt gave no image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Its image is the one in the bundle.
    pub kept: bool,
}

/// A connected surface that several pieces are the parts of; seam rings lead from piece to piece.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ComponentEntry {
    /// Its name.
    pub name: String,
    /// The surface that its pieces weld to.
    pub surface: Surface,
}

/// Values that are the same at every particle of a piece and so need no image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// Rest lengths \[m\] right, down, down-right, up-right, in place of a rest map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<[f32; 4]>,
    /// Particle mass \[kg\], in place of a mass map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
    /// Area density \[kg/m^2\] that the masses were made from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Total area \[m^2\] that the masses were made from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
}

/// Counts of the contents of the images of a piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counts {
    /// Texels with a particle.
    pub particles: u32,
    /// Texels that lie on a seam.
    pub seam_texels: u32,
    /// Points of the seams: rings whose lowest index is in this piece.
    pub seam_points: u32,
    /// Members of the largest of those rings, 0 without seams.
    pub largest_ring: u32,
    /// Pinned texels.
    pub pinned: u32,
    /// Springs: rest lengths above 0.
    pub springs: u32,
}

/// The cut that made a piece a disk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Cut {
    /// Length \[m\].
    pub length: f64,
    /// Edges of the source mesh.
    pub edges: u32,
    /// How it was chosen.
    pub method: String,
    /// Distortion of a stand-in cut as short as can be, and as it is cut: means of ln(symmetric Dirichlet density / 4), 0
    /// for an isometry. Their difference is what the longer cut bought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion_shortest: Option<f64>,
    /// The second of these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion: Option<f64>,
}

/// The surface of a piece before it was cut.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Surface {
    /// Euler number: vertices - edges + faces.
    pub euler: i32,
    /// Boundary loops.
    pub loops: u32,
    /// Area \[m^2\].
    pub area: f64,
    /// Triangles.
    pub triangles: u32,
}

/// Quality measured, of a piece or of the bundle. Figures that were not measured are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// 20 log10(diagonal / rms) \[dB\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Larger of the two one-sided root-mean-square distances \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// `rms` / `diagonal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_rel: Option<f64>,
    /// Largest distance either way \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hausdorff: Option<f64>,
    /// `hausdorff` / `diagonal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hausdorff_rel: Option<f64>,
    /// Diagonal of the source's bounding box \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagonal: Option<f64>,
    /// Mean angle between normals of source and reconstruction \[degrees\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_degrees: Option<f64>,
    /// L2 stretch of the map (1 = isometric).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch_l2: Option<f64>,
    /// Largest stretch of the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch_max: Option<f64>,
    /// Mean symmetric Dirichlet energy at its best scale (4 = isometric).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub symmetric_dirichlet: Option<f64>,
    /// Source triangles that the map turns over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flips: Option<u64>,
    /// Share of the reconstructed area that faces the wrong way, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fold_area: Option<f64>,
    /// Largest distance between duplicates \[m\]; 0 in a sound bundle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam_gap: Option<f64>,
    /// Ratio of the longest to the shortest rest length of springs of one kind, averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring_anisotropy: Option<f64>,
    /// Any further measure, by name.
    #[serde(flatten)]
    pub more: BTreeMap<String, Value>,
}

impl Quality {
    /// Whether no figure was measured.
    pub fn is_empty(&self) -> bool {
        *self == Quality::default()
    }
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
            skeleton: None,
            repairs: Vec::new(),
            quality: Quality::default(),
            files: BTreeMap::new(),
        }
    }

    /// Particle slots (texels) in the bundle: the end of the last piece's range. Saturates.
    pub fn texels(&self) -> u32 {
        self.pieces.last().map_or(0, |p| p.first_particle.saturating_add(p.width.saturating_mul(p.height)))
    }

    /// The manifest as JSON text, ending in a newline. Errors where [`Manifest::check`] does and on numbers that are
    /// not finite, which JSON would silently turn into `null`.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        self.check()?;
        if let Some(field) = self.not_finite() {
            return Err(Error::NotFinite { field });
        }
        let mut bytes = serde_json::to_vec_pretty(self).map_err(|e| unreadable(e.to_string()))?;
        bytes.push(b'\n');
        // What could not be read back is not written.
        budget::check_manifest(&bytes)?;
        Ok(bytes)
    }

    /// Reads a manifest and [checks](Manifest::check) it, after its lists and values are found to be within their limits
    /// ([`crate::MAX_MANIFEST_VALUES`] and others), before anything is allocated for them. The version is judged before anything else, so that a newer
    /// bundle is reported as newer and not as damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        #[derive(Deserialize)]
        struct Probe {
            #[serde(default)]
            format: Value,
            #[serde(default)]
            version: Value,
        }
        budget::check_manifest(bytes)?;
        let probe: Probe = serde_json::from_slice(bytes).map_err(|e| unreadable(e.to_string()))?;
        if probe.format != FORMAT {
            return Err(unreadable(format!("format is {}, not \"{FORMAT}\"", short(&probe.format))));
        }
        if probe.version != VERSION {
            return Err(Error::Version { found: short(&probe.version), known: VERSION });
        }
        let manifest: Manifest = serde_json::from_slice(bytes).map_err(|e| unreadable(e.to_string()))?;
        manifest.check()?;
        Ok(manifest)
    }

    /// Whether the manifest is consistent in itself: format and version, units, image sizes, consecutive particle
    /// ranges within the limit, safe file names each used once, parents of joints.
    pub fn check(&self) -> Result<()> {
        if self.format != FORMAT {
            return Err(unreadable(format!("format is {:?}, not {FORMAT:?}", self.format)));
        }
        if self.version != VERSION {
            return Err(Error::Version { found: self.version.to_string(), known: VERSION });
        }
        if self.units != "metre" {
            return Err(wrong(format!("units are {:?}, not \"metre\"", self.units)));
        }
        budget::check_lists(self)?;
        let mut files = std::collections::BTreeSet::new();
        let mut next = 0_u64;
        for piece in &self.pieces {
            check_size(&format!("piece {}", piece.name), piece.width, piece.height)?;
            if u64::from(piece.first_particle) != next {
                let found = piece.first_particle;
                return Err(wrong(format!("piece {}: first_particle is {found}, not {next}", piece.name)));
            }
            next += u64::from(piece.width) * u64::from(piece.height);
            if next > u64::from(crate::MAX_PARTICLES) {
                return Err(Error::TooLarge {
                    what: "all pieces together, in texels".into(),
                    need: next,
                    limit: u64::from(crate::MAX_PARTICLES),
                    hint: "use fewer texels, or several bundles",
                });
            }
            for name in piece.maps.values() {
                check_file_name(name)?;
                if !files.insert(name.to_ascii_lowercase()) {
                    return Err(wrong(format!("piece {}: file {name:?} is used twice", piece.name)));
                }
            }
        }
        for piece in &self.pieces {
            if piece.part_of.is_some_and(|c| c as usize >= self.components.len()) {
                return Err(wrong(format!("piece {}: part_of names no component", piece.name)));
            }
        }
        let joints = self.skeleton.as_ref().map_or(&[][..], |s| &s.joints);
        for (index, joint) in joints.iter().enumerate() {
            if joint.parent.is_some_and(|p| p as usize >= joints.len() || p as usize == index) {
                return Err(wrong(format!("joint {}: its parent is not another joint", joint.name)));
            }
        }
        Ok(())
    }

    /// The path of the first number that is not finite, if there is one. A `null` that was put into `options` on
    /// purpose does not count.
    pub fn not_finite(&self) -> Option<String> {
        let mut rest = self.clone();
        // An option without a value is legal, and a `Value` cannot hold a number that is not finite.
        rest.options.clear();
        match serde_json::to_value(&rest) {
            Ok(value) => find_null(&value, &mut String::new()),
            Err(e) => Some(e.to_string()),
        }
    }
}

fn find_null(value: &Value, path: &mut String) -> Option<String> {
    let length = path.len();
    let mut inside = |step: String, child: &Value| {
        path.push_str(&step);
        let found = find_null(child, path);
        path.truncate(length);
        found
    };
    match value {
        Value::Null => Some(path.trim_start_matches('.').to_string()),
        Value::Array(items) => items.iter().enumerate().find_map(|(k, v)| inside(format!("[{k}]"), v)),
        Value::Object(fields) => fields.iter().find_map(|(k, v)| inside(format!(".{k}"), v)),
        _ => None,
    }
}

pub(crate) fn within_cap(bytes: u64) -> Result<()> {
    if bytes <= MAX_MANIFEST_BYTES {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: "manifest.json, in bytes".into(),
        need: bytes,
        limit: MAX_MANIFEST_BYTES,
        hint: "gimage did not write this manifest; build the bundle again",
    })
}

pub(crate) fn unreadable(problem: String) -> Error {
    Error::Manifest { problem, hint: "this is not a readable gimage bundle; build it again" }
}

fn wrong(problem: String) -> Error {
    Error::Manifest { problem, hint: "build the bundle again" }
}

/// A value in a message, without letting a crafted one fill the screen.
fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
#[path = "manifest_tests.rs"]
mod tests;
