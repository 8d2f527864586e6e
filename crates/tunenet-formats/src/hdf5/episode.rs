//! The columns of one episode.

use std::path::Path;

use serde_json::Value;

use super::actions::not_joints;
use super::links::links;
use super::tree::{Array, Columns, arrays_and_others};
use super::{COPY, Demonstrations, listed};
use crate::findings;
use crate::quantity::{Meaning, Quantity, meaning};
use crate::recording::{ReadOptions, Recording};
use crate::unstated::Unstated;
use crate::{Error, Result};
use tunenet_core::observation::Note;

/// What arrays of times are called where they do not say their unit.
const TIMES: [&str; 5] = ["timestamp", "timestamps", "time", "times", "t"];

/// Whether a column holds times: its name has their unit, or it is mapped with one.
pub(super) fn is_clock(name: &str, options: &ReadOptions) -> bool {
    let is_time = |name: &str| matches!(meaning(name), Meaning::Known(Quantity::Time, _));
    is_time(name) || options.columns.iter().any(|(ours, theirs)| is_time(ours) && theirs == name)
}

/// Whether a column is called as times are, without their unit.
pub(super) fn is_named_after_time(name: &str) -> bool {
    TIMES.contains(&name.rsplit('.').next().unwrap_or_default())
}

/// What is left out of an episode, with the links below it that are not followed.
fn with_links(left_out: Option<Note>, links: &[(String, String)]) -> Option<Note> {
    if links.is_empty() {
        return left_out;
    }
    let before = left_out.map_or_else(String::new, |note| format!("{}; ", note.text));
    let text = format!("{before}links are not followed: {}", listed(links));
    Some(Note::new(findings::COLUMNS_IGNORED, text, COPY))
}

/// The clock of so many rows at this rate, and what it is called.
fn counted_at(rate: f64, rows: usize) -> (String, Vec<f64>) {
    ("t_s".to_owned(), (0..rows).map(|row| row as f64 / rate).collect())
}

impl Demonstrations {
    /// The observation that an episode makes, with its columns in the units that `options` say.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode, it has no time base, or a column is asked for whose unit nothing states.
    pub fn read(&self, path: &Path, name: Option<&str>, options: &ReadOptions) -> Result<Recording> {
        let mut columns = self.columns(self.group(name)?, &|name| is_clock(name, options))?;
        let (clock, note) = match (options.rate_hz, columns.clocks.is_empty()) {
            (None, false) => (columns.clocks.swap_remove(0), None),
            (Some(rate), _) => (counted_at(rate, columns.rows), None),
            (None, true) => match self.rate() {
                Some(rate) => {
                    let text = format!(
                        "the clock is the number of each row over {rate} Hz, which the file states: jitter is not in it"
                    );
                    (counted_at(rate, columns.rows), Some(Note::new(findings::CLOCK_COMPUTED, text, "")))
                }
                None => return Err(self.no_clock(&columns)),
            },
        };
        let unstated = Unstated::of(&clock.0, &columns.names, options)?;
        let uses_actions = options.columns.iter().any(|(_, theirs)| theirs.contains("action"));
        let actions = uses_actions.then(|| not_joints(&columns, &self.environment)).flatten();
        let found = unstated.recording(path, clock.1, columns.values, columns.left_out)?;
        let mut notes: Vec<Note> = note.into_iter().collect();
        notes.extend(actions);
        notes.extend(found.notes);
        Ok(Recording { notes, ..found })
    }

    /// The columns of a group; those that are clocks stand apart.
    pub(super) fn columns(&self, group: &str, is_clock: &dyn Fn(&str) -> bool) -> Result<Columns> {
        let (arrays, left_out) = arrays_and_others(&self.path, &self.file, group)?;
        let left_out = with_links(left_out, &links(&self.path, self.file.superblock(), group));
        let names: Vec<String> = arrays.iter().flat_map(Array::column_names).filter(|name| !is_clock(name)).collect();
        let (width, rows) = (names.len(), arrays.first().map_or(0, |array| array.rows));
        let mut all = Columns { names, values: vec![0.0; rows * width], rows, clocks: Vec::new(), left_out };
        let mut at = 0;
        for array in arrays {
            let numbers = array.numbers(&self.path)?;
            for (column, name) in array.column_names().into_iter().enumerate() {
                let readings = numbers.iter().skip(column).step_by(array.width).copied();
                if is_clock(&name) {
                    all.clocks.push((name, readings.collect()));
                    continue;
                }
                for (row, reading) in readings.enumerate() {
                    all.values[row * width + at] = reading;
                }
                at += 1;
            }
        }
        Ok(all)
    }

    /// The rate of control that the simulator's description states, in Hz.
    pub(super) fn rate(&self) -> Option<f64> {
        let value: Value = serde_json::from_str(&self.environment).ok()?;
        let rate = value.pointer("/env_kwargs/control_freq").or_else(|| value.get("control_freq"))?.as_f64()?;
        (rate > 0.0 && rate.is_finite()).then_some(rate)
    }

    /// That an episode has no time base, and what to type.
    fn no_clock(&self, columns: &Columns) -> Error {
        let time = columns.names.iter().position(|name| is_named_after_time(name));
        let Some(time) = time else {
            let message = "expected a time for each row, found no array of times and no rate in the file";
            let hint = "say how many rows a second it has, after a look at the recorder: `--rate HZ`";
            return Error::file(&self.path, message, hint);
        };
        let (name, numbers) = (&columns.names[time], columns.column(time).collect::<Vec<f64>>());
        if numbers.windows(2).any(|pair| pair[1] <= pair[0]) {
            let message = format!(
                "`{name}` does not rise (single precision cannot hold times since 1970), and the file states no rate"
            );
            let hint = "say how many rows a second it has, after a look at the recorder: `--rate HZ`";
            return Error::file(&self.path, message, hint);
        }
        let mean = (numbers[numbers.len() - 1] - numbers[0]) / (numbers.len() - 1) as f64;
        let unit = match mean {
            ..=10.0 => "t_s",
            ..=10_000.0 => "t_ms",
            ..=10_000_000.0 => "t_us",
            _ => "t_ns",
        };
        let message = format!("the unit of `{name}` is not stated in the file (its mean interval is {mean})");
        Error::file(
            &self.path,
            message,
            format!("say it: `--columns {unit}={name}` if these are times in that unit, or `--rate HZ`"),
        )
    }
}
