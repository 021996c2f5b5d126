//! Comments, pages and messages speak plainly: the phrases below have cost readers time, and each has a plain wording.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A phrase in lower case, and what to write instead.
const PHRASES: [(&str, &str); 20] = [
    ("anew", "again, or rebuilt, recomputed"),
    ("as nearly as", "as close to ... as possible"),
    ("and said", "with a warning, or reports it"),
    ("and says so", "with a warning, or reports it"),
    ("and say so", "with a warning, or report it"),
    ("says so", "reports it, or states that ..."),
    ("said so", "reported it"),
    ("so many", "the number: N, at most N, enough ... that"),
    ("such as are", "that are"),
    ("thereof", "of it"),
    ("unless given", "default"),
    ("one times", "once, or multiplied by 1"),
    ("for ever", "forever, or without end"),
    ("for want of", "because there is no, or for lack of"),
    ("of no use", "unused, or useless"),
    ("of whichever", "of any"),
    ("costs no frame", "has no per-frame cost"),
    ("be no number", "be NaN, or not be finite"),
    ("or no number", "or NaN, or not finite"),
    ("what is no", "name the thing: a NaN, a mesh that is not ..."),
];

/// A verb before "no", as in "is no length": write "is not a length". "There is no" and "is no longer" are fine.
const BE: [&str; 5] = ["is", "are", "was", "were", "be"];
const FINE_AFTER_NO: &str = "better closer deeper different earlier farther faster finer greater heavier higher larger later \
    less lighter longer lower more nearer shorter slower smaller wider worse";

/// "bytes a particle": write "bytes per particle".
const COUNTED: &str = "anchors buffers bytes cells dispatches frames microsecond millisecond milliseconds ms particles passes \
    pictures pixels relaxations rounds samples seconds springs steps substeps tethers threads";
const PER: &str =
    "batch cloth column core frame grid node particle piece pixel row second side step substep texel workgroup";

/// A word of a text: as it stands, in lower case without punctuation, and its line from 1. An empty word ends a paragraph.
struct Word<'a> {
    raw: &'a str,
    plain: String,
    line: usize,
}

impl Word<'_> {
    /// Whether the next word belongs to the same clause.
    fn goes_on(&self) -> bool {
        self.raw.ends_with(|c: char| c.is_alphanumeric() || c == '`')
    }

    fn ends_sentence(&self) -> bool {
        self.raw.trim_end_matches(['`', '"', ')', '*']).ends_with(['.', '!', '?']) && self.raw != "..."
    }
}

/// Words of a page, or of a program with the marks of its comments left out.
fn words(text: &str, page: bool) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    let (mut fenced, mut was_comment) = (false, false);
    for (index, line) in text.lines().enumerate() {
        let line_number = index + 1;
        let trimmed = line.trim_start();
        fenced ^= page && trimmed.starts_with("```");
        let comment = trimmed.starts_with("//");
        let heading = page && (trimmed.starts_with(['#', '|']) || fenced);
        if trimmed.trim_matches('/').trim().is_empty() || comment != was_comment || heading {
            words.push(Word { raw: "", plain: String::new(), line: line_number });
        }
        was_comment = comment;
        for raw in trimmed.trim_start_matches(['/', '!', '*', '-']).split_whitespace() {
            let plain = raw.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
            words.push(Word { raw, plain, line: line_number });
        }
    }
    words
}

