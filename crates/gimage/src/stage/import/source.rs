//! All reading of files, and what a result says about the file it came from.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};

/// The file a mesh came from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// Name without folders.
    pub file_name: String,
    /// SHA-256 of the file, as 64 hexadecimal digits.
    pub sha256: String,
    /// Credits as `key: value`: copyright, author, licence, title, source, generator; for OBJ the comments at its head.
    pub extras: Vec<String>,
    /// Buffers read from files beside it.
    pub outside: Vec<OutsideFile>,
}

/// A buffer that a glTF file keeps in a file beside it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutsideFile {
    /// Path relative to the glTF file.
    pub name: String,
    /// SHA-256 of the file, as 64 hexadecimal digits.
    pub sha256: String,
}

impl Source {
    pub(crate) fn new(path: &Path, bytes: &[u8]) -> Self {
        let file_name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self { file_name, sha256: sha256(bytes), ..Self::default() }
    }
}

/// SHA-256 as hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Reads a whole file of at most `cap` bytes.
pub(crate) fn read_capped(path: &Path, cap: u64) -> Result<Vec<u8>> {
    read(path, cap).map_err(|source| match source.kind() {
        io::ErrorKind::FileTooLarge => Error::TooLarge {
            what: path.display().to_string(),
            need: source.to_string(),
            limit: format!("{cap} bytes"),
            hint: "raise max_bytes, or reduce the file".into(),
        },
        _ => Error::Io { path: path.to_path_buf(), source },
    })
}

/// Reads a file named by a relative path with `/` between folders.
pub(crate) fn read_beside(folder: &Path, name: &str, cap: u64) -> io::Result<Vec<u8>> {
    read(&name.split('/').fold(folder.to_path_buf(), |path, part| path.join(part)), cap)
}

fn read(path: &Path, cap: u64) -> io::Result<Vec<u8>> {
    // Asked before opening: a pipe without a writer waits forever, and a device may have no end.
    refuse_unless_regular(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    let meta = file.metadata()?;
    // Another file may have come in its place.
    refuse_unless_regular(&meta)?;
    if meta.len() > cap {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("{} bytes", meta.len())));
    }
    // The file may grow while it is read: the cap holds for what is read.
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    file.take(cap.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > cap {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "more bytes than that"));
    }
    Ok(bytes)
}

fn refuse_unless_regular(meta: &std::fs::Metadata) -> io::Result<()> {
    if meta.is_file() {
        return Ok(());
    }
    if meta.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory, not a file"));
    }
    let problem = "it is a pipe, a device or a socket, not a regular file; save its content to a file first";
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_pipe_or_a_device_is_refused_unread() {
        let place = tempfile::tempdir().unwrap();
        let pipe = place.path().join("pipe.obj");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = place.path().join("zero.bin");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        let refused = |result: io::Result<Vec<u8>>| {
            let error = result.unwrap_err();
            assert!(error.to_string().contains("not a regular file"), "{error}");
        };
        refused(read(&pipe, 1 << 31));
        refused(read_beside(place.path(), "pipe.obj", 1 << 31));
        refused(read_beside(place.path(), "zero.bin", 1 << 31));
        let error = read_capped(&link, 1 << 31).unwrap_err().to_string();
        assert!(error.contains("zero.bin") && error.contains("save its content"), "{error}");
        assert_eq!(read(place.path(), 9).unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }
}
