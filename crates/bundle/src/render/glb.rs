//! The GLB container.

use super::damaged;
use crate::error::Result;

const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

/// The JSON chunk and the binary chunk, which may be empty.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], &[u8])> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.first_chunk().copied()).map(u32::from_le_bytes);
    let bad = |problem: &str| damaged("container", problem);
    if bytes.get(..4) != Some(b"glTF") || word(4) != Some(2) {
        return Err(bad("it is not a GLB file of version 2"));
    }
    if word(8) != u32::try_from(bytes.len()).ok() {
        return Err(bad("its length is not the one that its header states"));
    }
    let chunk = |at: usize, kind: u32| {
        let (size, found) = (word(at)? as usize, word(at + 4)?);
        bytes.get(at + 8..(at + 8).checked_add(size)?).filter(|_| found == kind)
    };
    let json = chunk(12, JSON).ok_or_else(|| bad("it does not begin with a whole JSON chunk"))?;
    let after = 20 + json.len();
    match bytes.len() - after {
        0 => Ok((json, &[])),
        _ => chunk(after, BIN).map(|bin| (json, bin)).ok_or_else(|| bad("its binary chunk is cut off")),
    }
}