/// Finds phrases from the word `at` on: the phrase and the plain wording.
fn found(words: &[Word], at: usize) -> Option<(String, String)> {
    let follows = |k: usize| words.get(at + k).filter(|_| (0..k).all(|j| words[at + j].goes_on()));
    let plain = |k: usize| follows(k).map_or("", |w| w.plain.as_str());
    let before = if at > 0 { &words[at - 1] } else { &words[at] };
    for (phrase, instead) in PHRASES {
        if phrase.split(' ').enumerate().all(|(k, word)| plain(k) == word) {
            return Some((phrase.into(), instead.into()));
        }
    }
    let (first, second, third) = (plain(0), plain(1), plain(2));
    let there = before.plain.rsplit(|c: char| !c.is_alphanumeric()).next() == Some("there");
    let fine = there || third.is_empty() || is_one_of(FINE_AFTER_NO, third);
    if BE.contains(&first) && second == "no" && !fine && follows(1).is_some_and(|w| w.raw == "no") {
        return Some((format!("{first} no {third}"), format!("{first} not {third}, with an article")));
    }
    if second == "a" && is_one_of(COUNTED, first) && is_one_of(PER, third) {
        return Some((format!("{first} a {third}"), format!("{first} per {third}")));
    }
    let starts = at == 0 || before.raw.is_empty() || before.raw == "//" || before.ends_sentence();
    if words[at].raw == "What" && starts && !is_question(&words[at..]) {
        return Some(("What ... as a subject".into(), "name the thing: subject first".into()));
    }
    None
}

fn is_one_of(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|w| w == word)
}

fn is_question(words: &[Word]) -> bool {
    let end = words.iter().find(|w| w.ends_sentence() || w.raw.is_empty());
    end.is_some_and(|w| w.raw.ends_with('?'))
}

/// All pages, programs and shaders of the repository but this file.
fn files(folder: &Path, list: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_str().unwrap_or_default();
        if path.is_dir() {
            if !["target", "shared"].contains(&name) && !name.starts_with('.') {
                files(&path, list);
            }
        } else if path.extension().is_some_and(|e| e == "md" || e == "rs" || e == "wgsl") && name != "plain_words.rs" {
            list.push(path);
        }
    }
}

#[test]
fn pages_comments_and_messages_use_plain_words() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut list = Vec::new();
    files(root, &mut list);
    assert!(list.len() > 300, "only {} files found", list.len());
    let mut report = String::new();
    for path in list {
        let text = std::fs::read_to_string(&path).unwrap();
        let page = path.extension().is_some_and(|e| e == "md");
        let words = words(&text, page);
        for (at, word) in words.iter().enumerate() {
            if let Some((phrase, instead)) = found(&words, at) {
                let place = path.strip_prefix(root).unwrap().display();
                writeln!(report, "{place}:{}: `{phrase}`: write: {instead}", word.line).unwrap();
            }
        }
    }
    assert!(report.is_empty(), "{} places:\n{report}", report.lines().count());
}

#[test]
fn the_search_finds_phrases_across_lines_and_leaves_plain_ones() {
    let hits = |text: &str, page| {
        let words = words(text, page);
        (0..words.len()).filter_map(|at| found(&words, at)).map(|f| f.0).collect::<Vec<_>>()
    };
    assert_eq!(hits("/// Made\n/// anew.\nfn f() {}", false), ["anew"]);
    assert_eq!(hits("// It is no\n// number, so many times.", false), ["is no number", "so many"]);
    assert_eq!(hits("16 bytes a particle", true), ["bytes a particle"]);
    assert_eq!(hits("/// A pass. What it costs is little.", false), ["What ... as a subject"]);
    assert_eq!(hits("What it costs is little.", true), ["What ... as a subject"]);
    for bad in
        ["/// What it costs.", "//! What it\n//! costs.", "fn f() {}\n// What it costs.", "f(x); // What it costs."]
    {
        assert_eq!(hits(bad, false), ["What ... as a subject"], "{bad}");
    }
    for fine in [
        "/// What does it cost?",
        "/// # What it costs",
        "// There is no time.",
        "// It is no longer there.",
        "// This is: no.",
        "// So. Many.",
    ] {
        assert!(hits(fine, false).is_empty(), "{fine}");
    }
    for fine in ["# What it costs", "What does it cost?", "| What it costs | 1 |"] {
        assert!(hits(fine, true).is_empty(), "{fine}");
    }
}
