//! Single files, written as a whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::exit::Failure;

/// A file that waits under another name beside its target, and goes away with this value unless it is committed.
#[derive(Debug)]
pub struct Pending {
    temporary: PathBuf,
    target: PathBuf,
}

impl Pending {
    /// Writes the bytes beside `target`.
    pub fn write(target: &Path, bytes: &[u8]) -> Result<Self, Failure> {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let temporary = target.with_file_name(format!(".{name}.tmp-{}", std::process::id()));
        let pending = Pending { temporary, target: target.into() };
        fs::write(&pending.temporary, bytes).map_err(|e| Failure::io(target, &e))?;
        Ok(pending)
    }

    /// Puts the file in its place.
    pub fn commit(self) -> Result<(), Failure> {
        fs::rename(&self.temporary, &self.target).map_err(|e| Failure::io(&self.target, &e))
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        // After a commit there is nothing here any more.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Whether a file could be written at `path`: ask before the work is done.
pub fn check_file_target(path: &Path, force: bool) -> Result<(), Failure> {
    check_parent(path)?;
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(found) if found.is_dir() => {
            Err(Failure::refused(format!("{}: it is a directory; choose another name", path.display())))
        }
        Ok(_) if !force => Err(Failure::from(gimage_bundle::Error::Exists { path: path.into() })),
        Ok(_) => Ok(()),
    }
}

/// Whether the directory that shall hold `path` is there.
pub fn check_parent(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match fs::metadata(parent) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(Failure::refused(format!("{}: no directory; choose another output", parent.display()))),
        Err(e) => Err(Failure::refused(format!("{}: {e}; make the directory first", parent.display()))),
    }
}
