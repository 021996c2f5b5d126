//! One image as the bytes of an EXR file, and back, bit for bit, on the calling thread.

use std::io::Cursor;

use exr::block::{self, BlockIndex, UncompressedBlock, writer::ChunksWriter};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType};
use exr::meta::header::{Header, LayerAttributes};

use crate::error::{Error, Result};
use crate::exr_header::{ExrHeader, read_header};
use crate::map::Image;

/// ZIP over blocks of sixteen rows: of the lossless ones it was both the smallest and the fastest to write on a smooth
/// 257 x 257 position map, 0.51 of the raw size against 0.54 for PIZ and 0.77 for ZIP over single rows.
const SMALL: Compression = Compression::ZIP16;

/// Run lengths: a tenth of the time, and on rest lengths, masses and texture coordinates, whose low bits are noise, 1 to
/// 4 % larger.
const FAST: Compression = Compression::RLE;

/// ZIP is used where it leaves at most this share of what run lengths do.
const WORTH: f64 = 0.9;

/// An image as one scan-line part of 32-bit floats, channels R, or R G B, or R G B A, losslessly compressed: ZIP, or run
/// lengths where that is hardly larger. The same image gives the same bytes, on any machine. Errors where
/// [`Image::check`] does.
pub fn encode_exr(image: &Image) -> Result<Vec<u8>> {
    image.check("image")?;
    // The middle rows tell for all.
    let rows = SMALL.scan_lines_per_block() / 2;
    let row = image.width as usize * image.channels as usize;
    let from = (image.height as usize).saturating_sub(rows) / 2;
    let data = image.data[from * row..(from * row + rows * row).min(image.data.len())].to_vec();
    let part = Image { height: (data.len() / row) as u32, data, ..*image };
    let [small, fast] = [encode_with(&part, SMALL)?.len(), encode_with(&part, FAST)?.len()];
    let worth = small as f64 <= WORTH * fast as f64;
    encode_with(image, if worth { SMALL } else { FAST })
}

fn encode_with(image: &Image, compression: Compression) -> Result<Vec<u8>> {
    let header = exr_header(image.width, image.height, image.channels, compression);
    let row = image.width as usize * image.channels as usize;
    let mut bytes = Vec::new();
    block::write(Cursor::new(&mut bytes), std::iter::once(header).collect(), true, |meta, writer| {
        let headers = meta.headers.clone();
        let rows = compression.scan_lines_per_block();
        for (index, block) in image.data.chunks(row * rows).enumerate() {
            let mut data = Vec::with_capacity(block.len() * 4);
            for line in block.chunks_exact(row) {
                for channel in stored_order(image.channels) {
                    for texel in line.chunks_exact(image.channels as usize) {
                        data.extend_from_slice(&texel[channel].to_ne_bytes());
                    }
                }
            }
            let position = Vec2(0, index * rows);
            let size = Vec2(image.width as usize, block.len() / row);
            let index_of = BlockIndex { layer: 0, pixel_position: position, pixel_size: size, level: Vec2(0, 0) };
            let chunk = UncompressedBlock { index: index_of, data }.compress_to_chunk(&headers)?;
            writer.write_chunk(index, chunk)?;
        }
        Ok(())
    })
    .map_err(|e| Error::Exr {
        file: "image".into(),
        problem: e.to_string(),
        hint: "report this with the input",
    })?;
    Ok(bytes)
}

/// Reads an image back. `file` is the name for errors. The header is checked ([`read_header`]) before anything is
/// allocated; give the size you expect to [`decode_exr_sized`] where you know it.
pub fn decode_exr(file: &str, bytes: &[u8]) -> Result<Image> {
    let header = read_header(file, bytes)?;
    read_pixels(file, bytes, &header)
}

/// As [`decode_exr`], but refuses an image that is not `width` x `height` texels with one of the numbers of `channels`,
/// before it allocates.
pub fn decode_exr_sized(file: &str, bytes: &[u8], width: u32, height: u32, channels: &[u32]) -> Result<Image> {
    let header = read_header(file, bytes)?;
    if (header.width, header.height) != (width, height) || !channels.contains(&header.channels) {
        let counts: Vec<String> = channels.iter().map(u32::to_string).collect();
        return Err(Error::Size {
            file: file.into(),
            found: format!("{} x {} texels of {} channels", header.width, header.height, header.channels),
            expected: format!("{width} x {height} texels of {} channels", counts.join(" or ")),
        });
    }
    read_pixels(file, bytes, &header)
}

