//! Reads, writes and validates gimage bundles: geometry images, their maps and their manifest.
//!
//! FORMAT.md in the root of the repository is the normative text. [`Bundle::decode`] and [`Bundle::from_files`] read a bundle
//! from bytes of any origin; [`dir`] reads and writes directories. This crate starts no threads.
//!
//! Input is not trusted: sizes are checked before memory is allocated, and no input makes a function panic.
//!
//! ```
//! use gimage_bundle::{Bundle, MapKind, validate};
//!
//! let mut bundle = Bundle::new("example 1.0");
//! let piece = bundle.add_piece("flag", 2, 2)?;
//! let position = gimage_bundle::Image {
//!     width: 2,
//!     height: 2,
//!     channels: 4,
//!     // x, y, z [m] and the particle code: 1 is a free particle.
//!     data: vec![0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0],
//! };
//! bundle.insert(piece, MapKind::Position, position)?;
//! bundle.count()?;
//! assert!(validate(&bundle).is_empty());
//! let files = bundle.encode()?;
//! assert_eq!(Bundle::from_files(&files)?.images, bundle.images);
//! # Ok::<(), gimage_bundle::Error>(())
//! ```

mod body;
mod budget;
mod bundle;
mod counts;
pub mod dir;
mod disjoint;
mod error;
mod exr_header;
mod exr_io;
mod limits;
pub mod manifest;
mod map;
mod particle;
mod render;
mod rings;
mod springs;
mod stitch;
mod surface;
mod tether;
mod validate;
mod welded;
mod winding;

pub use body::{Body, MAX_BODY};
pub use budget::{
    MAX_ACCESSORIES, MAX_COLLIDERS, MAX_IMAGE_BYTES, MAX_JOINTS, MAX_MANIFEST_OBJECTS, MAX_MANIFEST_VALUES, MAX_PIECES,
    MAX_REPAIRS,
};
pub use bundle::{Bundle, sha256};
pub use disjoint::DisjointSets;
pub use error::{CodeError, Error, Result};
pub use exr_header::{ExrHeader, max_file_bytes, read_header};
pub use exr_io::{decode_exr, decode_exr_sized, encode_exr};
pub use limits::NO_LIMIT;
pub use manifest::Manifest;
pub use map::{Image, MAX_SIDE, MapKind, check_file_name, check_size, file_stems};
pub use particle::{MAX_PARTICLES, Particle};
pub use render::{
    BLEND, COORD, JOINTS, MAX_RENDER_BYTES, OFFSET, RENDER_FILE, RenderFile, RenderMaterial, RenderPrimitive,
    UvTransform, WEIGHTS, Wrap, is_binding, numbered, texture_image,
};
pub use rings::{LinkFault, Rings, find_rings, ring_gap};
pub use springs::{SPRING_STEPS, other_end};
pub use stitch::{MAX_STITCHES_AT_POINT, NO_STITCH, Place, Stitch};
pub use surface::{Frame, SurfacePoint, surface_normals, triangles};
pub use tether::{Anchor, Bridge, MAX_ANCHORS, RestLengths, SpringGrid, Tethers, bridges, groups, tethers};
pub use validate::{Fault, FaultKind, MAX_LISTED, exit_code, validate, validate_files};
pub use winding::Winding;
