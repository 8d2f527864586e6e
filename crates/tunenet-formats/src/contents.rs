//! What is in a file, whether or not it can be used.

use std::path::Path;

use crate::csv::columns::found;
use crate::csv::lines::{Lines, cells, named, separator};
use crate::csv::scan::scan;
use crate::csv::{dates, numbers, own_columns};
use crate::described::lacks_clock;
use crate::format::{Format, format};
use crate::log::files::{absent_parts, files, is_bag};
use crate::log::topics::{Topic, survey};
use crate::others;
use crate::place::{Place, is_data_set};
use crate::quantity::{Meaning, Quantity, meaning};
use crate::ranges::written_out;
use crate::recording::{ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::source::unchanged;
use crate::{Described, Episodes, Error, Result};
use tunenet_core::observation::{Channel, Kind, Note, plain};
use tunenet_core::statistics::median;

/// What is in a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// A text table.
    Table(Table),
    /// A log with topics: MCAP, or a bag of ROS 2.
    Log(Log),
    /// Recordings in several episodes.
    Episodes(Episodes),
}

/// A column of a text table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name in the header, empty where there is no header.
    pub name: String,
    /// The name under which it is read, `None` where it is not known.
    pub read_as: Option<String>,
}

/// A line that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BrokenLine {
    /// From 1.
    pub line: usize,
    /// What is wrong with it.
    pub message: String,
}

/// What is in a text table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The columns in their order.
    pub columns: Vec<Column>,
    /// The kind of observation it makes, or why it makes none.
    pub usable: std::result::Result<Kind, String>,
    /// What to try where it makes none; empty where nothing is known.
    pub remedy: String,
    /// Lines after the header that hold something.
    pub rows: usize,
    /// Good samples among them.
    pub samples: usize,
    /// First and last time in s.
    pub span_s: Option<(f64, f64)>,
    /// One over the median interval, in 1/s.
    pub median_rate_hz: Option<f64>,
    /// The longest interval, in s.
    pub largest_gap_s: Option<f64>,
    /// The first lines that cannot be used, at most ten.
    pub broken: Vec<BrokenLine>,
    /// How many lines cannot be used.
    pub broken_count: usize,
    /// What was noticed.
    pub notes: Vec<Note>,
    /// The channels that it is read on, where its columns are those of a simulation of one's own.
    pub channels: Vec<Channel>,
    /// Its columns by their numbers, where its names alone make no observation and it has a clock.
    pub described: Option<Described>,
}

/// What is in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The convention that its messages follow: `ros2`.
    pub profile: String,
    /// The program that wrote it.
    pub library: String,
    /// Its topics by name.
    pub topics: Vec<Topic>,
    /// What is missing.
    pub notes: Vec<Note>,
    /// Seconds from the first message to the last, by the times of recording; `None` without messages.
    pub span_s: Option<f64>,
    /// Where it is cut off or broken: what is wrong and how many messages came before. The topics count those.
    pub ended: Option<String>,
    /// What to try where it is; empty where nothing is known.
    pub remedy: String,
}

/// What is in the recording at `path`, in any format.
///
/// # Errors
/// [`Error::Io`] where the system refuses the file; [`Error::File`] where it is empty or of no known format.
pub fn contents(path: impl AsRef<Path>) -> Result<Contents> {
    contents_with(path, &ReadOptions::default())
}

/// As [`contents`], with the columns of a foreign table named; of a log, all topics are listed.
///
/// # Errors
/// As [`contents`].
pub fn contents_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Contents> {
    let path = path.as_ref();
    if path.is_dir() {
        return folder(path, options);
    }
    let place = Place::of(path);
    if place.episode.is_some() {
        return others::listing(&place, options).map(Contents::Episodes);
    }
    unchanged(&[path.to_owned()], || contents_once(path, options))
}

fn folder(path: &Path, options: &ReadOptions) -> Result<Contents> {
    if is_data_set(path) {
        return others::listing(&Place::of(path), options).map(Contents::Episodes);
    }
    if is_bag(path) {
        return unchanged(&files(path)?, || log(path, options));
    }
    Err(others::no_recording(path))
}

fn contents_once(path: &Path, options: &ReadOptions) -> Result<Contents> {
    let found = once(path, options)?;
    let (channels, described) = match &found {
        Contents::Table(table) if options.channels.is_empty() => {
            (table.own_channels(&options.columns), table.described.clone())
        }
        _ => (Vec::new(), None),
    };
    if channels.is_empty() {
        return Ok(found);
    }
    Ok(match once(path, &ReadOptions { channels: channels.clone(), ..options.clone() })? {
        Contents::Table(table) => Contents::Table(Table { channels, described, ..table }),
        other => other,
    })
}

