//! The manifest as JSON text, written and read with distrust.

use serde::Deserialize;
use serde_json::Value;

use super::{FORMAT, MAX_MANIFEST_BYTES, Manifest, VERSION};
use crate::budget;
use crate::error::{Error, Result};
use crate::map::{check_file_name, check_size};
use crate::render::RENDER_FILE;

impl Manifest {
    /// The manifest as JSON text, ending in a newline. Errors where [`Manifest::check`] does and on numbers that are
    /// not finite, which JSON would silently turn into `null`.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        self.check()?;
        if let Some(field) = self.not_finite() {
            return Err(Error::NotFinite { field });
        }
        let mut bytes = serde_json::to_vec_pretty(self).map_err(|e| unreadable(e.to_string()))?;
        bytes.push(b'\n');
        // A value that cannot be read back is not written.
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
        if self.render.as_ref().is_some_and(|r| r.file != RENDER_FILE) {
            return Err(wrong(format!("render.file is not {RENDER_FILE:?}")));
        }
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
