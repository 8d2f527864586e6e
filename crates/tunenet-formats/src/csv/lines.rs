//! Lines and cells of a text table.

use std::io::{BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};

use crate::encoding::line;
use crate::source::open;
use crate::{Action, Error, Result};

/// Longest line in bytes. A thousand columns of 17 digits need 24 kB.
const LONGEST_LINE: u64 = 1 << 20;

/// Most lines of a file that hold no sample: a second or two of reading. Fewer in tests, which have no second to spare.
pub(crate) const MOST_IDLE: usize = if cfg!(test) { 1000 } else { 10_000_000 };

/// One line of a text file, without its end.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    /// From 1.
    pub number: usize,
    pub text: String,
}

/// One cell, without the blanks and quotes around it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell<'a> {
    pub text: &'a str,
    /// Where it starts in its line, in bytes.
    offset: usize,
}

impl Cell<'_> {
    /// Column in characters from 1, and width in characters, at least 1.
    pub fn place(&self, line: &str) -> (usize, usize) {
        (line[..self.offset].chars().count() + 1, self.text.chars().count().max(1))
    }
}

/// The lines of a file one by one; the whole text is never in memory.
#[derive(Debug)]
pub(crate) struct Lines {
    path: PathBuf,
    reader: BufReader<std::fs::File>,
    number: usize,
    buffer: Vec<u8>,
    /// Lines that held nothing, or only a comment.
    idle: usize,
}

impl Lines {
    pub fn open(path: &Path) -> Result<Self> {
        Ok(Self { path: path.into(), reader: BufReader::new(open(path)?), number: 0, buffer: Vec::new(), idle: 0 })
    }

    /// The next line that holds something and is no `#` comment.
    pub fn next(&mut self) -> Result<Option<Line>> {
        loop {
            self.buffer.clear();
            let mut bounded = (&mut self.reader).take(LONGEST_LINE);
            let read =
                bounded.read_until(b'\n', &mut self.buffer).map_err(|e| Error::io(&self.path, Action::Reading, e))?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            self.check_bytes(read)?;
            let text = line(&self.buffer);
            if self.number == 1 && text.trim_end_matches(['\n', '\r']).contains('\r') {
                let message = "expected a line feed at the end of each line, found only carriage returns";
                return Err(Error::file(&self.path, message, "convert it: `tr '\\r' '\\n'`"));
            }
            let text = text.strip_prefix('\u{feff}').unwrap_or(&text).trim_end_matches(['\n', '\r']);
            if !text.trim().is_empty() && !text.trim_start().starts_with('#') {
                return Ok(Some(Line { number: self.number, text: text.to_owned() }));
            }
            self.idle += 1;
            if self.idle > MOST_IDLE {
                return Err(idle(&self.path, "empty lines"));
            }
        }
    }

    fn check_bytes(&self, read: usize) -> Result<()> {
        let refuse = |message: String, hint: &str| Err(Error::file(&self.path, message, hint));
        if self.buffer.contains(&0) {
            return refuse(
                format!("expected text, found a zero byte in line {}", self.number),
                "give a recording, or write the line again",
            );
        }
        if read as u64 == LONGEST_LINE && !self.buffer.ends_with(b"\n") {
            return refuse(
                format!("line {} is longer than {LONGEST_LINE} bytes", self.number),
                "give a CSV file with one sample a line",
            );
        }
        Ok(())
    }
}

/// The error for a file that has many lines and no sample.
pub(crate) fn idle(path: &Path, what: &str) -> Error {
    let message = format!("expected samples, found more than {MOST_IDLE} {what}");
    Error::file(path, message, "is this the right file? keep the lines that hold samples")
}

/// The separator that a header uses; `None` where it holds one cell. A tab wins over a semicolon, which wins over a comma,
/// because commas can be decimal marks.
pub(crate) fn separator(header: &str) -> Option<char> {
    ['\t', ';', ','].into_iter().find(|mark| header.contains(*mark))
}

/// The cells of a line. A quoted cell may hold the separator.
pub(crate) fn cells(line: &str, separator: Option<char>) -> Vec<Cell<'_>> {
    let mut cells = Vec::with_capacity(8);
    let mut start = 0;
    let mut quoted = false;
    // Quotes and separators are ASCII, so no byte of another sign is taken for one.
    let separator = separator.and_then(|mark| u8::try_from(mark).ok());
    for (at, mark) in line.bytes().enumerate() {
        if mark == b'"' {
            quoted = !quoted;
        } else if Some(mark) == separator && !quoted {
            cells.push(cell(line, start, at));
            start = at + 1;
        }
    }
    cells.push(cell(line, start, line.len()));
    cells
}

fn cell(line: &str, start: usize, end: usize) -> Cell<'_> {
    let raw = &line[start..end];
    let text = raw.trim_start();
    let mut offset = start + raw.len() - text.len();
    let mut text = text.trim_end();
    if text.len() >= 2 && text.starts_with('"') && text.ends_with('"') {
        text = &text[1..text.len() - 1];
        offset += 1;
    }
    Cell { text, offset }
}

/// Whether the first line holds names; a line of numbers is the first sample.
pub(crate) fn named(cells: &[Cell<'_>], separator: Option<char>) -> bool {
    cells.iter().any(|cell| !cell.text.is_empty() && number(cell.text, separator) == Err(NoNumber::Word))
}

/// Why a cell holds no number that can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoNumber {
    Word,
    NotFinite,
}

/// A finite number, or what is wrong with the cell; `true` is 1 and `false` is 0. A comma counts as the decimal mark where it is not the separator.
pub(crate) fn number(text: &str, separator: Option<char>) -> std::result::Result<f64, NoNumber> {
    let value = if separator != Some(',') && text.matches(',').count() == 1 && !text.contains('.') {
        text.replace(',', ".").parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match value {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(NoNumber::NotFinite),
        // As Python writes whether a motor is on.
        Err(_) if text.eq_ignore_ascii_case("true") => Ok(1.0),
        Err(_) if text.eq_ignore_ascii_case("false") => Ok(0.0),
        Err(_) => Err(NoNumber::Word),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_know_their_place() {
        let line = "0,1;\"a;b\" ; µ";
        let found = cells(line, Some(';'));
        assert_eq!(found.iter().map(|c| c.text).collect::<Vec<_>>(), ["0,1", "a;b", "µ"]);
        assert_eq!(found[1].place(line), (6, 3));
        assert_eq!(found[2].place(line), (13, 1));
    }

    #[test]
    fn numbers_are_finite_and_may_use_a_decimal_comma() {
        assert_eq!(number("1,25", Some(';')), Ok(1.25));
        assert_eq!(number("-1.5e-3", Some(',')), Ok(-0.0015));
        assert_eq!(number("nan", Some(',')), Err(NoNumber::NotFinite));
        assert_eq!(number("1e999", Some(',')), Err(NoNumber::NotFinite));
        assert_eq!((number("True", Some(',')), number("false", None)), (Ok(1.0), Ok(0.0)));
        assert_eq!(number("0.6b31", None), Err(NoNumber::Word));
        assert_eq!(number("1,234.5", Some(';')), Err(NoNumber::Word));
    }

    #[test]
    fn separators_are_detected() {
        assert_eq!(separator("t_s;z_m"), Some(';'));
        assert_eq!(separator("t_s\tz_m"), Some('\t'));
        assert_eq!(separator("t_s,z_m"), Some(','));
        assert_eq!(separator("bounce_time_s"), None);
    }
}
