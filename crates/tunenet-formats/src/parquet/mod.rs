//! Parquet files: their columns of numbers, one group of rows at a time.
//!
//! Source: the format of Apache Parquet, read by the crate `parquet`; values of nested columns are distinguished by their definition
//! and repetition levels.

mod pages;
mod promises;
mod values;

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, TimestampType, Type as Physical};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescriptor;

use self::pages::Counted;
use self::values::Levels;
pub(crate) use self::values::Numbers;
use crate::documents::refuse_git_lfs_pointer;
use crate::findings;
use crate::recording::MOST_NUMBERS;
use crate::ros::stamps::to_s;
use crate::sheet::Sheet;
use crate::shown::list;
use crate::source::open;
use crate::{Action, Error, Result};
use tunenet_core::observation::Note;

/// Most columns of a file that are looked at.
const MOST_COLUMNS: usize = 10_000;

/// What is tried where a file is broken.
const AGAIN: &str = "copy or download the file again";

/// An open file.
pub(crate) struct Parquet {
    path: PathBuf,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
}

/// A column of numbers, or of as many numbers in each row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub of: Holds,
    index: usize,
    levels: Levels,
}

impl Column {
    /// What it is called in a table, with `width` numbers in each row.
    fn names(&self, width: usize) -> Vec<String> {
        match self.of {
            Holds::List => (0..width).map(|i| format!("{}.{i}", self.name)).collect(),
            Holds::Instant(_) if !self.name.ends_with("_s") => vec![format!("{}_s", self.name)],
            _ => vec![self.name.clone()],
        }
    }
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holds {
    /// One number in each row.
    Number,
    /// One instant in each row: so many of its ticks are a second.
    Instant(i64),
    /// A list of numbers in each row.
    List,
    /// Anything else.
    Other,
}

impl Parquet {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses; [`Error::File`] where it is no Parquet file, or a broken one.
    pub fn open(path: &Path) -> Result<Self> {
        refuse_git_lfs_pointer(path)?;
        let mut file = open(path)?;
        let promised = promises::footer_promises(&mut file).map_err(|e| Error::io(path, Action::Reading, e))?;
        refuse_promise(path, promised)?;
        let reader = SerializedFileReader::new(file).map_err(|e| broken(path, &e))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        if schema.num_columns() > MOST_COLUMNS {
            let message = format!("expected at most {MOST_COLUMNS} columns, found {}", schema.num_columns());
            return Err(Error::file(path, message, "keep the columns that are needed"));
        }
        let columns = schema.columns().iter().enumerate().map(|(index, described)| column(index, described)).collect();
        Ok(Self { path: path.to_owned(), reader, columns })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The column of this name.
    ///
    /// # Errors
    /// [`Error::File`] where there is none.
    pub fn column(&self, name: &str) -> Result<&Column> {
        let found = self.columns.iter().find(|column| column.name == name && column.of != Holds::Other);
        found.ok_or_else(|| {
            let found = match self.columns.iter().find(|column| column.name == name) {
                Some(_) => "one that holds something else".to_owned(),
                None => crate::shown::list(self.columns.iter().map(|column| column.name.as_str()), 12),
            };
            let message = format!("expected a column `{name}` of numbers, found {found}");
            Error::file(&self.path, message, "is this the right file?")
        })
    }

    /// How many groups of rows there are.
    pub fn groups(&self) -> usize {
        self.reader.metadata().num_row_groups()
    }

    /// How many rows a group says that it has. It may say anything: its columns know.
    fn rows(&self, group: usize) -> u64 {
        u64::try_from(self.reader.metadata().row_group(group).num_rows()).unwrap_or(0)
    }

    /// The numbers of a column in a group of rows.
    ///
    /// # Errors
    /// [`Error::File`] where they are broken, too many, or not as many in each row.
    pub fn numbers(&self, group: usize, column: &Column) -> Result<Numbers> {
        let found = self.read(group, column, &(0..usize::MAX))?;
        self.expect(group, column, self.rows(group), found)
    }

    /// The same of some of its rows; those before them are not kept.
    ///
    /// # Errors
    /// As [`Self::numbers`].
    pub fn numbers_of(&self, group: usize, column: &Column, rows: &Range<usize>) -> Result<Numbers> {
        self.expect(group, column, rows.len() as u64, self.read(group, column, rows)?)
    }

    /// Whether a column of a group may hold a number, as far as the file states the least and the greatest of them.
    pub fn may_hold(&self, group: usize, column: &Column, number: u64) -> bool {
        match self.reader.metadata().row_group(group).column(column.index).statistics() {
            Some(Statistics::Int64(stated)) => {
                let number = i64::try_from(number).unwrap_or(i64::MAX);
                stated.min_opt().is_none_or(|least| *least <= number)
                    && stated.max_opt().is_none_or(|greatest| *greatest >= number)
            }
            _ => true,
        }
    }

    /// Refuses pages that promise more than they hold, or that are nowhere.
    fn check_pages(&self, group: usize, column: &Column) -> Result<()> {
        let chunk = self.reader.metadata().row_group(group).column(column.index);
        let begin = chunk.dictionary_page_offset().unwrap_or(i64::MAX).min(chunk.data_page_offset());
        // The crate panics where one of them is below 0.
        let (Ok(begin), Ok(length)) = (u64::try_from(begin), u64::try_from(chunk.compressed_size())) else {
            let message = format!("column `{}` cannot be read: its pages have no place in the file", column.name);
            return Err(Error::file(&self.path, message, AGAIN));
        };
        let promised = promises::pages_promise(&mut open(&self.path)?, begin, length);
        refuse_promise(&self.path, promised.map_err(|e| Error::io(&self.path, Action::Reading, e))?)
    }

    fn read(&self, group: usize, column: &Column, of: &Range<usize>) -> Result<Numbers> {
        self.check_pages(group, column)?;
        let read = || -> std::result::Result<Numbers, ParquetError> {
            let rows = self.reader.get_row_group(group)?;
            let described = self.reader.metadata().file_metadata().schema_descr().column(column.index);
            let pages = Counted::new(rows.get_column_page_reader(column.index)?, MOST_NUMBERS);
            let reader = get_column_reader(described, Box::new(pages));
            let levels = column.levels;
            let seconds = |ticks: i64, a_second: i64| {
                // Nanoseconds keep their last digit.
                ticks.checked_mul(1_000_000_000 / a_second).map_or(ticks as f64 / a_second as f64, to_s)
            };
            match (reader, column.of) {
                (ColumnReader::BoolColumnReader(reader), _) => {
                    values::read(reader, levels, of, |v| f64::from(u8::from(*v)))
                }
                (ColumnReader::Int32ColumnReader(reader), _) => values::read(reader, levels, of, |v| f64::from(*v)),
                (ColumnReader::Int64ColumnReader(reader), Holds::Instant(a_second)) => {
                    values::read(reader, levels, of, |v| seconds(*v, a_second))
                }
                (ColumnReader::Int64ColumnReader(reader), _) => values::read(reader, levels, of, |v| *v as f64),
                (ColumnReader::FloatColumnReader(reader), _) => values::read(reader, levels, of, |v| f64::from(*v)),
                (ColumnReader::DoubleColumnReader(reader), _) => values::read(reader, levels, of, |v| *v),
                _ => Err(ParquetError::General("no column of numbers".into())),
            }
        };
        read().map_err(|e| match e {
            ParquetError::General(why) | ParquetError::NYI(why) => {
                Error::file(&self.path, format!("column `{}` cannot be read: {why}", column.name), AGAIN)
            }
            other => broken(&self.path, &other),
        })
    }

    /// `found`, where it has as many rows as are expected.
    fn expect(&self, group: usize, column: &Column, expected: u64, found: Numbers) -> Result<Numbers> {
        if found.rows as u64 == expected {
            return Ok(found);
        }
        let found = found.rows;
        let message = format!("column `{}`: expected {expected} rows in group {group}, found {found}", column.name);
        Err(Error::file(&self.path, message, AGAIN))
    }

    /// What the columns of the whole file are called as one table. Of lists, the first group of rows is read.
    ///
    /// # Errors
    /// As [`Self::numbers`].
    pub fn column_names(&self) -> Result<Vec<String>> {
        let mut names = Vec::new();
        for column in self.columns.iter().filter(|column| column.of != Holds::Other) {
            let list = column.of == Holds::List && self.groups() > 0;
            names.extend(column.names(if list { self.numbers(0, column)?.width } else { 1 }));
        }
        Ok(names)
    }

    /// The whole file as one table: a list of numbers is as many columns, `NAME.0` …
    ///
    /// # Errors
    /// As [`Self::numbers`].
    pub fn sheet(&self) -> Result<Sheet> {
        let mut whole = Sheet { notes: self.left_out().into_iter().collect(), ..Sheet::default() };
        let too_many = || {
            let message = format!("expected at most {MOST_NUMBERS} numbers, found more");
            Error::file(&self.path, message, "keep the rows and columns that are needed")
        };
        for group in 0..self.groups() {
            let (mut names, mut columns): (Vec<String>, Vec<Numbers>) = (Vec::new(), Vec::new());
            let mut count = whole.values.len();
            for column in self.columns.iter().filter(|column| column.of != Holds::Other) {
                let found = self.numbers(group, column)?;
                count += found.values.len();
                if count > MOST_NUMBERS {
                    return Err(too_many());
                }
                names.extend(column.names(found.width));
                columns.push(found);
            }
            if group > 0 && names != whole.names {
                let message = format!("expected lists of one length, found others in group {group} of rows");
                return Err(Error::file(&self.path, message, "write lists of one length"));
            }
            whole.names = names;
            whole.values.reserve(count - whole.values.len());
            for row in 0..columns.first().map_or(0, |found| found.rows) {
                for Numbers { values, width, .. } in &columns {
                    whole.values.extend_from_slice(&values[row * width..(row + 1) * width]);
                }
            }
        }
        Ok(whole)
    }

    /// Which columns hold no numbers.
    fn left_out(&self) -> Option<Note> {
        let others: Vec<&str> =
            self.columns.iter().filter(|column| column.of == Holds::Other).map(|column| column.name.as_str()).collect();
        let text = format!("columns that hold no numbers are left out: {}", list(others.iter().copied(), 6));
        (!others.is_empty()).then(|| Note::new(findings::COLUMNS_IGNORED, text, "write them as numbers if they matter"))
    }
}

/// A column of the schema. A list is named as its field is, not as what Parquet calls its elements.
fn column(index: usize, described: &ColumnDescriptor) -> Column {
    let (definition, repetition) = (described.max_def_level(), described.max_rep_level());
    let levels = Levels { definition, repetition, optional: described.self_type().is_optional() };
    let parts = described.path().parts();
    let list = levels.repetition == 1;
    let named = if list { &parts[..1.max(parts.len().saturating_sub(2))] } else { parts };
    let ticks = match (described.logical_type_ref(), described.converted_type()) {
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::MILLIS, .. })), _)
        | (_, ConvertedType::TIMESTAMP_MILLIS) => 1_000,
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::MICROS, .. })), _)
        | (_, ConvertedType::TIMESTAMP_MICROS) => 1_000_000,
        (Some(LogicalType::Timestamp(TimestampType { unit: TimeUnit::NANOS, .. })), _) => 1_000_000_000,
        _ => 0,
    };
    let decimal = described.converted_type() == ConvertedType::DECIMAL;
    let of = match described.physical_type() {
        _ if levels.repetition > 1 || decimal => Holds::Other,
        Physical::INT64 if ticks > 0 && !list => Holds::Instant(ticks),
        Physical::BOOLEAN | Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE => {
            if list {
                Holds::List
            } else {
                Holds::Number
            }
        }
        Physical::INT96 | Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => Holds::Other,
    };
    Column { name: named.join("."), of, index, levels }
}

fn refuse_promise(path: &Path, promised: Option<u64>) -> Result<()> {
    let Some(count) = promised else { return Ok(()) };
    let message = format!("the Parquet file is broken: a list in it promises {count} elements, more than it has bytes");
    Err(Error::file(path, message, AGAIN))
}

/// What is wrong with a file that the crate refuses.
fn broken(path: &Path, error: &ParquetError) -> Error {
    let why = match error {
        ParquetError::General(why) | ParquetError::NYI(why) | ParquetError::EOF(why) => why.clone(),
        ParquetError::NeedMoreData(_) | ParquetError::NeedMoreDataRange(_) => "the file is cut off".into(),
        other => other.to_string(),
    };
    Error::file(path, format!("the Parquet file is cut off or broken: {why}"), AGAIN)
}

#[cfg(test)]
mod tests;