fn once(path: &Path, options: &ReadOptions) -> Result<Contents> {
    match format(path)? {
        Format::Hdf5 => others::listing(&Place::of(path), options).map(Contents::Episodes),
        Format::Csv => {
            let found = table(path, options)?;
            if !found.may_be_described() {
                return Ok(Contents::Table(found));
            }
            let found = found.described_by(&numbers::sheet(path)?, options);
            Ok(Contents::Table(Table { remedy: dates::remedy(path)?.unwrap_or(found.remedy), ..found }))
        }
        Format::Mcap | Format::PackedMcap | Format::Bag => log(path, options),
        other => {
            let sheet = others::table(path, other)?;
            Ok(Contents::Table(sheet_table(path, &sheet, options)?.described_by(&sheet, options)))
        }
    }
}

/// What is in a table that is no text.
fn sheet_table(path: &Path, sheet: &Sheet, options: &ReadOptions) -> Result<Table> {
    let read_as = |name: &str| match meaning(name) {
        Meaning::Known(quantity, _) => Some(quantity.header()),
        _ => own_columns::header_of(name, &options.channels).or_else(|| own_columns::input_of(name, &options.others)),
    };
    let mapped = |name: &str| options.columns.iter().find(|(_, theirs)| theirs == name).map(|(ours, _)| ours.clone());
    let column = |name: &String| Column { name: name.clone(), read_as: mapped(name).or_else(|| read_as(name)) };
    let mut table = Table { rows: sheet.rows(), ..Table::of(sheet.names.iter().map(column).collect()) };
    match sheet.recording(path, options) {
        Ok(Recording { observation, notes }) => {
            let of_times = observation.kind() == Kind::EventTimes;
            let times = if of_times { observation.values() } else { observation.clock() };
            table.usable = Ok(observation.kind());
            table.samples = times.len();
            table.spans(times);
            table.notes = notes;
        }
        Err(Error::File { message, hint, .. }) => {
            (table.usable, table.remedy) = (Err(message), hint);
            table.notes.clone_from(&sheet.notes);
        }
        Err(error) => return Err(error),
    }
    Ok(table)
}

impl Table {
    /// One with these columns, of which nothing else is known.
    fn of(columns: Vec<Column>) -> Self {
        Self {
            columns,
            usable: Err(String::new()),
            remedy: String::new(),
            rows: 0,
            samples: 0,
            span_s: None,
            median_rate_hz: None,
            largest_gap_s: None,
            broken: Vec::new(),
            broken_count: 0,
            notes: Vec::new(),
            channels: Vec::new(),
            described: None,
        }
    }

    /// The same with its columns by their numbers, where its names do not say what it is and nothing else was asked for.
    fn described_by(mut self, sheet: &Sheet, options: &ReadOptions) -> Self {
        if !self.may_be_described() || !options.channels.is_empty() {
            return self;
        }
        if let Some((mut described, times)) = Described::of(sheet, &options.columns) {
            described.of_known_names |= !self.is_of_own_names();
            self.spans(&times);
            self.described = Some(described);
        } else if options.columns.is_empty()
            && self.is_of_own_names()
            && let Some(message) = lacks_clock(&sheet.names)
        {
            self.usable = Err(message);
            self.remedy = "save the times as a column of their own, or name it: `--columns t_s=COLUMN`".into();
        }
        self
    }

    /// Whether its columns make no observation by their names.
    fn may_be_described(&self) -> bool {
        self.usable.is_err() && (self.is_of_own_names() || !self.columns.iter().any(is_clock))
    }

    /// Whether nothing in it but a clock is known by its name.
    fn is_of_own_names(&self) -> bool {
        self.usable.is_err() && self.columns.iter().all(|column| column.read_as.is_none() || is_clock(column))
    }

    /// Of a table with a clock and nothing else that is known by its name, the columns that have a unit, by their names or by `mapped`:
    /// channels of a simulation of one's own.
    fn own_channels(&self, mapped: &[(String, String)]) -> Vec<Channel> {
        if !self.is_of_own_names() || !self.columns.iter().any(is_clock) {
            return Vec::new();
        }
        let is_time = |ours: &str| matches!(meaning(ours), Meaning::Known(Quantity::Time, _));
        let ours = mapped.iter().filter(|(ours, _)| !is_time(ours));
        let named = self.columns.iter().filter(|column| !is_clock(column) && !column.name.is_empty());
        let named = named.filter(|column| mapped.iter().all(|(_, theirs)| *theirs != column.name));
        let headers = ours.map(|(ours, _)| ours.clone()).chain(named.map(|column| column.name.clone()));
        let mut channels: Vec<Channel> = Vec::new();
        for channel in headers.filter_map(|header| Channel::from_header(&plain(&header))) {
            if channel.unit != "1" && !channels.contains(&channel) {
                channels.push(channel);
            }
        }
        channels
    }

