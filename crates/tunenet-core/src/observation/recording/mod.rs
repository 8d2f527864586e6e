//! The files that observations come in: CSV and MCAP.
//!
//! [`read`] finds out what a file is by looking into it, then what kind of observation its columns or messages make, and
//! returns the [`Recording`]: the observation and what was noticed on the way. [`contents`] lists what is in a file without
//! asking it to be usable. [`write_csv`] and [`write_mcap`] are their counterparts; both replace a file in one step.
//!
//! | file | subject |
//! |---|---|
//! | `lines`, `quantity`, `ranges`, `columns`, `own_columns`, `guess`, `guess_joints`, `scan`, `csv`, `bounces` | text: lines and cells, what a column is, ranges of columns, what the columns make, for a simulator of one's own as well, or could make, the numbers, an observation from them |
//! | `mcap_read`, `whole_chunks`, `topics`, `message`, `ros`, `json`, `joints`, `mcap_series`, `stamps` | MCAP: records, chunks that hold whole ones, topics, messages, an observation from them |
//! | `source`, `encoding` | the file itself: what is opened, whether it changed meanwhile, and how its text is written |
//! | `csv_write`, `mcap_write`, `approach_write`, `definitions`, `atomic` | writing |
//! | `contents` | the listing |

mod approach_write;
mod atomic;
mod bounces;
mod columns;
mod contents;
mod csv;
mod csv_write;
mod definitions;
mod encoding;
mod guess;
mod guess_joints;
mod joints;
mod json;
mod lines;
mod mcap_read;
mod mcap_series;
mod mcap_write;
mod message;
mod own_columns;
pub mod pictures;
mod quantity;
mod ranges;
mod ros;
mod scan;
mod source;
mod stamps;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod topics;
mod whole_chunks;

use std::io::Read as _;
use std::path::Path;

pub use approach_write::{JointPoint, write_approach};
pub use atomic::write_atomically;
pub use contents::{BrokenLine, Column, Contents, Log, Table, contents, contents_with};
pub use csv_write::write_csv;
pub use encoding::read_text;
#[allow(unused_imports, reason = "the reader of other files made of messages")]
pub(crate) use mcap_read::{ChannelInfo, Fault, Messages, RawMessage, messages, messages_up_to};
pub use mcap_write::write_mcap;
pub use source::open;
pub use topics::Topic;

use super::{Channel, Note, Observation};
use crate::{Error, Result};
use source::LARGEST_TEXT;

/// Most numbers of one observation, its clock apart: ten million positions and a third more. A file with more is refused,
/// since it would take gigabytes of memory.
pub const MOST_NUMBERS: usize = 40_000_000;

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
    /// a column number from 1; for joints also ranges, (`q1..6_rad`, `2..7`) or (`q1..6_rad`, `joint_*`). For CSV alone.
    pub columns: Vec<(String, String)>,
    /// The MCAP topic to read; `None` takes the only one that can be used.
    pub topic: Option<String>,
    /// Leave lines of a CSV file out that cannot be used, as long as they are few, instead of refusing the file.
    pub skip_broken: bool,
    /// Names of joints, in the order in which they are to be numbered: those of messages are matched to them, and hints on the
    /// columns of a CSV file speak of them. Where empty, the first message decides.
    pub joints: Vec<String>,
    /// The channels that a simulator of one's own predicts, in its order: they are looked for by their
    /// [headers](Channel::header), and the series becomes one of [`Kind::Other`](super::Kind::Other). Empty where the file's
    /// columns or messages decide.
    pub channels: Vec<Channel>,
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
    source::unchanged(path, || read_once(path, options))
}

fn read_once(path: &Path, options: &ReadOptions) -> Result<Recording> {
    match format(path)? {
        Format::Csv if options.topic.is_some() => Err(Error::Setting {
            name: "topic",
            expected: "an MCAP file".into(),
            found: format!("the text file {}", path.display()),
        }),
        Format::Csv => csv::read(path, options),
        Format::Mcap if !options.columns.is_empty() => Err(Error::Setting {
            name: "columns",
            expected: "a CSV file".into(),
            found: format!("the MCAP file {}", path.display()),
        }),
        Format::Mcap => {
            let recording = mcap_series::read(path, options.topic.as_deref(), &options.joints)?;
            refuse_too_large(path, &recording.observation)?;
            if options.channels.is_empty() {
                Ok(recording)
            } else {
                own_columns::chosen(path, recording, &options.channels)
            }
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

/// Files of other kinds: where in them their mark stands, the mark, what they are, and what to do.
const OTHERS: [(usize, &[u8], &str, &str); 15] = [
    (0, b"SQLite format 3", "a ROS 2 bag in SQLite form", "convert it with `ros2 bag convert` to MCAP"),
    (0, b"#ROSBAG V2.0", "a ROS 1 bag", "convert it with `mcap convert` and record ROS 2 messages"),
    (0, b"PK\x03\x04", "a zip archive or a spreadsheet", "unpack it, or export the sheet as CSV"),
    (0, b"\xd0\xcf\x11\xe0", "an old spreadsheet", "export the sheet as CSV"),
    (0, b"\x1f\x8b", "a gzip archive", "unpack it first"),
    (0, b"\x28\xb5\x2f\xfd", "a zstd archive", "unpack it first"),
    (0, b"\xfd7zXZ\0", "an xz archive", "unpack it first"),
    (0, b"\x89PNG", "a picture", "give the numbers that were measured, as CSV"),
    (0, b"\xff\xd8\xff", "a picture", "give the numbers that were measured, as CSV"),
    (0, b"%PDF", "a PDF document", "give the numbers that were measured, as CSV"),
    (4, b"ftyp", "a video", "give the positions that were seen in it, as CSV"),
    (0, b"\x89HDF", "an HDF5 file", "export the series as CSV"),
    (0, b"MATLAB 5.0", "a MATLAB file", "export the series as CSV"),
    (0, b"\x93NUMPY", "a NumPy array", "save it as CSV, for example with `numpy.savetxt`"),
    (0, b"PAR1", "a Parquet file", "save it as CSV"),
];

/// Content first: an MCAP file under any name is read as one, and a text file named `.mcap` is not called empty.
fn format(path: &Path) -> Result<Format> {
    let mut start = Vec::new();
    let file = open(path)?;
    let bytes = file.metadata().map_err(|e| Error::io(path, "reading", e))?.len();
    file.take(512).read_to_end(&mut start).map_err(|e| Error::io(path, "reading", e))?;
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
    if let Some((_, _, what, hint)) =
        OTHERS.iter().find(|(at, mark, ..)| start.get(*at..).is_some_and(|s| s.starts_with(mark)))
    {
        return Err(Error::file(path, format!("expected CSV or MCAP, found {what}"), *hint));
    }
    encoding::refuse_foreign(path, &start)?;
    if bytes > LARGEST_TEXT {
        let message = format!("expected at most {LARGEST_TEXT} bytes of text, found {bytes}");
        let hint = "keep the columns that are needed, for example `cut -d, -f1,4`, or cut the file into pieces";
        return Err(Error::file(path, message, hint));
    }
    Ok(Format::Csv)
}

/// `a`, `b` and `c` in backquotes, at most `most` of them.
fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = names.iter().take(most).map(|name| format!("`{}`", shortened(name))).collect();
    match names.len().saturating_sub(most) {
        0 if shown.is_empty() => "none".into(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Most characters of a user's text that a message repeats.
const LONGEST_SHOWN: usize = 40;

/// The text, cut where it is too long for a message.
fn shortened(text: &str) -> std::borrow::Cow<'_, str> {
    match text.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}
