//! The gimage bundle: geometry images, their maps and their manifest.
mod error;
mod exr_header;
mod exr_io;
pub mod manifest;
mod map;
mod particle;
mod rings;

pub use error::{CodeError, Error, Result};
pub use exr_header::{ExrHeader, max_file_bytes, read_header};
pub use exr_io::{decode_exr, decode_exr_sized, encode_exr};
pub use manifest::Manifest;
pub use map::{Image, MAX_SIDE, MapKind, check_file_name, check_size, file_stems};
pub use particle::{MAX_PARTICLES, Particle};
pub use rings::{LinkFault, Rings, find_rings, ring_gap};
