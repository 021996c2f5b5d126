//! Bundles as directories; the only module that uses a file system.
//!
//! Whatever happens to a writer, a power cut included, a path holds the old bundle or the new one, whole: the files are
//! written and synced under a temporary name, and take the place of the old ones in one rename.

mod listed;
mod replace;
mod scratch;
mod several;

use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::bundle::Bundle;
use crate::error::{Error, Result};
use crate::manifest::{MANIFEST_FILE, MAX_MANIFEST_BYTES};
use crate::validate::{Fault, validate_files};
use listed::Listed;
use scratch::Scratch;
pub use several::StagedFiles;

/// Writes a bundle as the directory `path`, completely or not at all. Without `force` an existing `path` is refused; with it
/// a bundle, or an empty directory, is replaced, and anything else still refused: a directory with a file that its manifest
/// does not list, too.
pub fn write_dir(bundle: &Bundle, path: &Path, force: bool) -> Result<()> {
    write_files(&bundle.encode()?, path, force)
}

/// As [`write_dir`] for files already encoded, by name.
pub fn write_files(files: &BTreeMap<String, Vec<u8>>, path: &Path, force: bool) -> Result<()> {
    Staged::write(files, path, force)?.commit()
}

/// A bundle, or a file, that is written and synced beside its target, and is removed with this value unless it is committed.
/// If a process dies, the next one that writes beside it removes its leftovers.
#[derive(Debug)]
pub struct Staged {
    scratch: Scratch,
    new: PathBuf,
    target: PathBuf,
    /// Whether an existing bundle may be replaced; `None` for a file, which always may.
    force: Option<bool>,
}

impl Staged {
    /// Writes files, by name, that will become the bundle `target`. Errors as [`write_dir`].
    pub fn write(files: &BTreeMap<String, Vec<u8>>, target: &Path, force: bool) -> Result<Self> {
        check_existing(target, force)?;
        let staged = Self::beside(target, Some(force))?;
        let io = |path: &Path| {
            let path = path.to_path_buf();
            |source| Error::Io { path, source }
        };
        fs::create_dir(&staged.new).map_err(io(&staged.new))?;
        for (name, bytes) in files {
            if name.contains(['/', '\\', ':']) || name.contains("..") {
                return Err(Error::FileName { name: name.clone(), problem: "points out of the bundle" });
            }
            let file = staged.new.join(name);
            replace::write_synced(&file, bytes).map_err(io(&target.join(name)))?;
        }
        replace::sync_folder(&staged.new).map_err(io(target))?;
        Ok(staged)
    }

    /// Writes a file that will become `target` and replace any file there.
    pub fn write_file(bytes: &[u8], target: &Path) -> Result<Self> {
        let staged = Self::beside(target, None)?;
        let io = |source| Error::Io { path: target.into(), source };
        replace::write_synced(&staged.new, bytes).map_err(io)?;
        Ok(staged)
    }

    fn beside(target: &Path, force: Option<bool>) -> Result<Self> {
        let scratch = Scratch::create(target)?;
        let new = scratch.join("new");
        Ok(Staged { scratch, new, target: target.into(), force })
    }

    /// Moves it to its target. On errors the target is unchanged.
    pub fn commit(self) -> Result<()> {
        let Staged { scratch, new, target, force } = self;
        match force {
            // Again: files may have come in since.
            Some(force) => {
                check_existing(&target, force)?;
                replace::replace(&scratch, &new, &target)
            }
            None => fs::rename(&new, &target).map_err(|source| Error::Io { path: target, source }),
        }
    }
}

/// Whether a bundle could be written at `path`: ask before the work is done. Errors as [`write_dir`].
pub fn check_target(path: &Path, force: bool) -> Result<()> {
    check_existing(path, force)?;
    check_beside(path)
}

/// Whether the directory that holds `target` can be written: makes and removes a temporary directory in it, and what dead
/// processes have left there.
pub fn check_beside(target: &Path) -> Result<()> {
    Scratch::create(target).map(drop)
}

fn check_existing(path: &Path, force: bool) -> Result<()> {
    let not = |problem: String| Err(Error::NotABundle { path: path.into(), problem });
    if path.file_name().is_none() {
        return not("it does not end in a name".into());
    }
    scratch::recover(path);
    let io = |source| Error::Io { path: path.into(), source };
    let kind = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(io(source)),
        Ok(metadata) => metadata.file_type(),
    };
    if !force {
        return Err(Error::Exists { path: path.into() });
    }
    if !kind.is_dir() {
        return not("it is not a directory".into());
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !entry.file_type().map_err(io)?.is_file() {
            return not(format!("it holds {name:?}, which is not a file of a bundle"));
        }
        names.push(name);
    }
    if names.is_empty() {
        return Ok(());
    }
    // A manifest.json is common in other projects too; only one that names our format counts. Any version does.
    let manifest = read_capped(&path.join(MANIFEST_FILE), MAX_MANIFEST_BYTES).ok();
    let Some(listed) = manifest.and_then(|bytes| Listed::parse(&bytes)) else {
        return not("it holds no manifest of a gimage bundle".into());
    };
    names.sort();
    match names.iter().find(|name| !listed.has(name)) {
        Some(name) => not(format!("it holds {name:?}, which its manifest does not list")),
        None => Ok(()),
    }
}

/// Reads a bundle from a directory; errors on the first thing that cannot be read, as [`Bundle::decode`]. A bundle that
/// a killed writer left aside is put back first.
pub fn read_dir(path: &Path) -> Result<Bundle> {
    scratch::recover(path);
    Bundle::decode(|name, cap| read_member(path, name, cap))
}

/// Reads and validates a bundle in a directory, as [`validate_files`].
pub fn validate_dir(path: &Path) -> Result<(Bundle, Vec<Fault>)> {
    scratch::recover(path);
    validate_files(|name, cap| read_member(path, name, cap))
}

fn read_member(path: &Path, name: &str, cap: u64) -> Result<Vec<u8>> {
    match read_capped(&path.join(name), cap) {
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound && name != MANIFEST_FILE => {
            Err(Error::Missing { file: name.into() })
        }
        Err(Error::TooLarge { need, limit, hint, .. }) if name != MANIFEST_FILE => Err(Error::Exr {
            file: name.into(),
            problem: format!("{need} bytes, but at most {limit} fit its size"),
            hint,
        }),
        result => result,
    }
}

/// The bytes of a plain file, refused unread where there are more than `cap`.
fn read_capped(path: &Path, cap: u64) -> Result<Vec<u8>> {
    let io = |source| Error::Io { path: path.into(), source };
    let too_large = |need| Error::TooLarge {
        what: format!("{}, in bytes", path.display()),
        need,
        limit: cap,
        hint: "the file was changed after it was written; build the bundle again",
    };
    // Asked before opening, which could wait forever on a pipe.
    let metadata = fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        return Err(io(std::io::Error::new(ErrorKind::InvalidInput, "not a plain file")));
    }
    if metadata.len() > cap {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    let file = fs::File::open(path).map_err(io)?;
    file.take(cap.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > cap { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

#[cfg(test)]
#[path = "dir_tests.rs"]
mod tests;
