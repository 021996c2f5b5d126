//! OUT.timings.json: how long a build took. It lies beside the bundle, whose own bytes do not depend on time.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use gimage::report::StageTime;
use gimage_bundle::manifest::{MANIFEST_FILE, MAX_MANIFEST_BYTES};
use gimage_bundle::sha256;
use serde::{Deserialize, Serialize};

use crate::exit::Failure;
use crate::files::{Pending, check_file_target};

const FORMAT: &str = "gimage-timings";
const MAX_BYTES: u64 = 1 << 20;

/// One stage of a build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Its name.
    pub stage: String,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Largest memory of the process so far \[bytes\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_bytes: Option<u64>,
}

impl From<&StageTime> for Stage {
    fn from(time: &StageTime) -> Self {
        Stage { stage: time.stage.name().into(), seconds: time.seconds, peak_bytes: time.peak_bytes }
    }
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    format: String,
    /// SHA-256 of the manifest of the bundle that these are the times of.
    manifest_sha256: String,
    /// The stages in order.
    pub stages: Vec<Stage>,
    /// Wall time of everything \[s\].
    pub seconds: f64,
    /// Largest memory of the process \[bytes\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_bytes: Option<u64>,
    /// Threads used.
    pub threads: usize,
}

/// `shirt.timings.json` for `shirt.gim`.
pub fn path_for(bundle: &Path) -> PathBuf {
    let name = bundle.file_name().unwrap_or_default().to_string_lossy();
    bundle.with_file_name(format!("{}.timings.json", name.strip_suffix(".gim").unwrap_or(&name)))
}

/// Whether times could be written for a bundle. Older times may always be replaced, another file never.
pub fn check_target(bundle: &Path) -> Result<(), Failure> {
    let path = path_for(bundle);
    check_file_target(&path, load(&path).is_some())
}

impl Timings {
    /// The times of the bundle with this manifest, whose build began at `start`.
    pub fn new(manifest: &[u8], stages: Vec<Stage>, start: Instant, threads: usize) -> Self {
        let (seconds, peak_bytes) = (start.elapsed().as_secs_f64(), gimage::report::peak_memory());
        Timings { format: FORMAT.into(), manifest_sha256: sha256(manifest), stages, seconds, peak_bytes, threads }
    }

    /// Writes them beside the bundle, to be committed.
    pub fn write(&self, bundle: &Path) -> Result<Pending, Failure> {
        let mut bytes = serde_json::to_vec_pretty(self).map_err(|e| gimage::Error::Internal(e.to_string()))?;
        bytes.push(b'\n');
        Pending::write(&path_for(bundle), &bytes)
    }

    /// The times of a bundle, if they lie beside it and are of this very bundle.
    pub fn of_bundle(bundle: &Path) -> Option<Self> {
        let timings = load(&path_for(bundle))?;
        let path = bundle.join(MANIFEST_FILE);
        if fs::metadata(&path).ok()?.len() > MAX_MANIFEST_BYTES {
            return None;
        }
        let manifest = fs::read(path).ok()?;
        (timings.manifest_sha256 == sha256(&manifest)).then_some(timings)
    }
}

fn load(path: &Path) -> Option<Timings> {
    if !fs::metadata(path).ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    fs::File::open(path).ok()?.take(MAX_BYTES).read_to_end(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok().filter(|t: &Timings| t.format == FORMAT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_lie_beside_the_bundle() {
        assert_eq!(path_for(Path::new("a/shirt.gim")), Path::new("a/shirt.timings.json"));
        assert_eq!(path_for(Path::new("shirt.v2")), Path::new("shirt.v2.timings.json"));
    }
}
