//! A test that cannot run prints the reason where `cargo test` shows it.

use std::collections::BTreeSet;
use std::io::Write;
use std::sync::{Mutex, PoisonError};

/// Writes the line `skipped: TEST: REASON` to stderr, once for each test and reason. `.ci/run` counts these lines.
///
/// The harness keeps what a passing test prints with `eprintln!`, but not what is written to the stream itself.
pub fn skip(reason: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let thread = std::thread::current();
    // The harness names the thread of a test after it.
    let line = format!("skipped: {}: {reason}\n", thread.name().unwrap_or("a test"));
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(line.clone()) {
        // Nothing is left to be done if this fails.
        let _ = std::io::stderr().write_all(line.as_bytes());
    }
}
