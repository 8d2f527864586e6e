//! The columns of one episode.

use std::path::Path;

use serde_json::Value;

use super::Demonstrations;
use super::actions::not_joints;
use super::tree::Columns;
use crate::findings;
use crate::quantity::{Meaning, Quantity, meaning};
use crate::recording::{ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::unstated::Unstated;
use crate::{Error, Result};
use tunenet_core::observation::Note;

/// What arrays of times are called where they do not say their unit.
const TIMES: [&str; 5] = ["timestamp", "timestamps", "time", "times", "t"];

impl Demonstrations {
    /// The observation that an episode makes, with its columns in the units that `options` say.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode, it has no time base, or a column is asked for whose unit nothing states.
    pub fn read(&self, path: &Path, name: Option<&str>, options: &ReadOptions) -> Result<Recording> {
        let columns = self.columns(self.group(name)?)?;
        let is_time = |name: &str| matches!(meaning(name), Meaning::Known(Quantity::Time, _));
        // A clock has a unit in its name, or is mapped with one.
        let mapped = |name: &String| options.columns.iter().any(|(ours, theirs)| is_time(ours) && theirs == name);
        let (clocks, others): (Vec<usize>, Vec<usize>) =
            (0..columns.names.len()).partition(|i| is_time(&columns.names[*i]) || mapped(&columns.names[*i]));
        let (rate, note) = match (options.rate_hz, clocks.as_slice()) {
            (None, [_, ..]) => (None, None),
            (Some(rate), _) => (Some(rate), None),
            (None, []) => match self.rate() {
                Some(rate) => {
                    let text = format!(
                        "the clock is the number of each row over {rate} Hz, which the file states: jitter is not in it"
                    );
                    (Some(rate), Some(Note::new(findings::CLOCK_COMPUTED, text, "")))
                }
                None => return Err(self.no_clock(&columns)),
            },
        };
        let names: Vec<String> = others.iter().map(|i| columns.names[*i].clone()).collect();
        let clock_name = if rate.is_some() { "t_s".to_owned() } else { columns.names[clocks[0]].clone() };
        let unstated = Unstated::of(&clock_name, &names, options)?;
        let clock: Vec<f64> = match rate {
            Some(rate) => (0..columns.rows).map(|row| row as f64 / rate).collect(),
            None => columns.numbers[clocks[0]].clone(),
        };
        let row = |row: usize| {
            let numbers = others.iter().enumerate().map(move |(at, i)| (at, *i));
            let value = |(at, i): (usize, usize)| unstated.value(at, columns.numbers[i][row]);
            std::iter::once(clock[row]).chain(numbers.map(value)).collect::<Vec<f64>>()
        };
        let values = (0..columns.rows).flat_map(row).collect();
        let headers = std::iter::once(clock_name).chain(unstated.headers().iter().cloned()).collect();
        let sheet = Sheet { names: headers, values, unnamed: false };
        let readings = |column: usize| columns.numbers[others[column]].clone();
        let found = unstated.recording(path, &sheet, &readings)?;
        let mut notes: Vec<Note> = note.into_iter().collect();
        let uses_actions = options.columns.iter().any(|(_, theirs)| theirs.contains("action"));
        notes.extend(not_joints(&columns, &self.environment).filter(|_| uses_actions));
        notes.extend(found.notes);
        Ok(Recording { notes, ..found })
    }

    /// The columns of a group: a list is one, an array of rows as many as a row has numbers.
    pub(super) fn columns(&self, group: &str) -> Result<Columns> {
        let mut all = Columns { names: Vec::new(), numbers: Vec::new(), rows: 0 };
        for array in self.arrays(group)? {
            let numbers = array.numbers(&self.path)?;
            all.rows = array.rows;
            all.names.extend(array.column_names());
            for column in 0..array.width {
                all.numbers.push(numbers.iter().skip(column).step_by(array.width).copied().collect());
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
        let time = columns.names.iter().position(|name| TIMES.contains(&name.rsplit('.').next().unwrap_or_default()));
        let Some(time) = time else {
            let message = "expected a time for each row, found no array of times and no rate in the file";
            let hint = "say how many rows a second it has, after a look at the recorder: `--rate HZ`";
            return Error::file(&self.path, message, hint);
        };
        let (name, numbers) = (&columns.names[time], &columns.numbers[time]);
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
