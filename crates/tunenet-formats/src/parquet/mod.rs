//! Parquet files: their columns of numbers, one group of rows at a time.
//!
//! Source: the format of Apache Parquet, read by the crate `parquet`; values of nested columns are distinguished by their definition
//! and repetition levels.

mod column;
mod pages;
mod promises;
mod values;

use std::collections::HashMap;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use parquet::basic::CompressionCodec;
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::statistics::Statistics;

use self::column::column;
pub(crate) use self::column::{Column, Holds};
use self::pages::Counted;
use self::values::Failure;
pub(crate) use self::values::Numbers;
use crate::documents::refuse_git_lfs_pointer;
use crate::findings;
use crate::recording::MOST_NUMBERS;
use crate::sheet::Sheet;
use crate::shown::list;
use crate::source::open;
use crate::{Action, Error, Result};
use tunenet_core::observation::Note;
use tunenet_core::text::visible;

/// Most columns of a file that are looked at.
const MOST_COLUMNS: usize = 10_000;

/// What this build unpacks: other methods need crates of their own.
const UNPACKED: [CompressionCodec; 4] =
    [CompressionCodec::UNCOMPRESSED, CompressionCodec::SNAPPY, CompressionCodec::GZIP, CompressionCodec::ZSTD];
/// What is tried where a column is compressed by another.
const REPACK: &str = "write the file again with zstd: `python3 -c \"import sys, pyarrow.parquet as p; \
    p.write_table(p.read_table(sys.argv[1]), sys.argv[2], compression='zstd')\" OLD.parquet NEW.parquet`";

/// What is tried where a file is broken.
const AGAIN: &str = "copy or download the file again";

/// An open file.
pub(crate) struct Parquet {
    path: PathBuf,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
    /// Where rows were read last, by the group and the place of the column.
    cursors: Mutex<HashMap<(usize, usize), Cursor>>,
}

/// A column of a group, at one of its rows: what follows is read without unpacking again what comes before.
struct Cursor {
    reader: ColumnReader,
    row: usize,
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
        Ok(Self { path: path.to_owned(), reader, columns, cursors: Mutex::default() })
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
        let found = self.read(column, &mut self.cursor(group, column)?, &(0..usize::MAX))?;
        self.expect(group, column, self.rows(group), found)
    }

    /// The same of some of its rows; those before them are not kept. Rows that follow the last ones are read from there on.
    ///
    /// # Errors
    /// As [`Self::numbers`].
    pub fn numbers_of(&self, group: usize, column: &Column, rows: &Range<usize>) -> Result<Numbers> {
        let key = (group, column.index);
        let known = || self.cursors.lock().unwrap_or_else(PoisonError::into_inner);
        let before = known().remove(&key).filter(|cursor| cursor.row <= rows.start);
        let mut cursor = before.map_or_else(|| self.cursor(group, column), Ok)?;
        let found = self.read(column, &mut cursor, rows)?;
        let found = self.expect(group, column, rows.len() as u64, found)?;
        let mut cursors = known();
        // One group is read after the other.
        cursors.retain(|(of, _), _| *of == group);
        cursors.insert(key, cursor);
        Ok(found)
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

    /// The beginning of a column of a group.
    fn cursor(&self, group: usize, column: &Column) -> Result<Cursor> {
        let codec = self.reader.metadata().row_group(group).column(column.index).compression_codec();
        if !UNPACKED.contains(&codec) {
            let message = format!(
                "column `{}` is compressed with {codec}: expected no compression, snappy, gzip or zstd",
                visible(&column.name)
            );
            return Err(Error::file(&self.path, message, REPACK));
        }
        self.check_pages(group, column)?;
        let rows = self.reader.get_row_group(group).map_err(|e| self.refused(column, e.into()))?;
        let pages = rows.get_column_page_reader(column.index).map_err(|e| self.refused(column, e.into()))?;
        let described = self.reader.metadata().file_metadata().schema_descr().column(column.index);
        let reader = get_column_reader(described, Box::new(Counted::new(pages, MOST_NUMBERS)));
        Ok(Cursor { reader, row: 0 })
    }

    /// Rows of a column from where the cursor is on; it is then behind them.
    fn read(&self, column: &Column, cursor: &mut Cursor, of: &Range<usize>) -> Result<Numbers> {
        let (levels, form) = (column.levels, column.form);
        let rows = (of.start - cursor.row, of.len());
        let found = match &mut cursor.reader {
            ColumnReader::BoolColumnReader(reader) => values::read(reader, levels, rows, |v| f64::from(u8::from(*v))),
            ColumnReader::Int32ColumnReader(reader) => {
                values::read(reader, levels, rows, |v| form.whole(i64::from(*v)))
            }
            ColumnReader::Int64ColumnReader(reader) => values::read(reader, levels, rows, |v| form.whole(*v)),
            ColumnReader::FloatColumnReader(reader) => values::read(reader, levels, rows, |v| f64::from(*v)),
            ColumnReader::DoubleColumnReader(reader) => values::read(reader, levels, rows, |v| *v),
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                values::read(reader, levels, rows, |v| form.bytes(v.data()))
            }
            ColumnReader::ByteArrayColumnReader(reader) => values::read(reader, levels, rows, |v| form.bytes(v.data())),
            ColumnReader::Int96ColumnReader(_) => Err(ParquetError::General("no column of numbers".into()).into()),
        };
        let found = found.map_err(|failure| self.refused(column, failure))?;
        cursor.row = of.start + found.rows;
        Ok(found)
    }

    /// Why a column cannot be read.
    fn refused(&self, column: &Column, failure: Failure) -> Error {
        let refuse = |why: String, hint: &str| {
            Error::file(&self.path, format!("column `{}` cannot be read: {why}", visible(&column.name)), hint)
        };
        match failure {
            Failure::Broken(ParquetError::General(why) | ParquetError::NYI(why)) => refuse(why, AGAIN),
            Failure::Broken(other) => broken(&self.path, &other),
            Failure::TooMany(why) => refuse(why, "keep the rows and columns that are needed"),
            Failure::Uneven(why) => refuse(why, "write lists of one length, or leave the column out"),
        }
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
