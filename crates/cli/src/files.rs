//! Single files, written as a whole or not at all.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use gimage_bundle::dir::{Staged, check_beside};

use crate::exit::Failure;

/// A file that waits under another name beside its target, and goes away with this value unless it is committed.
#[derive(Debug)]
pub struct Pending(Staged);

impl Pending {
    /// Writes the bytes beside `target`.
    pub fn write(target: &Path, bytes: &[u8]) -> Result<Self, Failure> {
        Ok(Pending(Staged::write_file(bytes, target)?))
    }

    /// Puts the file in its place.
    pub fn commit(self) -> Result<(), Failure> {
        Ok(self.0.commit()?)
    }
}

/// Whether a file could be written at `path`: ask before the work is done.
pub fn check_file_target(path: &Path, force: bool) -> Result<(), Failure> {
    check_parent(path)?;
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        // A name that is too long, a folder that may not be searched, ...
        Err(error) => return Err(Failure::io(path, &error)),
        Ok(found) if found.is_dir() => {
            return Err(Failure::refused(format!("{}: it is a directory; choose another name", path.display())));
        }
        Ok(_) if !force => return Err(Failure::from(gimage_bundle::Error::Exists { path: path.into() })),
        Ok(_) => {}
    }
    Ok(check_beside(path)?)
}

/// Whether the directory that shall hold `path` is there.
pub fn check_parent(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match fs::metadata(parent) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(Failure::refused(format!("{}: not a directory; choose another output", parent.display()))),
        Err(e) => Err(Failure::refused(format!("{}: {e}; make the directory first", parent.display()))),
    }
}