fn read_pixels(file: &str, bytes: &[u8], head: &ExrHeader) -> Result<Image> {
    let damaged = |problem: String| Error::Exr {
        file: file.into(),
        problem,
        hint: "the file is damaged; restore it or build the bundle again",
    };
    let ExrHeader { width, height, channels, compression, table } = *head;
    let header = exr_header(width, height, channels, compression);
    let rows = compression.scan_lines_per_block();
    let blocks = (height as usize).div_ceil(rows);
    let mut image = Image::zeros(width, height, channels);
    let row = width as usize * channels as usize;

    // The offset table is in the order of the rows whatever the order of the chunks, so every row is met exactly once.
    for (index, target) in image.data.chunks_mut(row * rows).enumerate() {
        let cut_off = || damaged(format!("block {index} of {blocks} is cut off"));
        let read = |at: usize, n: usize| at.checked_add(n).and_then(|end| bytes.get(at..end)).ok_or_else(cut_off);
        let number = |at: usize| -> Result<i32> { Ok(i32::from_le_bytes(read(at, 4)?.try_into().unwrap_or([0; 4]))) };
        let offset = u64::from_le_bytes(read(table + index * 8, 8)?.try_into().unwrap_or([0; 8]));
        let offset = usize::try_from(offset).map_err(|_| cut_off())?;
        let first_row = index * rows;
        if usize::try_from(number(offset)?) != Ok(first_row) {
            return Err(damaged(format!("block {index} of {blocks} is not that of row {first_row}")));
        }
        // `offset + 4` and `offset + 8` cannot overflow: the reads before them were inside the file.
        let size = usize::try_from(number(offset + 4)?).map_err(|_| cut_off())?;
        if size > target.len() * 4 {
            return Err(damaged(format!("block {index} of {blocks} is larger than its pixels")));
        }
        let packed = read(offset + 8, size)?.to_vec();
        let lines = target.len() / row;
        let section = IntegerBounds::new(Vec2(0, first_row as i32), Vec2(width as usize, lines));
        let data = compression
            .decompress_image_section_from_le(&header, packed, section, true)
            .map_err(|e| damaged(format!("block {index} of {blocks}: {e}")))?;
        if data.len() != target.len() * 4 {
            return Err(damaged(format!("block {index} of {blocks} has the wrong length")));
        }
        let mut floats = data.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
        for line in target.chunks_exact_mut(row) {
            for channel in stored_order(channels) {
                for (texel, float) in line.chunks_exact_mut(channels as usize).zip(&mut floats) {
                    texel[channel] = float;
                }
            }
        }
    }
    Ok(image)
}

/// Channels in a file are sorted by name: A, B, G, R. These are their places in a texel.
fn stored_order(channels: u32) -> impl Iterator<Item = usize> {
    (0..channels as usize).rev()
}

