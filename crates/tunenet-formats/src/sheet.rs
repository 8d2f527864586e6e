//! Named columns of numbers, from any file but a text: the same rules as for a CSV file make an observation of them.

#[cfg(feature = "logs")]
use std::collections::BTreeMap;
use std::path::Path;

use crate::csv::columns::{Header, Layout, Source, layout};
use crate::csv::lines::Line;
use crate::csv::own_columns;
use crate::findings;
use crate::recording::{LARGEST, ReadOptions, Recording};
use crate::shown::counted;
use crate::{Error, Result};
use tunenet_core::observation::{FEWEST_SAMPLES, Kind, Note, Observation};

/// Largest share of rows that may repeat the time before them, as in a CSV file.
const MOST_REPEATED: f64 = 0.05;

/// Rows that are examined where names alone do not decide.
const EXAMINED: usize = 10_000;
const EXAMINED_CELLS: usize = 1_000_000;

/// Columns of numbers with their names; a number that is not finite stands for a missing one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sheet {
    pub names: Vec<String>,
    /// The first column, where it stands apart: the clock of a recording whose file has it in another place, or nowhere.
    pub clock: Vec<f64>,
    /// Row by row, without a clock that stands apart.
    pub values: Vec<f64>,
    /// Whether the columns have no names, only numbers.
    pub unnamed: bool,
    /// What the file holds and the columns do not.
    pub notes: Vec<Note>,
}

/// How many rows most of several arrays have, of those with so many that they are a series; of equally many arrays, the larger number.
#[cfg(feature = "logs")]
pub(crate) fn most_common_rows(rows: impl Iterator<Item = usize>) -> Option<usize> {
    let mut times: BTreeMap<usize, usize> = BTreeMap::new();
    for rows in rows.filter(|rows| *rows >= FEWEST_SAMPLES) {
        *times.entry(rows).or_default() += 1;
    }
    times.into_iter().max_by_key(|(rows, times)| (*times, *rows)).map(|(rows, _)| rows)
}

impl Sheet {
    pub fn rows(&self) -> usize {
        if self.clock.is_empty() { self.values.len() / self.names.len().max(1) } else { self.clock.len() }
    }

    /// A number by its row and its column.
    fn cell(&self, row: usize, column: usize) -> f64 {
        let apart = usize::from(!self.clock.is_empty());
        match column.checked_sub(apart) {
            Some(column) => self.values[row * (self.names.len() - apart) + column],
            None => self.clock[row],
        }
    }

    /// The numbers of a column.
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> {
        (0..self.rows()).map(move |row| self.cell(row, column))
    }

    /// The names as the header of a table.
    fn line(&self) -> Line {
        let cell = |name: &String| -> String {
            name.chars().map(|c| if c.is_control() || c == '"' { '_' } else { c }).collect()
        };
        Line { number: 1, text: self.names.iter().map(cell).collect::<Vec<_>>().join("\t") }
    }

    /// How its columns make an observation.
    ///
    /// # Errors
    /// [`Error::File`] where they make none.
    pub fn layout(&self, path: &Path, options: &ReadOptions) -> Result<Layout> {
        let line = self.line();
        let columns = 0..self.names.len();
        let examined = self.rows().min(EXAMINED).min(EXAMINED_CELLS / self.names.len().max(1));
        let first = (0..examined).map(|row| columns.clone().map(|column| Some(self.cell(row, column))).collect());
        let rows: Vec<Vec<Option<f64>>> = first.collect();
        let separator = Some('\t');
        let (joints, rows) = (options.joints.as_slice(), Some(rows.as_slice()));
        let header = Header { path, line: &line, separator, named: !self.unnamed, joints, rows };
        let made = if options.channels.is_empty() {
            layout(&header, &options.columns)
        } else {
            own_columns::layout(&header, options)
        };
        made.map_err(|error| with_left_out(without_line(path, error), &self.notes))
    }

    /// The observation that its columns make.
    ///
    /// # Errors
    /// [`Error::File`] where the columns make none, or a number cannot be used.
    pub fn recording(&self, path: &Path, options: &ReadOptions) -> Result<Recording> {
        let layout = self.layout(path, options)?;
        let mut taken = Taken::default();
        for row in 0..self.rows() {
            taken.add(path, &layout, row, &|column| self.cell(row, column))?;
        }
        let mut recording = taken.finish(path, self, layout)?;
        recording.notes.extend(self.notes.iter().cloned());
        Ok(recording)
    }
}

