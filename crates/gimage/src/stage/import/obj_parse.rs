//! The text of an OBJ file: lines, numbers and references, each fault with its line.
//!
//! `tobj` is not used here, only as a second opinion in the tests: it fans concave polygons, numbers no lines in its errors,
//! reads `nan`, and makes one index list per object, which loses which vertices and texture coordinates were shared.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use super::findings::Findings;
use super::{ImportOptions, builder, malformed};
use crate::base::mesh::{NONE, Part};
use crate::error::{Error, Result};
use crate::record::Severity;

/// A corner of a face: position, texture coordinate and normal, counted from 0; the latter two may be [`NONE`].
pub(crate) type Corner = [u32; 3];

/// A polygon, and the line it stands on.
pub(crate) struct Face {
    pub line: usize,
    pub part: u32,
    /// Its corners are those from here to the next face's.
    pub start: usize,
}

/// A file as it stands.
#[derive(Default)]
pub(crate) struct Text {
    pub positions: Vec<[f64; 3]>,
    /// Colour of each position; empty if no position has one, NaN for those that have none.
    pub colors: Vec<[f32; 4]>,
    /// Texture coordinates as written, v up.
    pub uvs: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
    pub faces: Vec<Face>,
    pub corners: Vec<Corner>,
    pub parts: Vec<Part>,
    pub comments: Vec<String>,
}

/// How many comment lines at the head of a file are kept.
const MAX_COMMENTS: usize = 16;

struct Parser<'a> {
    path: &'a Path,
    options: &'a ImportOptions,
    line: usize,
    text: Text,
    now: Part,
    part: Option<u32>,
    /// Parts by object, group and material, and how many there are of each object and group.
    known: HashMap<[String; 3], u32>,
    primitives: HashMap<[String; 2], u32>,
}

/// Reads the text.
pub(crate) fn parse(path: &Path, bytes: &[u8], options: &ImportOptions, findings: &mut Findings) -> Result<Text> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (now, known, primitives) = Default::default();
    let mut parser = Parser { path, options, line: 0, text: Text::default(), now, part: None, known, primitives };
    let mut lines = bytes.split(|&b| b == b'\n').enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = Cow::Borrowed(line.strip_suffix(b"\r").unwrap_or(line));
        while line.last() == Some(&b'\\') && !line.trim_ascii_start().starts_with(b"#") {
            let whole = line.to_mut();
            whole.pop();
            whole.push(b' ');
            let Some((_, more)) = lines.next() else { break };
            whole.extend_from_slice(more.strip_suffix(b"\r").unwrap_or(more));
        }
        parser.line = number + 1;
        // Names may be in any old encoding; all else is ASCII.
        parser.statement(&String::from_utf8_lossy(&line), findings)?;
    }
    Ok(parser.text)
}

