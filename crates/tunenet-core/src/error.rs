//! The one error type of this crate.

use std::path::PathBuf;

/// What this crate returns.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong, each with where it happened, what was expected and what was found.
///
/// A person reads these: every message is one sentence, and [`Error::hint`] says what to try.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An observation's numbers cannot be one.
    #[error("{what}: expected {expected}, found {found}")]
    Observation {
        /// The channel, sample or clock concerned.
        what: String,
        /// What a usable observation has there.
        expected: String,
        /// What this one has.
        found: String,
    },
    /// A parameter's definition contradicts itself.
    #[error("parameter `{name}`: expected {expected}, found {found}")]
    Parameter {
        /// Which parameter.
        name: String,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// One place in a text file is wrong.
    #[error("{path}:{line}:{column}: {message}", path = path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// Its column in characters, from 1.
        column: usize,
        /// How many characters are wrong, at least 1.
        width: usize,
        /// The offending line itself, without its end.
        source_line: String,
        /// What is wrong.
        message: String,
        /// What to try.
        hint: String,
    },
    /// A file as a whole cannot be used.
    #[error("{path}: {message}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was expected and what was found.
        message: String,
        /// What to try.
        hint: String,
    },
    /// The operating system refused.
    #[error("{path}: {action} failed: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done, as a verb: "reading", "writing".
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A simulator could not roll out.
    #[error("the simulator refused {at}: {message}")]
    Simulator {
        /// The parameter values, as `name=value` pairs.
        at: String,
        /// What it said.
        message: String,
    },
    /// A simulator answered a number that cannot be reckoned with: not finite, or beyond
    /// [`GREATEST`](crate::observation::GREATEST).
    #[error("the simulator answered {found} for {place} with {at}: expected {expected}")]
    Prediction {
        /// The parameter values, as `name=value` pairs.
        at: String,
        /// The channel and the sample, from 1.
        place: String,
        /// What can be reckoned with.
        expected: String,
        /// The number.
        found: String,
    },
    /// A trained model does not fit what it is asked to do.
    #[error("the model {what}: expected {expected}, found {found}")]
    Model {
        /// What does not fit: its shape, its parameters, its input.
        what: String,
        /// What the task needs.
        expected: String,
        /// What the model has.
        found: String,
    },
    /// A setting is outside its range.
    #[error("`{name}`: expected {expected}, found {found}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// Its range.
        expected: String,
        /// What was given.
        found: String,
    },
    /// A device cannot be used.
    #[error("expected a GPU that CUDA can use, found none: {message}")]
    Device {
        /// What its driver said.
        message: String,
    },
    /// The network library failed.
    #[error("the network library failed: {0}")]
    Network(#[from] candle_core::Error),
    /// The work was asked to stop (the progress callback said so); what is on disk can be resumed.
    #[error("stopped on request")]
    Stopped,
}

impl Error {
    /// What a person can try, where there is something.
    #[must_use]
    pub fn hint(&self) -> Option<&str> {
        match self {
            Self::Text { hint, .. } | Self::File { hint, .. } if !hint.is_empty() => Some(hint),
            Self::Io { action, source, .. } => io_hint(action, source.kind()),
            Self::Setting { name: "device", .. } => {
                Some("install one with it: `cargo install --locked --path crates/tunenet-cli --features cuda`")
            }
            Self::Device { .. } => Some("look at what `nvidia-smi` says, or train with `--device cpu`"),
            Self::Model { .. } => Some("train a model for this scene: `tunenet gen`, then `tunenet train`"),
            _ => None,
        }
    }

    /// Shorthand for [`Error::File`].
    pub fn file(path: impl Into<PathBuf>, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::File { path: path.into(), message: message.into(), hint: hint.into() }
    }

    /// Shorthand for [`Error::Io`].
    pub fn io(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action, source }
    }
}

/// What to try where the system refused.
fn io_hint(action: &str, kind: std::io::ErrorKind) -> Option<&'static str> {
    use std::io::ErrorKind;
    match kind {
        ErrorKind::NotFound if matches!(action, "writing" | "creating") => Some("make the folder first"),
        ErrorKind::NotFound => Some("check the path"),
        ErrorKind::PermissionDenied => Some("check who may use the file"),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            Some("free some space, or write elsewhere; what was there before is untouched")
        }
        ErrorKind::IsADirectory => Some("name a file, not a folder"),
        ErrorKind::InvalidData => Some("is this the right file?"),
        _ => None,
    }
}