/// An error of the header, which has no line here.
fn without_line(path: &Path, error: Error) -> Error {
    match error {
        Error::Text { message, hint, .. } => Error::file(path, message, hint),
        other => other,
    }
}

/// An error of columns, with what the file holds and the columns do not.
fn with_left_out(error: Error, notes: &[Note]) -> Error {
    let left_out = notes.iter().find(|note| note.kind == findings::COLUMNS_IGNORED);
    match (error, left_out) {
        (Error::File { path, message, hint }, Some(note)) => {
            Error::file(path, format!("{message}; {}", note.text), hint)
        }
        (other, _) => other,
    }
}

/// The rows that were taken.
#[derive(Default)]
struct Taken {
    clock: Vec<f64>,
    values: Vec<f64>,
    /// Rows left out for a missing number, and the first of them from 1.
    missing: (usize, usize),
    same: usize,
    /// Rows at the time of the one before that say something else, and the first of them from 1.
    repeated: (usize, usize),
}

impl Taken {
    fn add(&mut self, path: &Path, layout: &Layout, row: usize, cell: &dyn Fn(usize) -> f64) -> Result<()> {
        let read = |source: &Source| {
            let value = source.value(cell(source.column));
            if value.is_finite() && value.abs() > LARGEST {
                let (name, row) = (layout.header(source), row + 1);
                let message =
                    format!("`{name}` in row {row} is too large: expected at most {LARGEST:e}, found {value:e}");
                return Err(Error::file(path, message, "check the unit"));
            }
            Ok(value)
        };
        let time = layout.clock.as_ref().map(read).transpose()?;
        let sample = layout.values.iter().map(|source| source.as_ref().map_or(Ok(0.0), read));
        let sample = sample.collect::<Result<Vec<f64>>>()?;
        if !time.iter().chain(&sample).all(|value| value.is_finite()) {
            self.missing = (self.missing.0 + 1, if self.missing.0 == 0 { row + 1 } else { self.missing.1 });
            return Ok(());
        }
        // Without a clock, the values themselves are times.
        let now = time.unwrap_or_else(|| sample[0]);
        match self.clock.last() {
            Some(last) if now < *last => {
                let name = layout.clock.or(layout.values[0]).map_or_else(String::new, |source| layout.header(&source));
                let message = format!("`{name}` falls in row {}: expected more than {last:?}, found {now:?}", row + 1);
                Err(Error::file(path, message, "sort the rows by time, or give the parts as files of their own"))
            }
            Some(last) if now == *last => {
                if self.values.ends_with(&sample) {
                    self.same += 1;
                } else {
                    self.repeated = (self.repeated.0 + 1, if self.repeated.0 == 0 { row + 1 } else { self.repeated.1 });
                }
                Ok(())
            }
            _ => {
                self.clock.push(now);
                self.values.extend(sample);
                Ok(())
            }
        }
    }

