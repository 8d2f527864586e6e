//! What is wrong with a model: one sentence with its place, and what to try.

use std::path::{Path, PathBuf};

/// What this crate returns.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a model cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// One place in a file is wrong.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// Its column in characters, from 1.
        column: usize,
        /// How many characters are wrong, at least 1.
        width: usize,
        /// The line itself, without its end.
        source_line: String,
        /// What was expected and what was found.
        message: String,
        /// What to try.
        hint: String,
    },
    /// A file as a whole cannot be used.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was expected and what was found.
        message: String,
        /// What to try.
        hint: String,
    },
    /// The operating system refused.
    #[error("{}: reading failed: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl Error {
    /// What to try; empty where there is nothing to say.
    #[must_use]
    pub fn hint(&self) -> &str {
        match self {
            Self::Text { hint, .. } | Self::File { hint, .. } => hint,
            Self::Io { .. } => "check the path",
        }
    }

    pub(crate) fn file(path: &Path, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::File { path: path.to_path_buf(), message: message.into(), hint: hint.into() }
    }
}
