//! How a run ends: exit codes, failures, and panics made into failures.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;

/// The exit codes, from best to worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// 0: done.
    Done,
    /// 1: done, with findings.
    Findings,
    /// 2: could not do it.
    Refused,
    /// 3: a fault of this program.
    Internal,
}

impl Exit {
    /// The number.
    pub fn code(self) -> u8 {
        self as u8
    }
}

/// Why a command did not do its work.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// The message to print: one sentence with the place and the remedy.
    pub message: String,
    /// How to end.
    pub exit: Exit,
}

impl Failure {
    /// Exit code 2.
    pub fn refused(message: impl Into<String>) -> Self {
        Failure { message: message.into(), exit: Exit::Refused }
    }

    /// A system's error about a file.
    pub fn io(path: &Path, source: &std::io::Error) -> Self {
        Self::refused(format!("{}: {source}", path.display()))
    }

    /// An error of the library with the name of the input, which an error of a later stage does not know.
    pub fn of_input(input: &Path, error: gimage::Error) -> Self {
        let (mut failure, name) = (Self::from(error), input.display().to_string());
        if !failure.message.contains(&name) {
            failure.message = format!("{name}: {}", failure.message);
        }
        failure
    }

    /// An error of reading the bundle at `path`, which most such errors do not know.
    pub fn bundle(path: &Path, error: &gimage_bundle::Error) -> Self {
        match error {
            gimage_bundle::Error::Io { .. } => Self::refused(error.to_string()),
            _ => Self::refused(format!("{}: {error}", path.display())),
        }
    }
}

impl From<gimage::Error> for Failure {
    fn from(error: gimage::Error) -> Self {
        let exit = if matches!(error, gimage::Error::Internal(_)) { Exit::Internal } else { Exit::Refused };
        Failure { message: error.to_string(), exit }
    }
}

impl From<gimage_bundle::Error> for Failure {
    fn from(error: gimage_bundle::Error) -> Self {
        gimage::Error::from(error).into()
    }
}

impl From<gimage_runtime::Error> for Failure {
    fn from(error: gimage_runtime::Error) -> Self {
        Self::refused(error.to_string())
    }
}

static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Keeps panics from writing to stderr by themselves: some are caught and turned into proper errors further down.
pub fn hush_panics() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        let what = info.payload_as_str().unwrap_or("no message");
        if let Ok(mut last) = LAST_PANIC.lock() {
            *last = format!("{what}{place}");
        }
    }));
}

/// Runs `work`; a panic becomes a failure with exit code 3.
pub fn guard<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let what = LAST_PANIC.lock().map(|last| last.clone()).unwrap_or_default();
        let message = format!("internal error: {what}; please report it with the input");
        Err(Failure { message, exit: Exit::Internal })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_internal_error() {
        hush_panics();
        let failure = guard(|| -> Result<(), Failure> { panic!("boom {}", 7) }).unwrap_err();
        assert_eq!(failure.exit.code(), 3);
        assert!(failure.message.contains("boom 7") && failure.message.contains("report"), "{failure}");
    }

    #[test]
    fn codes_are_ordered_by_badness() {
        assert!(Exit::Done < Exit::Findings && Exit::Findings < Exit::Refused && Exit::Refused < Exit::Internal);
        let internal: Failure = gimage::Error::Internal("x".into()).into();
        assert_eq!((internal.exit, Failure::from(gimage::Error::Cancelled).exit.code()), (Exit::Internal, 2));
    }
}
