//! Putting a finished file or directory in its place, so that the place holds the old one or the new one at every moment.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use super::scratch::Scratch;

/// Whether the system swapped two paths in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Swap {
    // Elsewhere no system can.
    #[cfg_attr(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")), allow(dead_code))]
    Done,
    /// The system or the file system cannot.
    Unsupported,
}

/// Puts `new`, which lies in `scratch`, at `target`. An existing `target` is swapped with it, or steps aside into `scratch`
/// where the system cannot swap: a process that dies between these two renames leaves `target` missing, and the next reader
/// or writer puts it back ([`super::scratch`]). Errors leave `target` as it was.
pub(super) fn replace(scratch: &Scratch, new: &Path, target: &Path) -> crate::Result<()> {
    replace_by(exchange, scratch, new, target)
}

/// As [`replace`], swapping with `swap`.
pub(super) fn replace_by(
    swap: impl Fn(&Path, &Path) -> io::Result<Swap>,
    scratch: &Scratch,
    new: &Path,
    target: &Path,
) -> crate::Result<()> {
    let io = |source| crate::Error::Io { path: target.into(), source };
    if fs::symlink_metadata(target).is_err() {
        fs::rename(new, target).map_err(io)?;
    } else if swap(new, target).map_err(io)? == Swap::Unsupported {
        let old = scratch.aside(target)?;
        fs::rename(target, &old).map_err(io)?;
        if let Err(source) = fs::rename(new, target) {
            // Should this fail too, the scratch directory keeps the old one until it can be put back.
            let _ = fs::rename(&old, target);
            return Err(io(source));
        }
    }
    // The target is whole by now, and an error would say otherwise; only its name may not be on the disk yet.
    let _ = sync_folder(target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")));
    Ok(())
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(a: &Path, b: &Path) -> io::Result<Swap> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(Swap::Done),
        // Kernels before 3.15, and file systems without it, such as NFS and some of FUSE.
        Err(Errno::NOSYS | Errno::INVAL | Errno::OPNOTSUPP) => Ok(Swap::Unsupported),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<Swap> {
    Ok(Swap::Unsupported)
}

/// Writes a file and waits until its bytes are on the disk.
pub(super) fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    io::Write::write_all(&mut file, bytes)?;
    file.sync_all()
}

/// Waits until the names in a folder are on the disk, where the system can say: Windows opens no folders, and some file
/// systems sync none.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder)?.sync_all() {
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Ok(()),
        result => result,
    }
}
