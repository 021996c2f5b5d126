//! The gimage bundle: geometry images, their maps and their manifest.
mod error;
mod exr_header;
mod exr_io;
mod map;
mod particle;

pub use error::{CodeError, Error, Result};
pub use exr_header::{ExrHeader, max_file_bytes, read_header};
pub use exr_io::{decode_exr, decode_exr_sized, encode_exr};
pub use map::{Image, MAX_SIDE, MapKind, check_file_name, check_size, file_stems};
pub use particle::{MAX_PARTICLES, Particle};
