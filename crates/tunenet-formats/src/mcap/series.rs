//! An observation from one topic of an MCAP file.

use crate::findings;
use crate::quantity::{Quantity, kind_name};
use std::path::Path;

use super::decoder::Decoder;
use super::joints::Joints;
use super::message::{Decoded, Sample};
use super::records::messages;
use super::stamps::to_s;
use super::topics::{Topic, choose, survey};
use crate::recording::{MOST_NUMBERS, ReadOptions, Recording};
use crate::shown::counted;
use crate::{Error, Result};
use tunenet_core::observation::{Channel, FEWEST_SAMPLES, Kind, Note, Observation};

/// Share of messages below which out-of-order stamps and numbers that are not finite are left out; a hiccup of a driver
/// stays far below, a wrong clock far above.
const FEW: f64 = 0.01;

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let survey = survey(path)?;
    if let Some(error) = survey.ended {
        return Err(error);
    }
    let topic = choose(path, &survey.topics, options.topic.as_deref(), options.role)?;
    let mut series = Series::new(path, topic, &options.joints);
    let mut number = 0u64;
    for message in messages(path)? {
        let message = message?;
        if !topic.is(&message.channel) {
            continue;
        }
        number += 1;
        let decoded = Decoder::of(&message.channel).and_then(|decoder| decoder.decode(&message.data));
        decoded.and_then(|decoded| series.add(number, decoded, message.log_time)).map_err(|why| {
            Error::file(path, format!("message {number} of `{}` cannot be used: {why}", topic.name), "")
        })?;
        if series.values.len() > MOST_NUMBERS {
            let bytes = std::fs::metadata(path).map_or(0, |about| about.len());
            let text = format!("expected at most {MOST_NUMBERS} numbers, found more in its {bytes} bytes");
            return Err(Error::file(path, text, "cut it with `mcap filter --start --end`"));
        }
    }
    series.finish()
}

/// One topic's messages as they come.
struct Series<'a> {
    path: &'a Path,
    topic: &'a Topic,
    /// The joints that are wanted, in their order.
    wanted: &'a [String],
    joints: Option<Joints>,
    channels: Vec<Channel>,
    kind: Option<Kind>,
    rows: Vec<Row>,
    values: Vec<f64>,
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

impl<'a> Series<'a> {
    fn new(path: &'a Path, topic: &'a Topic, wanted: &'a [String]) -> Self {
        Self {
            path,
            topic,
            wanted,
            joints: None,
            channels: Vec::new(),
            kind: None,
            rows: Vec::new(),
            values: Vec::new(),
            not_finite: (0, 0),
        }
    }

    fn add(&mut self, number: u64, decoded: Decoded, log_time: u64) -> std::result::Result<(), String> {
        let kind = decoded.sample.kind();
        if *self.kind.get_or_insert(kind) != kind {
            return Err(format!("expected {}, found {}", self.kind.map_or("", kind_name), kind_name(kind)));
        }
        let start = self.values.len();
        match decoded.sample {
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
                if self.joints.is_none() {
                    let joints = Joints::new(&message, self.wanted)?;
                    self.channels = joints.channels();
                    self.joints = Some(joints);
                }
                if !self.joints.as_mut().is_some_and(|joints| joints.row(&message, &mut self.values)) {
                    return Ok(());
                }
            }
        }
        if !self.values[start..].iter().all(|value| value.is_finite()) {
            self.values.truncate(start);
            self.not_finite =
                if self.not_finite.0 == 0 { (1, number) } else { (self.not_finite.0 + 1, self.not_finite.1) };
            return Ok(());
        }
        self.rows.push(Row { number, stamp: decoded.stamp_ns, log: i64::try_from(log_time).unwrap_or(i64::MAX) });
        Ok(())
    }

    fn refuse<T>(&self, message: String, hint: &str) -> Result<T> {
        Err(Error::file(self.path, message, hint))
    }

    fn few(&self, count: usize) -> bool {
        (count as f64) < FEW * self.topic.messages as f64
    }

    fn finish(self) -> Result<Recording> {
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
        let observation = match self.kind {
            // The clock of an impact is its number, and its value the time.
            Some(Kind::EventTimes) => Observation::new(Kind::EventTimes, self.channels, values, time_s)?,
            kind => Observation::new(kind.unwrap_or(Kind::Other), self.channels, time_s, values)?,
        };
        Ok(Recording { observation, notes })
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
                let why = if fault.is_some() { "do not rise" } else { "are not set" };
                let text = format!("the stamps of `{name}` {why}: the times of recording are used");
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
