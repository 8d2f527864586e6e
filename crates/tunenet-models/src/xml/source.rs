//! The files that a model consists of.

use std::io::{ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::{Error, Result};

/// Longest file, and most that all files of a model hold together, bytes: the largest models of robots have a few hundred thousand.
pub(crate) const LONGEST: u64 = 16 << 20;
/// Longest line that an error shows, characters.
const LONGEST_SHOWN: usize = 200;

/// How the text behind a path is read.
pub(crate) type Open<'a> = &'a dyn Fn(&Path) -> Result<String>;

/// A file and what it holds.
#[derive(Debug, Clone)]
pub(crate) struct SourceFile {
    pub path: PathBuf,
    pub text: String,
    /// Where lines end, once somebody asks for one.
    line_ends: OnceLock<Vec<usize>>,
}

impl SourceFile {
    pub fn new(path: &Path, text: &str) -> Self {
        Self { path: path.to_path_buf(), text: text.to_owned(), line_ends: OnceLock::new() }
    }

    /// The line of a byte, from 1.
    pub fn line(&self, at: usize) -> usize {
        let ends = self.line_ends.get_or_init(|| self.text.match_indices('\n').map(|(end, _)| end).collect());
        1 + ends.partition_point(|end| *end < at)
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
    // Opening a pipe waits for its writer, and a device may never end.
    if !about.is_file() {
        let message = "expected a file, found a pipe or a device";
        return Err(Error::file(path, message, "write the model to a file, and name that"));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_count_from_one_and_end_with_their_break() {
        let file = SourceFile::new(Path::new("a.xml"), "a\né\n\nb");
        let lines: Vec<usize> = (0..=file.text.len() + 2).map(|at| file.line(at)).collect();
        assert_eq!(lines, [1, 1, 2, 2, 2, 3, 4, 4, 4, 4]);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_refused_before_it_is_opened() {
        let error = read_file(Path::new("/dev/zero")).unwrap_err();
        assert!(error.to_string().contains("found a pipe or a device"), "{error}");
    }
}
