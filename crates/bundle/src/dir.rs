//! Bundles as directories: the only part that knows of a file system.

use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::bundle::Bundle;
use crate::error::{Error, Result};
use crate::manifest::{FORMAT, MANIFEST_FILE, MAX_MANIFEST_BYTES};
use crate::validate::{Fault, validate_files};

/// Writes a bundle as the directory `path`, all of it or nothing. Without `force` an existing `path` is refused; with it
/// a bundle, or an empty directory, is replaced, and anything else still refused.
pub fn write_dir(bundle: &Bundle, path: &Path, force: bool) -> Result<()> {
    check_target(path, force)?;
    write_files(&bundle.encode()?, path, force)
}

/// As [`write_dir`] for files already encoded, by name.
pub fn write_files(files: &BTreeMap<String, Vec<u8>>, path: &Path, force: bool) -> Result<()> {
    check_target(path, force)?;
    let temporary = Scratch::create(path, "tmp")?;
    for (name, bytes) in files {
        if name.contains(['/', '\\', ':']) || name.contains("..") {
            return Err(Error::FileName { name: name.clone(), problem: "points out of the bundle" });
        }
        let file = temporary.path.join(name);
        fs::write(&file, bytes).map_err(|source| Error::Io { path: file, source })?;
    }
    let io = |source| Error::Io { path: path.into(), source };
    if fs::symlink_metadata(path).is_err() {
        return fs::rename(&temporary.path, path).map_err(io);
    }
    // The old bundle steps aside into a directory that is removed on leaving, once the new one is in its place.
    let aside = Scratch::create(path, "old")?;
    let old = aside.path.join("bundle");
    fs::rename(path, &old).map_err(io)?;
    fs::rename(&temporary.path, path).map_err(|source| {
        if fs::rename(&old, path).is_err() {
            // Rather leave a stray directory than lose the old bundle.
            std::mem::forget(aside);
        }
        io(source)
    })
}

/// Whether a bundle could be written at `path`: ask before the work is done. Errors as [`write_dir`].
pub fn check_target(path: &Path, force: bool) -> Result<()> {
    let not = |problem: String| Err(Error::NotABundle { path: path.into(), problem });
    if path.file_name().is_none() {
        return not("it does not end in a name".into());
    }
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
        return not("it is no directory".into());
    }
    let mut empty = true;
    for entry in fs::read_dir(path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let ours = name == MANIFEST_FILE || name == "render.glb" || name.ends_with(".exr");
        if !ours || !entry.file_type().map_err(io)?.is_file() {
            return not(format!("it holds {name:?}, which is no part of a bundle"));
        }
        empty = false;
    }
    // A manifest.json is common in other projects too; only one that says it is ours counts. Any version does.
    let ours = || {
        let bytes = read_capped(&path.join(MANIFEST_FILE), MAX_MANIFEST_BYTES).ok()?;
        let value: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
        Some(value.get("format")? == FORMAT)
    };
    if empty || ours() == Some(true) { Ok(()) } else { not("it holds no manifest of a gimage bundle".into()) }
}

/// Reads a bundle from a directory; errors on the first thing that cannot be read, as [`Bundle::decode`].
pub fn read_dir(path: &Path) -> Result<Bundle> {
    Bundle::decode(|name, cap| read_member(path, name, cap))
}

/// Reads and validates a bundle in a directory, as [`validate_files`].
pub fn validate_dir(path: &Path) -> Result<(Bundle, Vec<Fault>)> {
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
        hint: "the file is not the one that was written; build the bundle again",
    };
    // Asked before opening, which could wait for ever on a pipe.
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

/// A new directory beside a target, on the same file system, removed with all it holds when it goes out of scope.
struct Scratch {
    path: PathBuf,
}

impl Scratch {
    fn create(target: &Path, purpose: &str) -> Result<Self> {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let mut attempt = 0_u32;
        loop {
            let path = target.with_file_name(format!(".{name}.{purpose}-{}-{attempt}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Scratch { path }),
                Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 1000 => attempt += 1,
                Err(source) => return Err(Error::Io { path, source }),
            }
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // After a successful rename there is nothing here any more.
        let _ = fs::remove_dir_all(&self.path);
    }
}

#[cfg(test)]
#[path = "dir_tests.rs"]
mod tests;
