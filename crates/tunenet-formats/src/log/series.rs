//! An observation from one topic of a log.

use crate::findings;
use crate::quantity::{Quantity, kind_name};
use std::path::{Path, PathBuf};

use super::choice::choose;
use super::columns;
use super::files::{absent_parts, files};
use super::source::messages;
use super::topics::{Topic, survey};
use crate::recording::{MOST_NUMBERS, ReadOptions, Recording};
use crate::ros::joints::Joints;
use crate::ros::message::{Decoded, JointMessage, Sample, Way};
use crate::ros::numbers::Numbers;
use crate::ros::stamps::to_s;
use crate::sheet::Sheet;
use crate::shown::{counted, list};
use crate::{Error, Result};
use tunenet_core::observation::{Channel, FEWEST_SAMPLES, Kind, Note, Observation};
use tunenet_core::text::visible;

/// Share of messages below which out-of-order stamps and numbers that are not finite are left out; a hiccup of a driver
/// stays far below, a wrong clock far above.
const FEW: f64 = 0.01;
/// Most columns that a note names.
const MOST_NAMED: usize = 12;

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let survey = survey(path, &options.definitions)?;
    if let Some(error) = survey.ended {
        return Err(error);
    }
    let topic = choose(path, &survey.topics, options)?;
    let as_columns = columns::asked(topic, options);
    if !as_columns {
        columns::refuse_unused(topic, options)?;
    }
    let files = files(path)?;
    let needed = if as_columns { columns::needed(topic, options) } else { Vec::new() };
    let mut series = Series::new(path, topic, &options.joints, needed);
    let mut number = 0u64;
    for message in messages(&files, &options.definitions, topic.wanted())? {
        let message = message?;
        if !topic.is(&message.channel) {
            continue;
        }
        number += 1;
        let decoder = message.channel.decoder.as_ref().map_err(ToString::to_string);
        let added = decoder.and_then(|decoder| {
            if as_columns {
                let mut rows = decoder.rows(&message.data, series.names.is_empty())?;
                if rows.first().is_some_and(|row| series.differs(row)) {
                    rows = decoder.rows(&message.data, true)?;
                }
                rows.into_iter().try_for_each(|row| series.add_numbers(number, row, message.log_time))
            } else {
                series.add(number, decoder.decode(&message.data, false)?, message.log_time)
            }
        });
        added.map_err(|why| {
            let hint = "copy the log again, or cut it before that message with `ros2 bag convert`";
            Error::file(path, format!("message {number} of `{}` cannot be used: {why}", topic.name), hint)
        })?;
        if series.values.len() > MOST_NUMBERS {
            return Err(too_long(path, &topic.name, &files));
        }
    }
    let mut recording = series.finish(options)?;
    recording.notes.extend(absent_parts(&files));
    Ok(recording)
}

/// A refusal, with the columns that only messages unlike the first have.
fn with_other_columns(error: Error, names: &[String]) -> Error {
    match error {
        Error::File { path, message, hint } if !names.is_empty() => {
            let others = list(names.iter().map(String::as_str), MOST_NAMED);
            Error::file(path, format!("{message}; other messages have {others}"), hint)
        }
        other => other,
    }
}

/// That a topic holds more numbers than are read, and how its log is cut.
fn too_long(path: &Path, topic: &str, files: &[PathBuf]) -> Error {
    let text = format!("expected at most {MOST_NUMBERS} numbers in `{topic}`, found more");
    let mcap = |file: &PathBuf| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    let hint = match files {
        [one] if mcap(one) => "cut it with `mcap filter --start-secs A --end-secs B`",
        [_] => "cut it with `ros2 bag convert`, which takes `start_time_ns` and `end_time_ns` of its output",
        _ => "give single files of the folder, or cut it with `ros2 bag convert`",
    };
    Error::file(path, text, hint)
}

/// One topic's messages as they come.
struct Series<'a> {
    path: &'a Path,
    topic: &'a Topic,
    /// The joints that are wanted, in their order.
    wanted: &'a [String],
    /// The columns that are wanted, where numbers are read as columns.
    needed: Vec<String>,
    /// Why the first messages cannot be used: they have other joints.
    refused: Option<String>,
    joints: Option<Joints>,
    channels: Vec<Channel>,
    kind: Option<Kind>,
    rows: Vec<Row>,
    values: Vec<f64>,
    /// The names of the columns, and the layout of the first message, where numbers are read as columns.
    names: Vec<String>,
    layout: Vec<u8>,
    /// Messages without some of the columns.
    other_layout: usize,
    /// Columns of such messages that the first one does not have.
    other_names: Vec<String>,
    /// Messages with a number that is not finite, and the first of them.
    not_finite: (usize, u64),
}

