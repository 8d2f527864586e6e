//! The files that observations come in: CSV and MCAP.
//!
//! [`read`] finds out what a file is by looking into it, then what kind of observation its columns or messages make, and
//! returns the [`Recording`]: the observation and what was noticed on the way. [`contents`] lists what is in a file without
//! asking it to be usable. [`write_csv`] and [`write_mcap`] are their counterparts; both replace a file in one step.
//!
//! | file | subject |
//! |---|---|
//! | `lines`, `quantity`, `columns`, `scan`, `csv`, `bounces` | text: lines and cells, what a column is, what the columns make, the numbers, an observation from them |
//! | `mcap_read`, `topics`, `message`, `ros`, `json`, `joints`, `mcap_series`, `stamps` | MCAP: records, topics, messages, an observation from them |
//! | `csv_write`, `mcap_write`, `definitions`, `atomic` | writing |
//! | `contents` | the listing |

mod atomic;
mod bounces;
mod columns;
mod contents;
mod csv;
mod csv_write;
mod definitions;
mod joints;
mod json;
mod lines;
mod mcap_read;
mod mcap_series;
mod mcap_write;
mod message;
mod quantity;
mod ros;
mod scan;
mod stamps;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod topics;

use std::io::Read as _;
use std::path::Path;

pub use atomic::write_atomically;
pub use contents::{BrokenLine, Column, Contents, Log, Table, contents, contents_with};
pub use csv_write::write_csv;
#[allow(unused_imports, reason = "the reader of other files made of messages")]
pub(crate) use mcap_read::{ChannelInfo, Messages, RawMessage, messages};
pub use mcap_write::write_mcap;
pub use topics::Topic;

use super::{Note, Observation};
use crate::{Error, Result};

/// Most numbers of one observation; a file with more is refused, since fitting would not end.
pub const MOST_NUMBERS: usize = 20_000_000;

/// Greatest size of a number in an observation, in SI units: seconds since 1970 fit, and nothing that a person measures
/// is larger.
pub const LARGEST: f64 = 1e10;

/// An observation from a file, and what was noticed while reading it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// What was seen.
    pub observation: Observation,
    /// What the reader did that a person may want to know, in the order in which it was noticed.
    pub notes: Vec<Note>,
}

/// How to read a file that does not speak this project's names.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Pairs (ours, theirs): ours is a column name with its unit (`t_s`, `z_mm`), theirs a name from the file's header, or
    /// a column number from 1. For CSV alone.
    pub columns: Vec<(String, String)>,
    /// The MCAP topic to read; `None` takes the only one that can be used.
    pub topic: Option<String>,
}

/// What a file is, judged by its first bytes and, where they say nothing, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Mcap,
}

/// The observation in a CSV or MCAP file.
///
/// # Errors
/// [`Error::Io`] where the system refuses the file, [`Error::Text`] where a line of a CSV file cannot be used,
/// [`Error::File`] where the file as a whole cannot, [`Error::Setting`] where `options` contradict themselves, and
/// [`Error::Observation`] where the numbers make no observation.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Recording> {
    let path = path.as_ref();
    match format(path)? {
        Format::Csv if options.topic.is_some() => Err(Error::Setting {
            name: "topic",
            expected: "an MCAP file".into(),
            found: format!("the text file {}", path.display()),
        }),
        Format::Csv => csv::read(path, &options.columns),
        Format::Mcap if !options.columns.is_empty() => Err(Error::Setting {
            name: "columns",
            expected: "a CSV file".into(),
            found: format!("the MCAP file {}", path.display()),
        }),
        Format::Mcap => {
            let recording = mcap_series::read(path, options.topic.as_deref())?;
            refuse_too_large(path, &recording.observation)?;
            Ok(recording)
        }
    }
}

/// Numbers beyond [`LARGEST`] are refused with their sample.
fn refuse_too_large(path: &Path, seen: &Observation) -> Result<()> {
    let width = seen.channels().len();
    let Some(at) = seen.values().iter().position(|v| v.abs() > LARGEST) else { return Ok(()) };
    let (channel, sample, found) = (&seen.channels()[at % width].name, at / width + 1, seen.values()[at]);
    let message = format!("`{channel}` at sample {sample} is too large: expected at most {LARGEST:e}, found {found:e}");
    Err(Error::file(path, message, "check the unit, or leave the message out"))
}

/// Content first: an MCAP file under any name is read as one, and a text file named `.mcap` is not called empty.
fn format(path: &Path) -> Result<Format> {
    let mut start = Vec::new();
    open(path)?.take(512).read_to_end(&mut start).map_err(|e| Error::io(path, "reading", e))?;
    let named_mcap = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
    if start.starts_with(mcap::MAGIC) {
        return Ok(Format::Mcap);
    }
    if named_mcap {
        let message = if start.is_empty() {
            "expected an MCAP file, found an empty one".to_owned()
        } else if mcap::MAGIC.starts_with(&start) {
            format!("the file ends after {} bytes, in the middle of its first mark", start.len())
        } else {
            "expected the mark of an MCAP file at its start, found other bytes".to_owned()
        };
        return Err(Error::file(path, message, "copy the recording again, or name a text file `.csv`"));
    }
    let other = [
        (&b"SQLite format 3"[..], "a ROS 2 bag in SQLite form", "convert it with `ros2 bag convert` to MCAP"),
        (b"#ROSBAG V2.0", "a ROS 1 bag", "convert it with `mcap convert` and record ROS 2 messages"),
        (b"PK\x03\x04", "a zip archive or a spreadsheet", "unpack it, or export the sheet as CSV"),
        (b"\x1f\x8b", "a gzip archive", "unpack it first"),
        (b"\x28\xb5\x2f\xfd", "a zstd archive", "unpack it first"),
    ];
    if let Some((_, what, hint)) = other.iter().find(|(mark, ..)| start.starts_with(mark)) {
        return Err(Error::file(path, format!("expected CSV or MCAP, found {what}"), *hint));
    }
    Ok(Format::Csv)
}

/// Opens a file and refuses a folder, which some systems open without complaint.
fn open(path: &Path) -> Result<std::fs::File> {
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, "opening", e))?;
    let about = file.metadata().map_err(|e| Error::io(path, "opening", e))?;
    if about.is_dir() {
        return Err(Error::file(path, "expected a file, found a folder", "name one file in it"));
    }
    Ok(file)
}

/// `a`, `b` and `c` in backquotes, at most `most` of them.
fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = names.iter().take(most).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(most) {
        0 if shown.is_empty() => "none".into(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
