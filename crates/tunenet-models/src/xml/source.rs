//! The files that a model consists of.

use std::io::{ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Longest file, bytes: the largest models of robots have a few hundred thousand.
const LONGEST: u64 = 16 << 20;
/// Longest line that an error shows, characters.
const LONGEST_SHOWN: usize = 200;

/// How the text behind a path is read.
pub(crate) type Open<'a> = &'a dyn Fn(&Path) -> Result<String>;

/// A file and what it holds.
#[derive(Debug, Clone)]
pub(crate) struct SourceFile {
    pub path: PathBuf,
    pub text: String,
}

impl SourceFile {
    /// The line of a byte, from 1.
    pub fn line(&self, at: usize) -> usize {
        1 + self.text[..boundary(&self.text, at)].matches('\n').count()
    }

    /// An error at these bytes.
    pub fn error(&self, at: Range<usize>, message: impl Into<String>, hint: impl Into<String>) -> Error {
        let from = boundary(&self.text, at.start);
        let to = boundary(&self.text, at.end.max(from));
        let begin = self.text[..from].rfind('\n').map_or(0, |i| i + 1);
        let end = self.text[from..].find('\n').map_or(self.text.len(), |i| from + i);
        let source_line = &self.text[begin..end];
        Error::Text {
            path: self.path.clone(),
            line: self.line(from),
            column: 1 + self.text[begin..from].chars().count(),
            width: self.text[from..to.min(end).max(from)].chars().count().max(1),
            source_line: shown(source_line.trim_end_matches('\r')),
            message: message.into(),
            hint: hint.into(),
        }
    }
}

fn boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// A text of a file as a message quotes it: short, without control characters.
pub(crate) fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(LONGEST_SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST_SHOWN).is_some() {
        short.push('…');
    }
    short
}

/// The text of a file, at most 16 MB of UTF-8.
///
/// # Errors
/// [`Error::Io`] where it cannot be read; [`Error::File`] where it is too long or no UTF-8.
pub fn read_file(path: &Path) -> Result<String> {
    let io = |source| Error::Io { path: path.to_path_buf(), source };
    let about = std::fs::metadata(path).map_err(io)?;
    if about.is_dir() {
        return Err(io(ErrorKind::IsADirectory.into()));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path).and_then(|file| file.take(LONGEST + 1).read_to_end(&mut bytes)).map_err(io)?;
    if bytes.len() as u64 > LONGEST {
        let message = format!("expected a model of at most {} MB, found a longer file", LONGEST >> 20);
        return Err(Error::file(path, message, "is this the model? meshes stand in files of their own"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let message = format!("expected UTF-8, found something else at byte {at}");
        Error::file(path, message, "save the file as UTF-8")
    })
}