/// Both clocks of a message, in ns.
#[derive(Clone, Copy)]
struct Row {
    number: u64,
    stamp: Option<i64>,
    log: i64,
}

impl Row {
    /// What a message with this stamp and time of recording says of some time after both. A stamp of 0 means the time of recording.
    fn after(number: u64, (stamp, log): (Option<i64>, i64), after: i64) -> Self {
        let later = |time: i64| time.checked_add(after);
        let stamp = stamp.filter(|stamp| *stamp != 0 || after == 0).and_then(later);
        Self { number, stamp, log: later(log).unwrap_or(i64::MAX) }
    }
}

impl<'a> Series<'a> {
    fn new(path: &'a Path, topic: &'a Topic, wanted: &'a [String], needed: Vec<String>) -> Self {
        Self {
            path,
            topic,
            wanted,
            needed,
            refused: None,
            joints: None,
            channels: Vec::new(),
            kind: None,
            rows: Vec::new(),
            values: Vec::new(),
            names: Vec::new(),
            layout: Vec::new(),
            other_layout: 0,
            other_names: Vec::new(),
            not_finite: (0, 0),
        }
    }

    /// Whether a row has other columns than the first, or the same in another order.
    fn differs(&self, found: &Numbers) -> bool {
        !self.names.is_empty() && (self.layout != found.layout || self.names.len() != found.values.len())
    }

    /// Adds a row of numbers, one for each column; the first settles the columns. A row that [`differs`](Self::differs) comes with its
    /// names.
    fn add_numbers(&mut self, number: u64, mut found: Numbers, log_time: u64) -> std::result::Result<(), String> {
        self.settle(Kind::Other)?;
        if self.names.is_empty() && !self.needed.iter().all(|name| found.names.contains(name)) {
            self.leave_out(found.names);
            return Ok(());
        }
        if self.names.is_empty() {
            self.channels = found.names.iter().map(|name| Channel::new(name.clone(), "1")).collect();
            (self.names, self.layout) = (found.names, found.layout);
        } else if self.differs(&found) {
            let place = |name: &String| found.names.iter().position(|other| other == name);
            let values = self.names.iter().map(|name| found.values.get(place(name)?).copied()).collect();
            let Some(values) = values else {
                self.leave_out(found.names);
                return Ok(());
            };
            found.values = values;
        }
        self.values.extend(found.values);
        let log = i64::try_from(log_time).unwrap_or(i64::MAX);
        self.rows.push(Row::after(number, (found.stamp_ns, log), found.after_ns));
        Ok(())
    }

    /// Counts a message without some of the columns.
    fn leave_out(&mut self, names: Vec<String>) {
        self.other_layout += 1;
        for name in names {
            let known = self.names.contains(&name) || self.other_names.contains(&name);
            if self.other_names.len() < MOST_NAMED && !known {
                self.other_names.push(name);
            }
        }
    }

    /// Settles the kind of observation by the first sample, and refuses one of another kind.
    fn settle(&mut self, kind: Kind) -> std::result::Result<(), String> {
        if *self.kind.get_or_insert(kind) != kind {
            return Err(format!("expected {}, found {}", self.kind.map_or("", kind_name), kind_name(kind)));
        }
        Ok(())
    }

    fn add(&mut self, number: u64, decoded: Decoded, log_time: u64) -> std::result::Result<(), String> {
        self.settle(decoded.sample.kind())?;
        let start = self.values.len();
        let log = i64::try_from(log_time).unwrap_or(i64::MAX);
        match decoded.sample {
            Sample::Numbers(found) => return self.add_numbers(number, found, log_time),
            Sample::Way(way) => return self.add_way(number, way, decoded.stamp_ns, log),
            Sample::Position(position) => {
                if self.channels.is_empty() {
                    self.channels = Channel::positions();
                }
                self.values.extend(position);
            }
            // The number is kept next to the time until both are known to be good.
            Sample::Bounce(number) => {
                self.channels = vec![Quantity::BounceTime.channel()];
                self.values.push(number);
            }
            Sample::Joints(message) => {
                if !self.add_joints(&message)? {
                    return Ok(());
                }
            }
        }
        self.keep(start, Row { number, stamp: decoded.stamp_ns, log });
        Ok(())
    }

    /// Appends the values of a message of joints; whether it has all that the first one had.
    fn add_joints(&mut self, message: &JointMessage) -> std::result::Result<bool, String> {
        if self.joints.is_none() {
            let joints = match Joints::new(message, self.wanted) {
                Ok(joints) => joints,
                // Another program may publish the joints that are wanted.
                Err(why) if self.wanted.iter().any(|name| !message.name.contains(name)) => {
                    self.refused.get_or_insert(why);
                    self.other_layout += 1;
                    return Ok(false);
                }
                Err(why) => return Err(why),
            };
            self.channels = joints.channels();
            self.joints = Some(joints);
        }
        Ok(self.joints.as_mut().is_some_and(|joints| joints.row(message, &mut self.values)))
    }

