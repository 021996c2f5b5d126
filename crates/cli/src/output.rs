//! The only place that writes to stdout and stderr: data to the one, words to the other.

use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;
use serde_json::{Value, json};

use crate::exit::{Exit, Failure};

/// Whether the JSON object of the run is on stdout. A later failure is reported on stderr and by the exit code.
static REPORTED: AtomicBool = AtomicBool::new(false);

/// Where a run writes, and how much.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Nothing on stderr but errors.
    pub quiet: bool,
    /// Notes too.
    pub verbose: bool,
    /// Data as JSON.
    pub json: bool,
    colour_out: bool,
    colour_err: bool,
}

/// How a word on stderr is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Red.
    Error,
    /// Yellow.
    Warning,
    /// Cyan.
    Note,
    /// Bold.
    Heading,
}

impl Output {
    /// Looks at the terminal and at `NO_COLOR`.
    pub fn new(quiet: bool, verbose: bool, json: bool) -> Self {
        let set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        let colour = !set("NO_COLOR") && !dumb;
        let colour_out = colour && !json && stdout().is_terminal();
        Output { quiet, verbose, json, colour_out, colour_err: colour && stderr().is_terminal() }
    }

    /// Whether to show progress bars.
    pub fn bars(&self) -> bool {
        !self.quiet && stderr().is_terminal()
    }

    /// A heading within data.
    pub fn heading(&self, text: &str) -> String {
        paint(self.colour_out, Tone::Heading, text)
    }

    /// Data for stdout. A reader that closed the pipe is not an error.
    pub fn data(&self, text: &str) -> Result<(), Failure> {
        let mut out = stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::io(Path::new("stdout"), &error)),
            _ => Ok(()),
        }
    }

    /// One JSON object on stdout.
    pub fn json(&self, value: &impl Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(value).map_err(|e| gimage::Error::Internal(e.to_string()))?;
        REPORTED.store(true, Ordering::Relaxed);
        self.data(&(text + "\n"))
    }

    /// A line on stderr, unless quiet.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            let _ = writeln!(stderr().lock(), "{}", plain(text));
        }
    }

    /// `label: text` on stderr, unless quiet.
    pub fn remark(&self, tone: Tone, label: &str, text: &str) {
        if !self.quiet {
            self.labelled(tone, label, text);
        }
    }

    /// `error: text` on stderr, always.
    pub fn error(&self, text: &str) {
        self.labelled(Tone::Error, "error", text);
    }

    /// A failure as words, and as data where data is JSON.
    pub fn failure(&self, failure: &Failure) -> Exit {
        self.error(&failure.message);
        if let Some(document) = self.document(failure) {
            // Nothing is left to be done if this fails too.
            let _ = self.json(&document);
        }
        failure.exit
    }

    /// The JSON object of a failure, unless stdout has one.
    fn document(&self, failure: &Failure) -> Option<Value> {
        let due = self.json && !REPORTED.load(Ordering::Relaxed);
        due.then(|| json!({"error": failure.message, "exit": failure.exit.code()}))
    }

    fn labelled(&self, tone: Tone, label: &str, text: &str) {
        let label = paint(self.colour_err, tone, &format!("{label}:"));
        let _ = writeln!(stderr().lock(), "{label} {}", plain(text));
    }
}

fn paint(colour: bool, tone: Tone, text: &str) -> String {
    let code = match tone {
        Tone::Error => "1;31",
        Tone::Warning => "1;33",
        Tone::Note => "36",
        Tone::Heading => "1",
    };
    if colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
}

/// The text without control characters: names come from files, and could steer the terminal.
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A build whose rename fails has sent its report.
    #[test]
    fn stdout_has_one_json_object() {
        let (out, failure) = (Output::new(true, false, true), Failure::refused("no place"));
        assert_eq!(out.document(&failure), Some(json!({"error": "no place", "exit": failure.exit.code()})));
        out.json(&json!({"exit": 0})).unwrap();
        assert_eq!(out.document(&failure), None);
    }
}
