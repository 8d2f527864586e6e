//! The error type of this crate.

use std::io::ErrorKind;
use std::path::PathBuf;

use tunenet_core::Action;

use crate::shown::shown_path;

/// What this crate returns.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong with a file, each with where it happened, what was expected and what was found.
///
/// Every message is one sentence for users, and [`Error::hint`] says what to try.
///
/// Core knows no files. Where a trait of core requires its own error, as
/// [`DataSet`](tunenet_core::network::DataSet) does, a file's error converts into
/// [`Supplied`](tunenet_core::Error::Supplied), and back into itself once core has returned it. `?` does both.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// One place in a text file is wrong.
    #[error("{path}:{line}:{column}: {message}", path = shown_path(path))]
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
    #[error("{path}: {message}", path = shown_path(path))]
    File {
        /// The file.
        path: PathBuf,
        /// What was expected and what was found.
        message: String,
        /// What to try.
        hint: String,
    },
    /// The operating system refused.
    #[error("{path}: {what}", path = shown_path(path), what = refusal(*action, source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done.
        action: Action,
        /// What the system said.
        source: std::io::Error,
    },
    /// Core refused what the file holds, or what was asked. Never a [`Supplied`](tunenet_core::Error::Supplied) error of
    /// this type.
    #[error(transparent)]
    Core(tunenet_core::Error),
}

impl Error {
    /// What a user can try, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<&str> {
        match self {
            Self::Text { hint, .. } | Self::File { hint, .. } => Some(hint.as_str()).filter(|hint| !hint.is_empty()),
            Self::Io { action, source, .. } => io_hint(*action, source.kind()),
            Self::Core(_) => None,
        }
    }

    /// Shorthand for [`Error::File`].
    pub fn file(path: impl Into<PathBuf>, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::File { path: path.into(), message: message.into(), hint: hint.into() }
    }

    /// Shorthand for [`Error::Io`].
    pub fn io(path: impl Into<PathBuf>, action: Action, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action, source }
    }
}

impl From<tunenet_core::Error> for Error {
    /// An error of this type that a trait of core carried becomes itself again.
    fn from(error: tunenet_core::Error) -> Self {
        match error {
            tunenet_core::Error::Supplied(carried) => match carried.downcast::<Self>() {
                Ok(own) => *own,
                Err(other) => Self::Core(tunenet_core::Error::Supplied(other)),
            },
            other => Self::Core(other),
        }
    }
}

impl From<Error> for tunenet_core::Error {
    /// For implementations of core's traits: core's own errors as they are, those of files as
    /// [`Supplied`](tunenet_core::Error::Supplied).
    fn from(error: Error) -> Self {
        match error {
            Error::Core(own) => own,
            file => Self::Supplied(Box::new(file)),
        }
    }
}

/// What the system refused. That there is no such file needs no number.
fn refusal(action: Action, source: &std::io::Error) -> String {
    match (action, source.kind()) {
        // A file in a file is not there either.
        (Action::Opening | Action::Reading, ErrorKind::NotFound | ErrorKind::NotADirectory) => "no such file".into(),
        _ => format!("{action} failed: {source}"),
    }
}

/// What to try where the system refused.
fn io_hint(action: Action, kind: ErrorKind) -> Option<&'static str> {
    match kind {
        ErrorKind::NotFound if matches!(action, Action::Writing | Action::Creating) => Some("make the folder first"),
        ErrorKind::NotFound | ErrorKind::NotADirectory => Some("check the path"),
        ErrorKind::PermissionDenied => Some("check who may use the file"),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            Some("free some space, or write to another place; the previous file is untouched")
        }
        ErrorKind::IsADirectory => Some("name a file, not a folder"),
        ErrorKind::InvalidData => Some("is this the right file?"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(hint: &str) -> Error {
        let (path, source_line) = (PathBuf::from("a.csv"), "0,x".into());
        Error::Text { path, line: 2, column: 3, width: 1, source_line, message: "no number".into(), hint: hint.into() }
    }

    fn stopped() -> tunenet_core::Error {
        tunenet_core::Error::Stopped
    }

    /// Through core and back, as where a trait of core carries it.
    fn carried(error: Error) -> Error {
        tunenet_core::Error::from(error).into()
    }

    #[test]
    fn a_message_begins_with_its_place() {
        assert_eq!(text("").to_string(), "a.csv:2:3: no number");
        assert_eq!(Error::file("a.csv", "empty", "").to_string(), "a.csv: empty");
        let denied = Error::io("a.csv", Action::Reading, ErrorKind::PermissionDenied.into());
        assert_eq!(denied.to_string(), "a.csv: reading failed: permission denied");
        let missing = |action| Error::io("a.csv", action, ErrorKind::NotFound.into()).to_string();
        assert_eq!(missing(Action::Opening), "a.csv: no such file");
        assert!(missing(Action::Writing).starts_with("a.csv: writing failed: "), "{}", missing(Action::Writing));
        assert_eq!(Error::from(stopped()).to_string(), stopped().to_string());
    }

    #[test]
    fn a_hint_says_what_to_try_or_is_none() {
        assert_eq!(text("write 1").hint(), Some("write 1"));
        assert_eq!(Error::file("a.csv", "empty", "record it").hint(), Some("record it"));
        for silent in [text(""), Error::file("a.csv", "empty", ""), stopped().into()] {
            assert_eq!(silent.hint(), None, "{silent}");
        }
    }

    #[test]
    fn a_missing_file_is_asked_for_and_a_missing_folder_is_to_be_made() {
        let hint = |action| io_hint(action, ErrorKind::NotFound);
        assert_eq!(hint(Action::Reading), Some("check the path"));
        assert_eq!(hint(Action::Writing), Some("make the folder first"));
        assert_eq!(hint(Action::Creating), Some("make the folder first"));
    }

    #[test]
    fn errors_of_files_pass_through_core_unchanged() {
        for error in [text("write 1"), Error::file("a.csv", "empty", "record it")] {
            let before = format!("{error:?}");
            assert!(matches!(tunenet_core::Error::from(text("")), tunenet_core::Error::Supplied(_)));
            assert_eq!(format!("{:?}", carried(error)), before);
        }
    }

    #[test]
    fn what_core_carries_reads_and_is_caused_as_before() {
        let denied = || Error::io("a.csv", Action::Reading, ErrorKind::PermissionDenied.into());
        let supplied = tunenet_core::Error::from(denied());
        assert_eq!(supplied.to_string(), denied().to_string());
        let cause = |error: &dyn std::error::Error| error.source().map(ToString::to_string);
        assert_eq!(cause(&supplied), cause(&denied()));
        assert!(cause(&supplied).is_some());
    }

    #[test]
    fn errors_of_core_stay_its_own() {
        assert!(matches!(tunenet_core::Error::from(Error::from(stopped())), tunenet_core::Error::Stopped));
        let foreign = tunenet_core::Error::Supplied("of another caller".into());
        assert!(matches!(Error::from(foreign), Error::Core(tunenet_core::Error::Supplied(_))));
    }
}