fn exr_header(width: u32, height: u32, channels: u32, compression: Compression) -> Header {
    let channel = |name: &str| ChannelDescription::new(name, SampleType::F32, false);
    let list = stored_order(channels).map(|c| channel(["R", "G", "B", "A"][c])).collect();
    Header::new("".into(), Vec2(width as usize, height as usize), list)
        .with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing)
        // Without the default name attribute: nothing but what EXR itself requires.
        .with_attributes(LayerAttributes::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(width: u32, height: u32, channels: u32) -> Image {
        let mut image = Image::zeros(width, height, channels);
        for j in 0..height {
            for i in 0..width {
                let (u, v) = (i as f32 / width as f32, j as f32 / height as f32);
                let texel = [(3.0 * u).sin() * 0.4, 1.0 + v, (2.0 * u + v).cos() * 0.2, 1.0];
                let at = ((j * width + i) * channels) as usize;
                image.data[at..at + channels as usize].copy_from_slice(&texel[..channels as usize]);
            }
        }
        image
    }

    fn bits(image: &Image) -> Vec<u32> {
        image.data.iter().map(|f| f.to_bits()).collect()
    }

    #[test]
    fn every_bit_survives() {
        for (w, h, c) in [(2, 2, 1), (5, 33, 3), (129, 17, 4)] {
            let mut image = smooth(w, h, c);
            let odd = [f32::from_bits(0x7fc1_2345), f32::from_bits(0xff80_0001), -0.0, f32::INFINITY];
            for (slot, value) in image.data.iter_mut().zip(odd) {
                *slot = value;
            }
            let bytes = encode_exr(&image).unwrap();
            assert_eq!(bytes, encode_exr(&image).unwrap());
            assert_eq!(bits(&decode_exr("a.exr", &bytes).unwrap()), bits(&image));
        }
    }

    #[test]
    fn noise_that_does_not_compress_survives() {
        let mut state = 1_u32;
        let mut image = Image::zeros(37, 40, 4);
        for f in &mut image.data {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            *f = f32::from_bits(state);
        }
        let bytes = encode_exr(&image).unwrap();
        assert_eq!(bits(&decode_exr("a.exr", &bytes).unwrap()), bits(&image));
        assert!(bytes.len() as u64 <= crate::exr_header::max_file_bytes(37, 40, 4));
    }

    #[test]
    fn run_lengths_serve_where_zip_gains_little() {
        let of = |image: &Image| read_header("a.exr", &encode_exr(image).unwrap()).unwrap().compression;
        assert_eq!(of(&smooth(129, 65, 4)), SMALL);
        let mut noisy = smooth(129, 65, 1);
        let mut state = 1_u32;
        for f in &mut noisy.data {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            *f = f32::from_bits(0.01_f32.to_bits() ^ (state >> 12));
        }
        assert_eq!(of(&noisy), FAST);
        let sizes = [SMALL, FAST].map(|c| encode_with(&noisy, c).unwrap().len() as f64);
        assert!(sizes[1] < 1.05 * sizes[0], "{sizes:?}");
    }

    #[test]
    fn wrong_size_or_channels_is_refused() {
        let bytes = encode_exr(&smooth(8, 6, 4)).unwrap();
        assert!(decode_exr_sized("a.exr", &bytes, 8, 6, &[4]).is_ok());
        for (w, h, c) in [(6, 8, 4), (8, 6, 3), (9, 6, 4)] {
            let error = decode_exr_sized("a.exr", &bytes, w, h, &[c]).unwrap_err();
            assert!(matches!(error, Error::Size { .. }), "{error}");
        }
    }

    #[test]
    fn a_huge_data_window_is_refused_before_allocation() {
        let bytes = encode_exr(&smooth(8, 6, 4)).unwrap();
        let name = b"dataWindow\0box2i\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        let corners =
            [(32767, 32767), (i32::MAX, i32::MAX), (4000, 4000), (16383, 1000), (-1, 5), (0, 0), (i32::MIN, 1)];
        for (right, bottom) in corners {
            let mut crafted = bytes.clone();
            crafted[at + 8..at + 12].copy_from_slice(&i32::to_le_bytes(right));
            crafted[at + 12..at + 16].copy_from_slice(&i32::to_le_bytes(bottom));
            assert!(read_header("a.exr", &crafted).is_err(), "{right} {bottom}");
        }
    }

    #[test]
    fn damage_gives_errors_not_panics() {
        let bytes = encode_exr(&smooth(21, 35, 4)).unwrap();
        for len in 0..bytes.len() {
            assert!(decode_exr("a.exr", &bytes[..len]).is_err(), "cut to {len}");
        }
        let mut state = 7_u64;
        let mut next = |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        for round in 0..6000 {
            let mut mutated = bytes.clone();
            // Half of the rounds hit the header and the offset table, where the dangerous numbers are.
            let reach = if round % 2 == 0 { 400.min(bytes.len()) } else { bytes.len() };
            for _ in 0..1 + next(4) {
                let at = next(reach);
                mutated[at] = [0, 0xff, 0x7f, 0x80, next(256) as u8][next(5)];
            }
            let _ = decode_exr("a.exr", &mutated);
        }
    }

    #[test]
    fn other_lossless_compressions_are_read() {
        use exr::prelude::*;
        let expected = smooth(9, 20, 4);
        for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::PIZ] {
            let channels = SpecificChannels::rgba(|p: Vec2<usize>| {
                let t = expected.texel(p.x() as u32, p.y() as u32);
                (t[0], t[1], t[2], t[3])
            });
            let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
            let layer = Layer::new((9, 20), LayerAttributes::named("a"), encoding, channels);
            let mut bytes = Vec::new();
            exr::image::Image::from_layer(layer).write().to_buffered(Cursor::new(&mut bytes)).unwrap();
            let read = decode_exr("a.exr", &bytes);
            if compression == Compression::PIZ {
                assert!(read.unwrap_err().to_string().contains("compression"));
            } else {
                assert_eq!(read.unwrap(), expected, "{compression}");
            }
        }
    }
}
