//! Errors, with the file, the element and what to do.

use std::path::PathBuf;

/// The result of a stage.
pub type Result<T> = std::result::Result<T, Error>;

/// The reason why a garment could not be built. Every message names the place and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file is not what its name says, or is damaged.
    #[error("{}: {element}: {problem}; {hint}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The mesh, primitive, accessor, line, ...
        element: String,
        /// The problem of the element.
        problem: String,
        /// The remedy.
        hint: String,
    },
    /// A file is sound but needs something this library does not do.
    #[error("{}: {feature} is not supported; {hint}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The extension or feature by name.
        feature: String,
        /// The remedy, as a command where there is one.
        hint: String,
    },
    /// There is nothing to work on.
    #[error("{}: {problem}; {hint}", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// The missing thing.
        problem: String,
        /// The remedy.
        hint: String,
    },
    /// Something would take more memory, or more texels, than is allowed.
    #[error("{what}: needs {need}, at most {limit} allowed; {hint}")]
    TooLarge {
        /// The thing that is too large.
        what: String,
        /// How much it needs.
        need: String,
        /// The limit.
        limit: String,
        /// The remedy.
        hint: String,
    },
    /// The image asked for has too few texels on its border for the cut.
    #[error(
        "piece {piece}: {width} x {height} texels cannot hold its border; the smallest size that fits is {min_width} x {min_height}"
    )]
    GridTooSmall {
        /// The piece by name.
        piece: String,
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Smallest width that fits.
        min_width: u32,
        /// Smallest height that fits.
        min_height: u32,
    },
    /// A stage could not do its work on one piece.
    #[error("piece {piece}: {stage}: {problem}; {hint}")]
    Piece {
        /// The piece by name.
        piece: String,
        /// The stage by name.
        stage: &'static str,
        /// The problem that stopped it.
        problem: String,
        /// The remedy.
        hint: String,
    },
    /// An image came out that does not stand for its surface, or not as well as asked for.
    #[error("piece {piece}: {problem}; {hint}")]
    Poor {
        /// The piece by name; the worst, if there are several.
        piece: String,
        /// Its figures.
        problem: String,
        /// The remedy.
        hint: String,
    },
    /// An option has a value it cannot have.
    #[error("option {option}: {problem}; {hint}")]
    Option {
        /// The option by name.
        option: String,
        /// The problem of the value.
        problem: String,
        /// The remedy.
        hint: String,
    },
    /// The caller cancelled the run.
    #[error("cancelled")]
    Cancelled,
    /// The bundle could not be written or read.
    #[error(transparent)]
    Bundle(#[from] gimage_bundle::Error),
    /// A fault of this library.
    #[error("internal error: {0}; please report it with the input")]
    Internal(String),
}
