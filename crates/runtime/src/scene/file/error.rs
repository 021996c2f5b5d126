//! Why a scene file could not be used.

/// The result of reading a scene file.
pub type Result<T> = std::result::Result<T, Error>;

/// An error in a scene file, and its field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not JSON, or a field is missing, unknown or of the wrong kind.
    #[error("{field}: {problem}; SCENE.md lists the fields")]
    Syntax {
        /// Path of the field, as `cloths[0].pins[1].box.low`.
        field: String,
        /// Message of the parser, with line and column.
        problem: String,
    },
    /// A scene of another version, or no scene.
    #[error("{field} is {found}, not {known}; this program reads no other")]
    Version {
        /// `format` or `version`.
        field: &'static str,
        /// The value in the file.
        found: String,
        /// The value that is known.
        known: String,
    },
    /// A value outside its range, or parts that do not fit.
    #[error("{field}: {source}")]
    Value {
        /// Path of the field.
        field: String,
        /// The error of its value.
        source: Box<crate::Error>,
    },
    /// A bundle or garment could not be had.
    #[error("{field}: {problem}")]
    Source {
        /// Path of the field.
        field: String,
        /// Message of the host.
        problem: String,
    },
    /// A name or a choice that leads nowhere.
    #[error("{field}: {problem}")]
    Choice {
        /// Path of the field.
        field: String,
        /// The problem, and the choices that exist.
        problem: String,
    },
}

impl Error {
    /// An error of the runtime in a field.
    pub(super) fn value(field: impl Into<String>) -> impl FnOnce(crate::Error) -> Self {
        let field = field.into();
        move |source| Error::Value { field, source: Box::new(source) }
    }

    /// A choice that leads nowhere.
    pub(super) fn choice(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Error::Choice { field: field.into(), problem: problem.into() }
    }
}