    /// Adds every point of a way at its own time.
    fn add_way(&mut self, number: u64, way: Way, stamp: Option<i64>, log: i64) -> std::result::Result<(), String> {
        let mut message = JointMessage { name: way.name, ..JointMessage::default() };
        for (after, arrays) in way.points {
            let start = self.values.len();
            [message.position, message.velocity, message.effort] = arrays;
            if self.add_joints(&message)? {
                self.keep(start, Row::after(number, (stamp, log), after));
            }
        }
        Ok(())
    }

    /// Keeps the values from `start` on as a row, where all are finite.
    fn keep(&mut self, start: usize, row: Row) {
        if !self.values[start..].iter().all(|value| value.is_finite()) {
            self.values.truncate(start);
            let (count, first) = self.not_finite;
            self.not_finite = (count + 1, if count == 0 { row.number } else { first });
            return;
        }
        self.rows.push(row);
    }

    fn refuse<T>(&self, message: String, hint: &str) -> Result<T> {
        Err(Error::file(self.path, message, hint))
    }

    fn few(&self, count: usize) -> bool {
        (count as f64) < FEW * self.topic.messages as f64
    }

    fn finish(self, options: &ReadOptions) -> Result<Recording> {
        let mut notes = self.joints.as_ref().map_or(Vec::new(), Joints::notes);
        let name = &self.topic.name;
        if let (count @ 1.., first) = self.not_finite {
            if !self.few(count) {
                let text = format!(
                    "{count} of {} messages of `{name}` hold numbers that are not finite, the first is message {first}",
                    self.topic.messages
                );
                return self.refuse(text, "record again, or choose another topic with `--topic`");
            }
            let text = format!("{} left out for a number that is not finite", counted(count, "sample"));
            notes.push(Note::new(findings::MESSAGES_NOT_FINITE, text, ""));
        }
        if self.other_layout > 0 {
            let other = match self.other_names.as_slice() {
                [] => String::new(),
                names => format!("; they have {}", list(names.iter().map(String::as_str), MOST_NAMED)),
            };
            let count = counted(self.other_layout, "message");
            let text = format!("{count} of `{name}` left out that lack columns of the first message{other}");
            let remedy =
                "what several messages hold in parts cannot be read together: record a topic that has all of it";
            notes.push(Note::new(findings::MESSAGES_LAYOUT, text, if other.is_empty() { "" } else { remedy }));
        }
        if let Some(why) = self.refused.as_ref().filter(|_| self.joints.is_none()) {
            return self.refuse(format!("message 1 of `{name}` cannot be used: {why}"), "");
        }
        if !self.needed.is_empty() && self.names.is_empty() && self.other_layout > 0 {
            let needed = list(self.needed.iter().map(String::as_str), MOST_NAMED);
            let text = format!("expected messages of `{name}` with {needed}, found none that has all of them");
            let hint = "several programs publish on the topic: leave the joints of all but one out of `[joints]`";
            return self.refuse(text, hint);
        }
        let width = self.channels.len();
        let clock = self.clock(&mut notes)?;
        let mut kept: (Vec<i64>, Vec<f64>) = (Vec::new(), Vec::new());
        let (mut same, mut out_of_order) = (0, 0);
        for (time, row) in clock.iter().zip(self.values.chunks_exact(width.max(1))) {
            match kept.0.last() {
                Some(last) if time == last && kept.1.ends_with(row) => same += 1,
                Some(last) if time <= last => out_of_order += 1,
                _ => {
                    kept.0.push(*time);
                    kept.1.extend_from_slice(row);
                }
            }
        }
        if same > 0 {
            let text = format!("{} of `{name}` left out that repeat the one before", counted(same, "sample"));
            notes.push(Note::new(findings::MESSAGES_REPEATED, text, ""));
        }
        if out_of_order > 0 {
            let text = format!("{} of `{name}` left out whose time does not rise", counted(out_of_order, "sample"));
            notes.push(Note::new(findings::CLOCK_FALLING, text, ""));
        }
        let (clock, values) = kept;
        if clock.len() < FEWEST_SAMPLES {
            let text = format!("expected at least {FEWEST_SAMPLES} samples of `{name}`, found {}", clock.len());
            return self.refuse(text, "record for longer, or choose another topic with `--topic`");
        }
        let time_s: Vec<f64> = clock.into_iter().map(to_s).collect();
        if !self.names.is_empty() {
            return self.into_columns(time_s, values, notes, options);
        }
        let observation = match self.kind {
            // The clock of an impact is its number, and its value the time.
            Some(Kind::EventTimes) => Observation::new(Kind::EventTimes, self.channels, values, time_s)?,
            kind => Observation::new(kind.unwrap_or(Kind::Other), self.channels, time_s, values)?,
        };
        Ok(Recording { observation, notes })
    }

