//! Temporary directories beside a target, which no crash leaves behind forever.
//!
//! A scratch directory is named `.gimage-<pid>-<attempt>.tmp`, whatever the target is called, so that a name of full length
//! still has room for one. The process that made it holds a lock on the file `lock` in it until it ends, however it ends. A
//! scratch directory whose lock is free belongs to a dead process: the next writer beside it removes it, after putting back
//! a bundle that waits in `old`. A lock tells the living from the dead where process numbers do not: after a restart, in
//! containers, and on other machines that share the file system.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

const PREFIX: &str = ".gimage-";
const SUFFIX: &str = ".tmp";
/// The file that the owner holds locked, and what is in it: a directory without it is not ours, and stays.
const LOCK: &str = "lock";
const MARK: &[u8] = b"gimage scratch directory\n";
/// The subdirectory that keeps a target, under its own name, while another takes its place.
const OLD: &str = "old";
const MAX_ATTEMPTS: u32 = 10_000;

/// A new directory beside a target, on the same file system, removed with all it holds when it goes out of scope.
#[derive(Debug)]
pub struct Scratch {
    path: PathBuf,
    /// Held, not read: the lock ends with the process.
    #[cfg_attr(not(test), expect(dead_code))]
    lock: File,
}

impl Scratch {
    /// Makes one beside `target`, after [`sweep`]. Errors where the directory that holds `target` cannot be written.
    pub fn create(target: &Path) -> Result<Self> {
        let folder = folder_of(target);
        sweep(folder);
        for attempt in 0..MAX_ATTEMPTS {
            let path = folder.join(format!("{PREFIX}{}-{attempt}{SUFFIX}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                Err(source) => return Err(Error::Io { path: folder.into(), source }),
            }
            match lock(&path) {
                Ok(Some(lock)) => return Ok(Scratch { path, lock }),
                // Another writer swept it away before it was locked.
                Ok(None) => continue,
                Err(source) => {
                    let _ = remove(&path);
                    return Err(Error::Io { path: folder.into(), source });
                }
            }
        }
        let source = std::io::Error::new(ErrorKind::AlreadyExists, "every name for a temporary directory is taken");
        Err(Error::Io { path: folder.into(), source })
    }

    /// Leaves everything, and no lock, as a process does that is killed.
    #[cfg(test)]
    pub(super) fn die(self) -> PathBuf {
        let path = self.path.clone();
        self.lock.unlock().unwrap();
        std::mem::forget(self);
        path
    }

    /// A path in it; nothing is made.
    pub fn join(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Where `target` can step aside: the next writer puts it back from there if this process dies before `target`
    /// exists again.
    pub fn aside(&self, target: &Path) -> Result<PathBuf> {
        let folder = self.path.join(OLD);
        fs::create_dir_all(&folder).map_err(|source| Error::Io { path: folder.clone(), source })?;
        Ok(folder.join(target.file_name().unwrap_or_default()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = clear(&self.path);
    }
}

/// Removes the scratch directories of dead processes from `folder`, after putting back what waits in them. Directories of
/// live processes, and anything else, stay; what cannot be removed stays too.
pub fn sweep(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if is_scratch(&entry.file_name()) && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            let path = entry.path();
            match dead(&path) {
                Some(lock) => {
                    let _ = clear(&path);
                    drop(lock);
                }
                // Its process died before it made the lock, or makes it just now and then tries the next name.
                None => drop(fs::remove_dir(&path)),
            }
        }
    }
}

/// Puts `target` back where it is missing because a process died while it replaced it. Cheap where it is there.
pub(super) fn recover(target: &Path) {
    let missing = |path: &Path| fs::symlink_metadata(path).is_err_and(|e| e.kind() == ErrorKind::NotFound);
    if target.file_name().is_some() && missing(target) {
        sweep(folder_of(target));
    }
}

fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn is_scratch(name: &OsStr) -> bool {
    let Some(middle) = name.to_str().and_then(|n| n.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)) else { return false };
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    middle.split_once('-').is_some_and(|(pid, attempt)| number(pid) && number(attempt))
}

/// Makes and takes the lock of a new scratch directory; `None` if the directory was swept away meanwhile.
fn lock(path: &Path) -> std::io::Result<Option<File>> {
    let gone = |error: &std::io::Error| error.kind() == ErrorKind::NotFound;
    let file = path.join(LOCK);
    let mut lock = match File::create_new(&file) {
        Ok(lock) => lock,
        Err(error) if gone(&error) => return Ok(None),
        Err(error) => return Err(error),
    };
    match lock.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Ok(None),
        // A file system without locks: nobody else can take it either, so nobody sweeps the directory away.
        Err(TryLockError::Error(_)) => {}
    }
    lock.write_all(MARK)?;
    match fs::metadata(&file) {
        Ok(_) => Ok(Some(lock)),
        Err(error) if gone(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The lock of a scratch directory, taken, if its process is dead.
fn dead(path: &Path) -> Option<File> {
    // A link or a pipe by this name is not ours.
    let file = path.join(LOCK);
    if !fs::symlink_metadata(&file).ok()?.is_file() {
        return None;
    }
    let mut lock = File::open(&file).ok()?;
    lock.try_lock().ok()?;
    let mut mark = [0; MARK.len()];
    // An empty one was not written to any more.
    let read = lock.read(&mut mark).ok()?;
    (read == 0 || mark == *MARK).then_some(lock)
}

/// Puts back what waits in `old`, then removes the rest.
fn clear(path: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(path.join(OLD)).into_iter().flatten().flatten() {
        let home = folder_of(path).join(entry.file_name());
        let missing = fs::symlink_metadata(&home).is_err_and(|e| e.kind() == ErrorKind::NotFound);
        if missing {
            // Without it nothing may be removed: it is the only copy.
            fs::rename(entry.path(), &home)?;
        }
    }
    remove(path)
}

/// Removes a scratch directory, its lock last: without the lock it would not be known as one.
fn remove(path: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_name() == LOCK {
            continue;
        }
        match entry.file_type()?.is_dir() {
            true => fs::remove_dir_all(entry.path())?,
            false => fs::remove_file(entry.path())?,
        }
    }
    match fs::remove_file(path.join(LOCK)) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    fs::remove_dir(path)
}

#[cfg(test)]
mod tests {
    use super::super::tests::names;
    use super::*;

    #[test]
    fn strays_of_dead_processes_go_and_those_of_live_ones_stay() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("a.gim");
        let live = Scratch::create(&target).unwrap();
        fs::write(live.join("file"), "x").unwrap();
        let stray = Scratch::create(&target).unwrap().die();
        fs::create_dir(stray.join("new")).unwrap();
        fs::write(stray.join("new/manifest.json"), "x").unwrap();
        assert_eq!(names(place.path()).len(), 2);
        sweep(place.path());
        assert_eq!(fs::read_to_string(live.join("file")).unwrap(), "x");
        assert_eq!(names(place.path()).len(), 1);
        drop(live);
        assert_eq!(names(place.path()), [""; 0]);
    }

    #[test]
    fn what_only_looks_like_a_stray_stays() {
        let place = tempfile::tempdir().unwrap();
        let mine = [".gimage-1-0.tmp", ".gimage-x-0.tmp", ".gimage-3.tmp", ".gimage-4-0"];
        for name in mine {
            fs::create_dir(place.path().join(name)).unwrap();
            fs::write(place.path().join(name).join("notes.txt"), "mine").unwrap();
        }
        fs::write(place.path().join(".gimage-1-0.tmp/lock"), "another program's lock").unwrap();
        fs::write(place.path().join(".gimage-5-0.tmp"), "a file").unwrap();
        drop(Scratch::create(&place.path().join("a.gim")).unwrap());
        assert_eq!(names(place.path()).len(), 5);
        // Without a lock there is nothing in it.
        fs::create_dir(place.path().join(".gimage-6-0.tmp")).unwrap();
        sweep(place.path());
        assert_eq!(names(place.path()).len(), 5);
    }

    #[test]
    fn a_target_that_stepped_aside_is_put_back() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("a.gim");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("manifest.json"), "old").unwrap();
        let scratch = Scratch::create(&target).unwrap();
        fs::rename(&target, scratch.aside(&target).unwrap()).unwrap();
        scratch.die();
        recover(&target);
        assert_eq!(fs::read_to_string(target.join("manifest.json")).unwrap(), "old");
        assert_eq!(names(place.path()), ["a.gim"]);
        // Where the target is there again, what waited is no longer needed.
        let scratch = Scratch::create(&target).unwrap();
        fs::create_dir(scratch.aside(&target).unwrap()).unwrap();
        scratch.die();
        sweep(place.path());
        assert_eq!(fs::read_to_string(target.join("manifest.json")).unwrap(), "old");
        assert_eq!(names(place.path()), ["a.gim"]);
    }
}
