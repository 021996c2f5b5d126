//! The whole build: file -> bundle.

use std::path::Path;

use gimage_bundle::Bundle;

use crate::error::Result;
use crate::options::BuildOptions;
use crate::progress::Progress;
use crate::report::Report;

/// A finished build, not yet written.
#[derive(Clone, Debug)]
pub struct Built {
    /// The bundle in memory; write it with [`gimage_bundle::dir::write_dir`].
    pub bundle: Bundle,
    /// What was done.
    pub report: Report,
}

/// Builds a bundle from a garment file.
pub fn build(path: &Path, options: &BuildOptions, progress: &dyn Progress) -> Result<Built> {
    let _ = (path, progress);
    options.check()?;
    todo!()
}