    /// What the numbers of its messages make, as the columns of a table do.
    fn into_columns(
        self,
        clock: Vec<f64>,
        values: Vec<f64>,
        notes: Vec<Note>,
        options: &ReadOptions,
    ) -> Result<Recording> {
        let topic = visible(&self.topic.name);
        let names = std::iter::once("t_s".to_owned()).chain(self.names).collect();
        let sheet = Sheet { names, clock, values, ..Sheet::default() };
        let found = sheet.recording(self.path, &columns::reading(self.topic, options));
        let found = found.map_err(|error| with_other_columns(error, &self.other_names))?;
        // Rows of commands and rows of positions are counted apart.
        let of_topic = |note: Note| {
            let counted = note.kind == findings::ROWS_EMPTY_CELL;
            if counted { Note { text: format!("`{topic}`: {}", note.text), ..note } } else { note }
        };
        let notes = notes.into_iter().chain(found.notes.into_iter().map(of_topic)).collect();
        Ok(Recording { notes, ..found })
    }

    /// The stamps where they are set and rise, otherwise the times of recording.
    fn clock(&self, notes: &mut Vec<Note>) -> Result<Vec<i64>> {
        let stamps: Vec<i64> = self.rows.iter().filter_map(|row| row.stamp).collect();
        let set = stamps.len() == self.rows.len() && stamps.iter().any(|stamp| *stamp != 0);
        let stamp_fault = if set { self.fault(&stamps) } else { None };
        if set && stamp_fault.is_none() {
            return Ok(stamps);
        }
        let logs: Vec<i64> = self.rows.iter().map(|row| row.log).collect();
        let name = &self.topic.name;
        match (self.fault(&logs), stamp_fault) {
            (None, fault) => {
                let why = match fault {
                    Some(_) => format!("the stamps of `{name}` do not rise"),
                    None if stamps.is_empty() => format!("the messages of `{name}` have no stamps"),
                    None => format!("the stamps of `{name}` are not set"),
                };
                let text = format!("{why}: the times of recording are used");
                notes.push(Note::new(findings::CLOCK_LOG_TIME, text, "stamp the messages where they are measured"));
                Ok(logs)
            }
            (Some(fault), None) | (_, Some(fault)) => {
                let Fault { number, before, found, count } = fault;
                let text = format!(
                    "the time of `{name}` does not rise at {count} of {} messages: expected more than {:?} s at message \
                     {number}, found {:?} s",
                    self.topic.messages,
                    to_s(before),
                    to_s(found)
                );
                self.refuse(
                    text,
                    "record again with one publisher and one clock, or choose another topic with `--topic`",
                )
            }
        }
    }

    /// The first step that does not rise, where there are more than a few. Messages sent twice do not count.
    fn fault(&self, clock: &[i64]) -> Option<Fault> {
        let width = self.channels.len();
        let mut first: Option<Fault> = None;
        let mut last: Option<(i64, &[f64])> = None;
        for ((time, row), values) in clock.iter().zip(&self.rows).zip(self.values.chunks_exact(width.max(1))) {
            match last {
                Some((before, shown)) if *time == before && shown == values => {}
                Some((before, _)) if *time <= before => {
                    first.get_or_insert(Fault { number: row.number, before, found: *time, count: 0 }).count += 1;
                }
                _ => last = Some((*time, values)),
            }
        }
        first.filter(|fault| !self.few(fault.count))
    }
}

/// Where a clock does not rise.
struct Fault {
    number: u64,
    before: i64,
    found: i64,
    count: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_without_stamp_starts_when_it_was_recorded() {
        let of = |stamp, after| {
            let row = Row::after(1, (stamp, 70), after);
            (row.stamp, row.log)
        };
        assert_eq!(of(Some(0), 5), (None, 75));
        assert_eq!(of(Some(30), 5), (Some(35), 75));
        assert_eq!(of(Some(0), 0), (Some(0), 70));
        assert_eq!(of(None, 5), (None, 75));
    }

    #[test]
    fn what_cuts_a_log_depends_on_its_files() {
        let hint = |files: &[&str]| {
            let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
            too_long(Path::new("a"), "/joints", &files).hint().unwrap_or_default().to_owned()
        };
        assert!(hint(&["a.mcap"]).contains("mcap filter"));
        assert!(hint(&["a.db3"]).starts_with("cut it with `ros2 bag convert`"));
        assert!(hint(&["a_0.db3", "a_1.db3"]).starts_with("give single files of the folder"));
        assert!(hint(&["a_0.mcap", "a_1.mcap"]).starts_with("give single files of the folder"));
    }
}
