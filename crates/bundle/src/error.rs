//! Errors: the file, the piece, the map, the texel, and what to do.

use std::path::PathBuf;

/// The result of reading or writing a bundle.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a bundle, or a part of one, could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused to read or write a file or directory.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The target of a write exists already.
    #[error("{}: exists already; choose another name, or allow replacing it (--force)", path.display())]
    Exists {
        /// The target.
        path: PathBuf,
    },
    /// The target of a forced write is not a bundle, so it is not replaced.
    #[error("{}: {problem}, so it is not replaced; choose another name, or remove it yourself", path.display())]
    NotABundle {
        /// The target.
        path: PathBuf,
        /// Why it does not count as a bundle.
        problem: String,
    },
    /// A file that the manifest names is not there.
    #[error("{file}: the manifest names it but it is missing; restore it or build the bundle again")]
    Missing {
        /// The file, as the manifest names it.
        file: String,
    },
    /// A file name in the manifest points out of the bundle or is not an image.
    #[error("manifest.json: file name {name:?} {problem}; use plain names such as body.position.exr")]
    FileName {
        /// The name as it stands in the manifest.
        name: String,
        /// The problem of the name.
        problem: &'static str,
    },
    /// Something is larger than the format allows.
    #[error("{what}: {need}, but at most {limit} allowed; {hint}")]
    TooLarge {
        /// The thing that is too large.
        what: String,
        /// How large it is.
        need: u64,
        /// The limit, in the same unit.
        limit: u64,
        /// The remedy.
        hint: &'static str,
    },
    /// The manifest cannot be understood, or contradicts itself.
    #[error("manifest.json: {problem}; {hint}")]
    Manifest {
        /// The problem of the manifest.
        problem: String,
        /// The remedy.
        hint: &'static str,
    },
    /// The manifest is of a version this reader does not know.
    #[error("manifest.json: version {found} is unknown, this reader knows version {known}; use a newer gimage")]
    Version {
        /// The version found.
        found: String,
        /// The version known.
        known: u32,
    },
    /// A number that JSON cannot hold was about to be written.
    #[error("manifest.json: {field} is not a finite number; leave the field out instead")]
    NotFinite {
        /// The field by its path, such as `pieces[0].quality.psnr`.
        field: String,
    },
    /// An image file is damaged or is not the kind of EXR a bundle holds.
    #[error("{file}: {problem}; {hint}")]
    Exr {
        /// The file.
        file: String,
        /// The problem.
        problem: String,
        /// The remedy.
        hint: &'static str,
    },
    /// An image has another size, or other channels, than the manifest says.
    #[error("{file}: {found}, but the manifest states {expected}; build the bundle again")]
    Size {
        /// The file.
        file: String,
        /// Width x height x channels of the file.
        found: String,
        /// Width x height x channels expected.
        expected: String,
    },
    /// The bytes of a file are not those that were written.
    #[error("{file}: its SHA-256 is not the one in the manifest: the file was changed; restore it or build again")]
    Checksum {
        /// The file.
        file: String,
    },
    /// A map does not fit its piece.
    #[error("piece {piece}: map {map}: {problem}; {hint}")]
    Map {
        /// The piece by name.
        piece: String,
        /// The map by name.
        map: String,
        /// The problem.
        problem: String,
        /// The remedy.
        hint: &'static str,
    },
    /// The mesh of the source is damaged, or bound to nothing.
    #[error("render.glb: {element}: {problem}; build the bundle again")]
    Render {
        /// The element of the file.
        element: String,
        /// The problem.
        problem: String,
    },
    /// A texel holds no legal particle code.
    #[error("piece {piece}: position: texel ({i}, {j}): {source}; build the bundle again")]
    Code {
        /// The piece by name.
        piece: String,
        /// Column of the texel.
        i: u32,
        /// Row of the texel.
        j: u32,
        /// The problem of the code.
        source: CodeError,
    },
}

/// Why a number is not a particle code, or a particle has none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CodeError {
    /// NaN or infinite.
    #[error("particle code {0} is not finite")]
    NotFinite(f32),
    /// Not a whole number; codes are never rounded.
    #[error("particle code {0} is not a whole number")]
    Fractional(f32),
    /// Beyond the last index that f32 holds exactly.
    #[error("particle code {0} links beyond the last possible particle")]
    LinkTooLarge(f32),
    /// An index that has no code.
    #[error("particle index {0} has no code; a bundle holds at most 16777214 particles")]
    IndexTooLarge(u32),
}
