//! Binary glTF files, read and changed.

use std::path::Path;

use serde_json::Value;

/// A binary glTF file in memory.
pub struct Glb {
    /// Its JSON.
    pub json: Value,
    /// Its one buffer.
    pub bytes: Vec<u8>,
}

impl Glb {
    /// Reads a file that has a buffer.
    pub fn read(path: &Path) -> Self {
        let all = std::fs::read(path).unwrap();
        let word = |at: usize| u32::from_le_bytes(all[at..at + 4].try_into().unwrap()) as usize;
        let (json, rest) = all[20..].split_at(word(12));
        Glb { json: serde_json::from_slice(json).unwrap(), bytes: rest[8..].to_vec() }
    }

    /// Writes it to a file.
    pub fn write(mut self, path: &Path) {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend(((28 + text.len() + self.bytes.len()) as u32).to_le_bytes());
        for (kind, part) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            out.extend((part.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(part);
        }
        std::fs::write(path, out).unwrap();
    }
}