impl Parser<'_> {
    fn bad(&self, problem: String, hint: &str) -> Error {
        malformed(self.path, format!("line {}", self.line), problem, hint)
    }

    fn statement(&mut self, line: &str, findings: &mut Findings) -> Result<()> {
        let line = line.trim();
        if let Some(comment) = line.strip_prefix('#') {
            let text = &mut self.text;
            let head = text.positions.is_empty() && text.comments.len() < MAX_COMMENTS;
            let comment = comment.trim_matches(|c: char| c == '#' || c.is_whitespace());
            if head && !comment.is_empty() {
                text.comments.push(comment.into());
            }
            return Ok(());
        }
        let line = line.split_once('#').filter(|(head, _)| head.ends_with([' ', '\t'])).map_or(line, |(head, _)| head);
        let (word, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "v" => self.vertex(rest),
            "vt" => {
                let n = self.numbers(rest, 1..=3, true)?;
                self.text.uvs.push([n[0] as f32, n.get(1).map_or(0.0, |&v| v as f32)]);
                Ok(())
            }
            "vn" => {
                let n = self.numbers(rest, 3..=3, true)?;
                self.text.normals.push([n[0] as f32, n[1] as f32, n[2] as f32]);
                Ok(())
            }
            "f" | "fo" => self.face(rest, findings),
            "o" => self.rename(|now| (now.node, now.mesh) = (rest.into(), String::new())),
            "g" => self.rename(|now| now.mesh = rest.into()),
            "usemtl" => self.rename(|now| now.material = rest.into()),
            "l" | "p" => {
                let message = "Points and lines have no surface and were left out.";
                findings.add(Severity::Note, "points-and-lines", 1, message, || format!("line {}", self.line));
                Ok(())
            }
            "curv" | "curv2" | "surf" => {
                let message = "Free-form curves and surfaces were left out.";
                findings.add(Severity::Repair, "free-form", 1, message, || format!("line {}", self.line));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn rename(&mut self, change: impl FnOnce(&mut Part)) -> Result<()> {
        change(&mut self.now);
        self.part = None;
        Ok(())
    }

    fn vertex(&mut self, rest: &str) -> Result<()> {
        let n = self.numbers(rest, 3..=8, false)?;
        let text = &mut self.text;
        text.positions.push([n[0], n[1], n[2]]);
        // x y z, with w, with r g b, or with r g b a.
        if n.len() >= 6 {
            text.colors.resize(text.positions.len() - 1, [f32::NAN; 4]);
            text.colors.push([n[3] as f32, n[4] as f32, n[5] as f32, n.get(6).map_or(1.0, |&a| a as f32)]);
        }
        let (vertices, limit) = (text.positions.len(), self.options.max_vertices);
        if vertices > limit { builder::check_size(self.path, self.options, vertices, 0) } else { Ok(()) }
    }

    /// The numbers of a line. `lenient` accepts values that are not numbers; they are reported later.
    fn numbers(&self, rest: &str, count: std::ops::RangeInclusive<usize>, lenient: bool) -> Result<Numbers> {
        let mut out = Numbers { values: [0.0; 8], len: 0 };
        for word in rest.split_ascii_whitespace() {
            if out.len == out.values.len() {
                break;
            }
            let value: f64 = word.parse().map_err(|_| {
                let comma = word.contains(',') && word.replace(',', ".").parse::<f64>().is_ok();
                let hint = if comma { "write decimals with a point" } else { "correct the line" };
                self.bad(format!("`{word}` is not a number"), hint)
            })?;
            // Nothing that came from single precision is larger, and squares must stay finite.
            if !lenient && (value.is_nan() || value.abs() > f64::from(f32::MAX)) {
                let what = if value.is_nan() || !word.contains(|c: char| c.is_ascii_digit()) {
                    "is not a finite number"
                } else {
                    "is too large a number"
                };
                return Err(self.bad(format!("`{word}` {what}"), "correct the line, or export the file again"));
            }
            out.values[out.len] = value;
            out.len += 1;
        }
        if out.len < *count.start() {
            let problem = format!("it has {} numbers, and needs {}", out.len, count.start());
            return Err(self.bad(problem, "correct the line"));
        }
        Ok(out)
    }

    fn face(&mut self, rest: &str, findings: &mut Findings) -> Result<()> {
        let start = self.text.corners.len();
        for word in rest.split_ascii_whitespace() {
            let corner = self.corner(word)?;
            self.text.corners.push(corner);
        }
        if self.text.corners.len() - start < 3 {
            self.text.corners.truncate(start);
            let message = "Faces with fewer than three different vertices were left out.";
            findings.add(Severity::Repair, "degenerate-faces", 1, message, || format!("line {}", self.line));
            return Ok(());
        }
        let part = match self.part {
            Some(part) => part,
            None => self.find_part(),
        };
        self.text.faces.push(Face { line: self.line, part, start });
        Ok(())
    }

    /// The part of the current object, group and material, made at its first face.
    fn find_part(&mut self) -> u32 {
        let (object, group, material) = (&self.now.node, &self.now.mesh, &self.now.material);
        let parts = &mut self.text.parts;
        let part = *self.known.entry([object, group, material].map(String::clone)).or_insert_with(|| {
            let count = self.primitives.entry([object, group].map(String::clone)).or_default();
            parts.push(Part { primitive: *count, ..self.now.clone() });
            *count += 1;
            parts.len() as u32 - 1
        });
        self.part = Some(part);
        part
    }

    fn corner(&self, word: &str) -> Result<Corner> {
        let text = &self.text;
        let counts = [text.positions.len(), text.uvs.len(), text.normals.len()];
        let mut corner = [NONE; 3];
        let mut fields = word.split('/');
        for (k, slot) in corner.iter_mut().enumerate() {
            let Some(field) = fields.next().filter(|f| !f.is_empty()) else { continue };
            let what = ["vertex", "texture coordinate", "normal"][k];
            let index: i64 = field
                .parse()
                .map_err(|_| self.bad(format!("`{word}` is not a reference to a {what}"), "correct the line"))?;
            // Negative indices count back from the last element so far.
            let at = if index > 0 { index - 1 } else { counts[k] as i64 + index };
            let outside = index == 0 || at < 0 || at >= i64::from(NONE);
            if outside && k == 0 {
                let problem = format!("face uses vertex {index}, and there are {} so far", counts[0]);
                return Err(self.bad(problem, "indices start at 1, or at -1 from the end; export the file again"));
            }
            // Out of reach, but not mistaken for absent: reported where it is used.
            *slot = if outside { NONE - 1 } else { at as u32 };
        }
        if corner[0] == NONE || fields.next().is_some() {
            return Err(self.bad(format!("`{word}` is not a corner of a face"), "correct the line"));
        }
        Ok(corner)
    }
}

/// Up to eight numbers, without an allocation.
struct Numbers {
    values: [f64; 8],
    len: usize,
}

impl std::ops::Deref for Numbers {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[..self.len]
    }
}
