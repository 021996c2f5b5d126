//! The header of an EXR file, read without trusting it.
//!
//! A general EXR reader believes the data window and allocates for it, so a crafted header can end the process. This
//! one knows only what a bundle may hold, allocates nothing that the file's own length does not justify, and is the
//! only part of the header that is looked at: other attributes are skipped unread.

use exr::compression::Compression;

use crate::error::{Error, Result};
use crate::map::check_size;

/// The header of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrHeader {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Channels: 1 (R), 3 (R, G, B) or 4 (R, G, B, A).
    pub channels: u32,
    pub(crate) compression: Compression,
    /// Where the table of chunk offsets starts, in bytes.
    pub(crate) table: usize,
}

/// How many times smaller than its pixels a file can be: deflate reaches 1032.
const MAX_RATIO: u64 = 1100;

/// Reads the header alone. `file` is the name for errors. Refuses what is not a single-part scan-line f32 image with
/// channels R, RGB or RGBA, without loss, at the origin, within the size limits and plausible for its length.
pub fn read_header(file: &str, bytes: &[u8]) -> Result<ExrHeader> {
    let bad = |problem: String, hint| Error::Exr { file: file.into(), problem, hint };
    let damaged = |problem: &str| bad(problem.into(), "restore the file or build the bundle again");
    let unfit = |problem: String| bad(problem, "write it as one scan-line part of 32-bit floats, ZIP compressed");

    let mut cursor = Cursor { bytes, at: 0 };
    if cursor.take(4) != Some(&[0x76, 0x2f, 0x31, 0x01]) {
        return Err(damaged("not an EXR file"));
    }
    let version = cursor.u32().ok_or_else(|| damaged("the header is cut off"))?;
    // Bit 10 allows long attribute names; the others mean tiles, deep data or several parts.
    if version & 0xff != 2 || version & !(0xff | 0x400) != 0 {
        return Err(unfit(format!("EXR version field {version:#x} is not that of a single scan-line part")));
    }

    let (mut channels, mut compression, mut window, mut order) = (None, None, None, None);
    loop {
        let Attribute { name, kind, value } = match cursor.attribute() {
            Some(Some(attribute)) => attribute,
            Some(None) => break,
            None => return Err(damaged("the header is cut off")),
        };
        let repeated = match (name, kind) {
            (b"channels", b"chlist") => channels.replace(channel_count(value).map_err(unfit)?).is_some(),
            (b"compression", b"compression") => compression.replace(lossless(value).map_err(unfit)?).is_some(),
            (b"dataWindow", b"box2i") => window.replace(value).is_some(),
            (b"lineOrder", b"lineOrder") => order.replace(value).is_some(),
            (b"tiles", _) => return Err(unfit("the image is tiled".into())),
            (b"type", _) if value != b"scanlineimage" => return Err(unfit("the part holds no scan lines".into())),
            _ => false,
        };
        if repeated {
            return Err(damaged("an attribute stands twice in the header"));
        }
    }
    let (Some(channels), Some(compression), Some(window), Some(order)) = (channels, compression, window, order) else {
        return Err(damaged("channels, compression, dataWindow or lineOrder is missing from the header"));
    };
    if !matches!(order, [0 | 1]) {
        return Err(damaged("the line order is neither increasing nor decreasing"));
    }
    let mut window = Cursor { bytes: window, at: 0 };
    let edges = [window.i32(), window.i32(), window.i32(), window.i32()];
    let [Some(0), Some(0), Some(right), Some(bottom)] = edges else {
        return Err(unfit("the data window does not start at (0, 0)".into()));
    };
    let size = |last: i32| u32::try_from(i64::from(last) + 1).map_err(|_| damaged("the data window is empty"));
    let (width, height) = (size(right)?, size(bottom)?);
    check_size(file, width, height)?;
    let pixel_bytes = u64::from(width) * u64::from(height) * u64::from(channels) * 4;
    if pixel_bytes > (bytes.len() as u64).saturating_mul(MAX_RATIO) {
        return Err(damaged("the file is far too short for its data window"));
    }
    Ok(ExrHeader { width, height, channels, compression, table: cursor.at })
}

/// An upper bound in bytes for an image file of this size as this crate or any sane writer makes it.
pub fn max_file_bytes(width: u32, height: u32, channels: u32) -> u64 {
    let pixels = u64::from(width) * u64::from(height) * u64::from(channels) * 4;
    // A chunk is never larger than its pixels; one a row at most, with 16 bytes of framing; the rest is attributes.
    pixels + u64::from(height) * 16 + (1 << 20)
}

fn channel_count(list: &[u8]) -> std::result::Result<u32, String> {
    let mut cursor = Cursor { bytes: list, at: 0 };
    let mut names = Vec::new();
    loop {
        let name = cursor.text().ok_or("the channel list is cut off")?;
        if name.is_empty() {
            break;
        }
        let entry = cursor.take(16).ok_or("the channel list is cut off")?;
        if entry[..4] != [2, 0, 0, 0] {
            return Err(format!("channel {} does not hold 32-bit floats", String::from_utf8_lossy(name)));
        }
        if entry[8..] != [1, 0, 0, 0, 1, 0, 0, 0] {
            return Err(format!("channel {} is subsampled", String::from_utf8_lossy(name)));
        }
        names.push(name);
        if names.len() > 4 {
            return Err("there are more than four channels".into());
        }
    }
    // An EXR file lists its channels by name.
    match names.as_slice() {
        [b"R"] => Ok(1),
        [b"B", b"G", b"R"] => Ok(3),
        [b"A", b"B", b"G", b"R"] => Ok(4),
        _ => Err("the channels are not named R, or R, G, B, or R, G, B, A".into()),
    }
}

fn lossless(value: &[u8]) -> std::result::Result<Compression, String> {
    match value {
        [0] => Ok(Compression::Uncompressed),
        [1] => Ok(Compression::RLE),
        [2] => Ok(Compression::ZIP1),
        [3] => Ok(Compression::ZIP16),
        _ => Err("the compression is not one of none, RLE, ZIPS, ZIP".into()),
    }
}

/// One attribute of a header, as its bytes.
struct Attribute<'a> {
    name: &'a [u8],
    kind: &'a [u8],
    value: &'a [u8],
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(n)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take(4)?.try_into().ok().map(u32::from_le_bytes)
    }

    fn i32(&mut self) -> Option<i32> {
        self.take(4)?.try_into().ok().map(i32::from_le_bytes)
    }

    /// Text up to a zero byte, which is consumed too. EXR names are at most 255 long.
    fn text(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..)?;
        let len = rest.iter().take(256).position(|&b| b == 0)?;
        self.at += len + 1;
        Some(&rest[..len])
    }

    /// The next attribute; the inner `None` is the end of the header.
    fn attribute(&mut self) -> Option<Option<Attribute<'a>>> {
        let name = self.text()?;
        if name.is_empty() {
            return Some(None);
        }
        let kind = self.text()?;
        let size = usize::try_from(self.i32()?).ok()?;
        Some(Some(Attribute { name, kind, value: self.take(size)? }))
    }
}