    fn finish(self, path: &Path, sheet: &Sheet, mut layout: Layout) -> Result<Recording> {
        let rows = sheet.rows();
        let mut notes = std::mem::take(&mut layout.notes);
        if let (count @ 1.., first) = self.missing {
            let rows = counted(count, "row");
            let text = format!("{rows} left out for a number that is missing or not finite, the first in row {first}");
            notes.push(Note::new(findings::ROWS_EMPTY_CELL, text, ""));
        }
        if self.same > 0 {
            let text = format!("{} left out that repeat the row before", counted(self.same, "row"));
            notes.push(Note::new(findings::ROWS_REPEATED, text, ""));
        }
        if let (count @ 1.., first) = self.repeated {
            if count as f64 > MOST_REPEATED * rows as f64 {
                let message =
                    format!("the time repeats in {count} of {rows} rows, first in row {first}: expected a rising time");
                return Err(Error::file(path, message, "write the time with more digits, or choose another clock"));
            }
            let text =
                format!("{} left out at the time of the row before, the first in row {first}", counted(count, "row"));
            notes.push(Note::new(findings::CLOCK_REPEATED, text, "record the time with more digits"));
        }
        if self.clock.len() < FEWEST_SAMPLES {
            let read = layout.clock.iter().chain(layout.values.iter().flatten());
            let mut empty = read.filter(|source| (0..rows).all(|row| !sheet.cell(row, source.column).is_finite()));
            if let Some(source) = empty.next().filter(|_| rows >= FEWEST_SAMPLES) {
                let message = format!("expected numbers in `{}`, found none in {rows} rows", layout.header(source));
                return Err(Error::file(
                    path,
                    message,
                    "choose another column, or leave it out of the simulation file",
                ));
            }
            let message = format!("expected at least {FEWEST_SAMPLES} samples, found {}", self.clock.len());
            return Err(Error::file(path, message, "record for longer"));
        }
        let observation = match (layout.kind, layout.clock) {
            (Kind::EventTimes, None) => Observation::event_times(&layout.channels[0].name, self.values)?,
            (kind, _) => Observation::new(kind, layout.channels, self.clock, self.values)?,
        };
        Ok(Recording { observation, notes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};

    fn sheet(names: &[&str], values: &[f64]) -> Sheet {
        Sheet {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            values: values.to_vec(),
            ..Sheet::default()
        }
    }

    fn read(sheet: &Sheet, columns: &[(&str, &str)]) -> Result<Recording> {
        let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
        sheet.recording(Path::new("/a.parquet"), &ReadOptions { columns, ..ReadOptions::default() })
    }

    #[test]
    fn a_column_without_any_number_is_named() {
        let found = read(&sheet(&["t_s", "z_m"], &[0.0, f64::NAN, 1.0, f64::NAN, 2.0, f64::NAN]), &[]).unwrap_err();
        assert!(error_text(&found).0.ends_with("expected numbers in `z_m`, found none in 3 rows"), "{found}");
    }

    /// The same numbers as a text give the same observation.
    #[test]
    fn columns_mean_what_they_mean_in_a_text() {
        let (_folder, path) = file("a.csv", "t_ms,z_cm\n0,100\n500,50\n1000,0\n");
        let text = crate::read(&path, &ReadOptions::default()).unwrap();
        let found = read(&sheet(&["t_ms", "z_cm"], &[0.0, 100.0, 500.0, 50.0, 1000.0, 0.0]), &[]).unwrap();
        assert_eq!(found, text);
        let named = sheet(&["when", "linear.x"], &[0.0, 1.0, 1.0, 2.0, 2.0, 4.0]);
        let mapped = read(&named, &[("t_s", "when"), ("z_m", "-linear.x")]).unwrap();
        assert_eq!(mapped.observation.column(2).collect::<Vec<_>>(), [-1.0, -2.0, -4.0]);
    }

    #[test]
    fn a_clock_that_stands_apart_is_the_first_column() {
        let whole = sheet(&["t_s", "z_m", "b"], &[0.0, 1.0, 7.0, 0.5, 2.0, 8.0, 1.0, 4.0, 9.0]);
        let apart = Sheet { clock: vec![0.0, 0.5, 1.0], values: vec![1.0, 7.0, 2.0, 8.0, 4.0, 9.0], ..whole.clone() };
        assert_eq!(read(&apart, &[]).unwrap(), read(&whole, &[]).unwrap());
        assert_eq!(read(&apart, &[("z_m", "3")]).unwrap(), read(&whole, &[("z_m", "3")]).unwrap());
    }

    #[test]
    fn rows_without_a_number_are_left_out_and_a_falling_clock_is_refused() {
        let names = ["t_s", "z_m"];
        let found = read(&sheet(&names, &[0.0, 1.0, 0.5, f64::NAN, 1.0, 2.0, 2.0, 3.0, 2.0, 3.0]), &[]).unwrap();
        assert_eq!(found.observation.clock(), [0.0, 1.0, 2.0]);
        let kinds: Vec<_> = found.notes.iter().map(|note| note.kind).collect();
        assert_eq!(kinds, [findings::COLUMNS_ABSENT, findings::ROWS_EMPTY_CELL, findings::ROWS_REPEATED]);
        let (message, _) = error_text(&read(&sheet(&names, &[0.0, 1.0, 2.0, 2.0, 1.0, 3.0]), &[]).unwrap_err());
        assert_eq!(message, "a.parquet: `t_s` falls in row 3: expected more than 2.0, found 1.0");
        let (message, _) = error_text(&read(&sheet(&names, &[0.0, 1.0, 1.0, 1e11, 2.0, 3.0]), &[]).unwrap_err());
        assert_eq!(message, "a.parquet: `z_m` in row 2 is too large: expected at most 1e10, found 1e11");
        let (message, hint) = error_text(&read(&sheet(&["a", "b"], &[0.0, 1.0]), &[]).unwrap_err());
        assert!(message.starts_with("a.parquet: expected columns `t_s` and `z_m`"), "{message}");
        assert!(hint.contains("--columns"), "{hint}");
    }
}
