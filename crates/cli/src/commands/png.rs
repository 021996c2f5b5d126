//! Pictures as PNG files.

use png::{ColorType, Encoder, EncodingError};

use crate::exit::Failure;

/// The bytes of a picture of a width and a height, rows from the top.
pub fn encode((width, height): (u32, u32), pixels: &[[u8; 4]]) -> Result<Vec<u8>, Failure> {
    let rgb: Vec<u8> = pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    let wrong = |error: EncodingError| Failure::from(gimage::Error::Internal(format!("encoding a picture: {error}")));
    let mut writer = encoder.write_header().map_err(wrong)?;
    writer.write_image_data(&rgb).map_err(wrong)?;
    writer.finish().map_err(wrong)?;
    Ok(bytes)
}