    /// Takes in when its samples were.
    fn spans(&mut self, times: &[f64]) {
        self.span_s = times.first().copied().zip(times.last().copied());
        let intervals = times.windows(2).map(|pair| pair[1] - pair[0]);
        self.largest_gap_s = intervals.clone().max_by(f64::total_cmp);
        self.median_rate_hz = median(intervals).map(|interval| 1.0 / interval);
    }
}

fn is_clock(column: &Column) -> bool {
    column.read_as.as_ref().is_some_and(|name| matches!(meaning(name), Meaning::Known(Quantity::Time, _)))
}

fn log(path: &Path, options: &ReadOptions) -> Result<Contents> {
    let found = survey(path, &options.definitions)?;
    let remedy = found.ended.as_ref().and_then(Error::hint).unwrap_or_default().to_owned();
    let ended = found.ended.map(|error| match error {
        Error::File { message, .. } => message,
        other => other.to_string(),
    });
    let span_s = found.log_ns.map(|(first, last)| last.saturating_sub(first) as f64 * 1e-9);
    let (profile, library, topics) = (found.profile, found.library, found.topics);
    let notes = absent_parts(&files(path)?).into_iter().collect();
    Ok(Contents::Log(Log { profile, library, topics, notes, span_s, ended, remedy }))
}

fn table(path: &Path, options: &ReadOptions) -> Result<Table> {
    let mut table = Table::of(columns(path, options)?);
    let scan = match scan(path, options) {
        Ok(scan) => scan,
        Err(Error::Text { message, hint, .. }) => {
            (table.usable, table.remedy, table.rows) = (Err(message), hint, rows(path)?);
            return Ok(table);
        }
        Err(error) => return Err(error),
    };
    table.usable = scan.check(false).map(|()| scan.layout.kind).map_err(|error| match error {
        Error::Text { line, message, hint, .. } => {
            table.remedy = hint;
            format!("line {line}: {message}")
        }
        other => other.to_string(),
    });
    let times = if scan.layout.kind == Kind::EventTimes { &scan.values } else { &scan.clock };
    table.rows = scan.rows;
    table.samples = times.len();
    table.spans(times);
    table.notes = scan.notes();
    table.broken_count = scan.broken_count;
    table.broken = scan.broken.into_iter().map(|b| BrokenLine { line: b.line, message: b.message }).collect();
    Ok(table)
}

/// How many samples a table without a known column could hold.
fn rows(path: &Path) -> Result<usize> {
    let mut lines = Lines::open(path)?;
    let Some(first) = lines.next()? else { return Ok(0) };
    let separator = separator(&first.text);
    let mut rows = usize::from(!named(&cells(&first.text, separator), separator));
    while lines.next()?.is_some() {
        rows += 1;
    }
    Ok(rows)
}

/// The columns of a text table.
///
/// # Errors
/// [`Error::Io`] where the system refuses, or a pair of `--columns` is none.
pub(crate) fn columns(path: &Path, options: &ReadOptions) -> Result<Vec<Column>> {
    let Some(first) = Lines::open(path)?.next()? else { return Ok(Vec::new()) };
    let read_as = |name: &str| match meaning(name) {
        Meaning::Known(Quantity::Time, _) => Some(Quantity::Time.header()),
        _ if !options.channels.is_empty() => {
            let of_input = || own_columns::input_of(name, &options.others);
            own_columns::header_of(name, &options.channels).or_else(of_input)
        }
        Meaning::Known(quantity, _) => Some(quantity.header()),
        _ => None,
    };
    let separator = separator(&first.text);
    let cells = cells(&first.text, separator);
    let named = named(&cells, separator);
    let name = |text: &str| if named { text.to_owned() } else { String::new() };
    let mut columns: Vec<Column> =
        cells.iter().map(|cell| Column { name: name(cell.text), read_as: read_as(cell.text) }).collect();
    let names: Vec<&str> = cells.iter().map(|cell| cell.text).collect();
    for (ours, theirs) in &written_out(&options.columns, if named { &names } else { &[] })? {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        let at = found(theirs, &names).map(|(at, _)| at);
        if let Some(column) = at.and_then(|at| columns.get_mut(at)) {
            column.read_as = read_as(ours).or_else(|| column.read_as.take());
        }
    }
    Ok(columns)
}
