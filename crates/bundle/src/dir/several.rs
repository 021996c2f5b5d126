//! Files that are written bit by bit, and take their places together.

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

use super::scratch::Scratch;
use crate::error::{Error, Result};

/// Files that wait in one temporary directory beside their targets, and are removed with this value unless they are committed.
/// If a process dies, the next one that writes beside it removes its leftovers.
///
/// ```
/// use std::io::Write;
/// use gimage_bundle::dir::StagedFiles;
///
/// # let folder = std::env::temp_dir().join(format!("gimage-several-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// let mut files = StagedFiles::beside(&folder.join("a.txt"))?;
/// for name in ["a.txt", "b.txt"] {
///     files.create(name)?.write_all(b"text")?;
/// }
/// assert!(!folder.join("a.txt").exists());
/// files.commit()?;
/// assert!(folder.join("a.txt").exists() && folder.join("b.txt").exists());
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct StagedFiles {
    scratch: Scratch,
    folder: PathBuf,
    names: Vec<String>,
}

impl StagedFiles {
    /// For files in the directory of `target`. Errors where that directory cannot be written.
    pub fn beside(target: &Path) -> Result<Self> {
        let folder = target.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(StagedFiles { scratch: Scratch::create(target)?, folder, names: Vec::new() })
    }

    /// An empty file that will take the place of `name` in that directory. Errors on a name that is a path, or that was given before.
    pub fn create(&mut self, name: &str) -> Result<File> {
        if Path::new(name).file_name() != Some(name.as_ref()) {
            return Err(Error::FileName { name: name.into(), problem: "is not the name of a file" });
        }
        let path = self.waiting(self.names.len());
        let file = File::create_new(path).map_err(|source| Error::Io { path: self.folder.join(name), source })?;
        self.names.push(name.into());
        Ok(file)
    }

    /// An empty file to write and read, which goes away with this value.
    pub fn temporary(&mut self) -> Result<File> {
        let path = self.scratch.join("temporary");
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(&path);
        file.map_err(|source| Error::Io { path: self.folder.clone(), source })
    }

    /// Moves all files to their targets, in the order in which they were made; files there are replaced. Each is synced first, so that
    /// every target is the old file or the new one, whole. An error leaves the targets that follow as they were.
    pub fn commit(self) -> Result<()> {
        let io = |path: PathBuf| move |source| Error::Io { path, source };
        for (k, name) in self.names.iter().enumerate() {
            let sync = File::open(self.waiting(k)).and_then(|file| file.sync_all());
            sync.map_err(io(self.folder.join(name)))?;
        }
        for (k, name) in self.names.iter().enumerate() {
            let target = self.folder.join(name);
            fs::rename(self.waiting(k), &target).map_err(io(target))?;
        }
        Ok(())
    }

    fn waiting(&self, index: usize) -> PathBuf {
        self.scratch.join(&format!("new-{index}"))
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Seek, SeekFrom, Write};

    use super::super::tests::names;
    use super::*;

    #[test]
    fn all_files_take_their_places_or_none() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("b"), "old").unwrap();
        for commits in [false, true] {
            let mut files = StagedFiles::beside(&folder.path().join("a")).unwrap();
            for name in ["a", "b"] {
                files.create(name).unwrap().write_all(b"new").unwrap();
            }
            let mut temporary = files.temporary().unwrap();
            temporary.write_all(b"xyz").unwrap();
            temporary.seek(SeekFrom::Start(1)).unwrap();
            let mut text = String::new();
            temporary.read_to_string(&mut text).unwrap();
            assert_eq!(text, "yz");
            assert_eq!(fs::read(folder.path().join("b")).unwrap(), b"old");
            if commits {
                files.commit().unwrap();
            } else {
                drop(files);
            }
            assert_eq!(names(folder.path()), if commits { vec!["a", "b"] } else { vec!["b"] });
        }
        assert_eq!(fs::read(folder.path().join("b")).unwrap(), b"new");
    }

    #[test]
    fn a_path_is_no_name_and_a_missing_directory_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut files = StagedFiles::beside(&folder.path().join("a")).unwrap();
        for name in ["", "..", "x/y", "/x", "x/"] {
            assert!(files.create(name).is_err(), "{name}");
        }
        assert!(StagedFiles::beside(&folder.path().join("no/a")).is_err());
    }
}
