//! The GLB container: a header and two chunks.

use std::path::Path;

use super::malformed;
use crate::error::{Error, Result};

/// The parts of a GLB file.
pub(crate) struct Chunks<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
}

const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;
const AGAIN: &str = "the file is cut off or damaged: download or export it again";

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

/// Splits a GLB file, checking every length.
pub(crate) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Chunks<'a>> {
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        let problem = format!("it has {} of the 12 bytes of a GLB header", bytes.len());
        return Err(malformed(path, "GLB header", problem, AGAIN));
    };
    if version == 1 {
        return Err(gltf_1(path));
    }
    if version != 2 {
        return Err(malformed(path, "GLB header", format!("its version is {version}, not 2"), AGAIN));
    }
    let Some(bytes) = bytes.get(..length as usize) else {
        let problem = format!("its length field is {length} bytes, but the file has {}", bytes.len());
        return Err(malformed(path, "GLB header", problem, AGAIN));
    };
    let (mut json, mut bin, mut at, mut index) = (None, None, 12, 0);
    while let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) {
        let start = at + 8;
        let Some(data) = start.checked_add(size as usize).and_then(|end| bytes.get(start..end)) else {
            let problem = format!("its length field is {size} bytes, but the file has {} more", bytes.len() - start);
            return Err(malformed(path, format!("GLB chunk {index}"), problem, AGAIN));
        };
        match kind {
            JSON if index == 0 => json = Some(data),
            BIN if bin.is_none() => bin = Some(data),
            // The standard asks readers to pass over chunks they do not know.
            _ => {}
        }
        (at, index) = (start + data.len(), index + 1);
    }
    let json = json.ok_or_else(|| malformed(path, "GLB chunk 0", "it is not the JSON chunk", AGAIN))?;
    Ok(Chunks { json, bin })
}

/// The refusal of the old format.
pub(crate) fn gltf_1(path: &Path) -> Error {
    Error::Unsupported {
        path: path.to_path_buf(),
        feature: "glTF 1.0".into(),
        hint: "convert it to 2.0 with `npx gltf-pipeline -i in.gltf -o out.gltf`".into(),
    }
}
