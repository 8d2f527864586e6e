//! What drove the thing: a column of the recording, or another file with a clock of its own.

use std::path::Path;

use tunenet_core::observation::{Channel, Circumstances, FEWEST_SAMPLES, Hold, Input, Kind, Note, Observation, plain};
use tunenet_core::text::visible;

use crate::contents;
use crate::csv::own_columns;
use crate::findings;
use crate::format::Format;
use crate::log::columns;
use crate::log::topics::{Topic, survey};
use crate::others;
use crate::place::Place;
use crate::quantity::{Meaning, Quantity, meaning};
use crate::read::kind_of;
use crate::recording::{ReadOptions, Recording, Role};
use crate::{Error, Result, read};

/// An input that begins later than its recording by less than this holds its first value for no time that matters.
const LEAST_LATE_S: f64 = 5e-4;

/// Where an input stands, and what it is between its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct InputSource {
    /// Its name in the simulation file: `force_n`.
    pub name: String,
    /// Its name without unit, and its unit.
    pub channel: Channel,
    /// The joint that it commands, with the unit of what is commanded: commands have the joint's name in most logs.
    pub joint: Option<Channel>,
    /// What the file calls it, where that is not its name.
    pub column: Option<String>,
    /// The topic of a log that holds it.
    pub topic: Option<String>,
    /// The column of its own clock.
    pub time_column: Option<String>,
    /// Its value where a file does not have it.
    pub default: Option<f64>,
    /// What it is between its samples.
    pub hold: Hold,
}

impl InputSource {
    /// What the file at hand calls it; what `options` map stands above `column`.
    fn column<'a>(&'a self, options: &'a ReadOptions) -> Option<&'a str> {
        let mapped = options.columns.iter().find(|(ours, _)| self.is_called(ours));
        let bare = (self.name == self.channel.name).then_some(self.name.as_str());
        mapped.map(|(_, theirs)| theirs.as_str()).or(self.column.as_deref()).or(bare)
    }

    /// Whether `--columns` means it with this name, which may have another unit that is read.
    fn is_called(&self, ours: &str) -> bool {
        ours == self.name || own_columns::scale_of(ours, &self.channel).is_some()
    }

    /// How the file that holds it is read.
    fn reading(&self, options: &ReadOptions) -> ReadOptions {
        let is_time = |name: &str| matches!(meaning(name), Meaning::Known(Quantity::Time, _));
        let mut columns: Vec<(String, String)> = match &self.time_column {
            // A unit in the name of the column counts.
            Some(column) if is_time(column) => vec![(column.clone(), column.clone())],
            Some(column) => vec![("t_s".into(), column.clone())],
            None => options.columns.iter().filter(|(ours, _)| is_time(ours)).cloned().collect(),
        };
        let mapped: Vec<&(String, String)> = options.columns.iter().filter(|(ours, _)| self.is_called(ours)).collect();
        columns.extend(mapped.iter().map(|(ours, theirs)| {
            let ours = if *ours == self.name { self.channel.header() } else { ours.clone() };
            (ours, theirs.clone())
        }));
        if mapped.is_empty() {
            let channels = std::slice::from_ref(&self.channel);
            // A unit in the name of the column counts.
            let ours = |theirs: &str| own_columns::in_unit_of(theirs, self.channel.header(), channels);
            columns.extend(self.column(options).map(|theirs| (ours(theirs), theirs.to_owned())));
        }
        // What was measured stands in the topic that the command line names; commands may stand in another.
        let by_name = self.joint.is_some() && self.column(options).is_none();
        let topic = self.topic.clone().or_else(|| options.topic.clone().filter(|_| !by_name));
        let channels = vec![self.channel.clone()];
        let (others, joints, commanded) = (options.channels.clone(), Vec::new(), self.joint.clone());
        ReadOptions { columns, topic, channels, others, joints, commanded, role: Role::Driving, ..options.clone() }
    }

    /// Whether the file at `path` has no such column, or no such topic or channel of it.
    fn lacks(&self, path: &Path, place: &Place, kind: Option<Format>, options: &ReadOptions) -> Result<bool> {
        let names = match kind {
            Some(Format::Mcap | Format::PackedMcap | Format::Bag) => {
                return self.is_not_in(&survey(&place.path, &options.definitions)?.topics, path, options);
            }
            Some(Format::Csv) => {
                let columns = contents::columns(&place.path, &ReadOptions::default())?;
                columns.into_iter().map(|column| column.name).collect()
            }
            other => others::column_names(place, other)?,
        };
        let Some(wanted) = self.column(options) else {
            // Names of data sets and of HDF5 have no units: `--units` states these.
            let bare = matches!(kind, None | Some(Format::Hdf5));
            let is_meant =
                |name: &String| own_columns::is_meant(name, &self.channel) || bare && plain(name) == self.channel.name;
            return Ok(!names.iter().any(is_meant));
        };
        let bare = wanted.strip_prefix('-').unwrap_or(wanted);
        Ok(bare.parse::<usize>().is_err() && !names.iter().any(|name| name == wanted || name == bare))
    }

    /// Whether a log has no such topic, or none of its channels is the input.
    fn is_not_in(&self, topics: &[Topic], path: &Path, options: &ReadOptions) -> Result<bool> {
        let reading = self.reading(options);
        let has = |topic: &&Topic| columns::asked(topic, &reading) && columns::has_all(topic, &reading);
        match &reading.topic {
            Some(name) => match topics.iter().find(|known| known.name == *name) {
                None => return Ok(true),
                Some(topic) if columns::asked(topic, &reading) => return Ok(!has(&topic)),
                Some(_) => {}
            },
            None if topics.iter().any(|topic| has(&topic)) => return Ok(false),
            None if topics.iter().all(|topic| topic.usable.is_err()) => return Ok(true),
            None => {}
        }
        let whole = ReadOptions { topic: reading.topic.clone(), ..ReadOptions::default() };
        let whole = read(path, &ReadOptions { definitions: options.definitions.clone(), ..whole })?;
        Ok(own_columns::column_of(&whole.observation, &self.channel, &reading).is_none())
    }
}

/// An input, and what was noticed while it was read.
pub type NotedInput = (Input, Vec<Note>);

/// The input `source` from the file or folder at `path`, with `options` for what the command line says of columns; what was
/// noticed. `None` where the file does not have it and a [default](InputSource::default) stands in for it.
///
/// # Errors
/// As [`read`](crate::read()).
pub fn read_input(path: &Path, options: &ReadOptions, source: &InputSource) -> Result<Option<NotedInput>> {
    if source.default.is_some() && !has(path, options, source)? {
        return Ok(None);
    }
    let reading = source.reading(&of_file(&Place::of(path), options)?);
    let Recording { observation, notes } = read(path, &reading)?;
    Ok(Some((Input::new(observation, source.hold), notes)))
}

/// The series of one channel whose first sample is an initial state.
///
/// # Errors
/// As [`read`](crate::read()).
pub fn read_start(path: &Path, options: &ReadOptions, channel: &Channel) -> Result<Recording> {
    let reading = alone(channel).reading(&of_file(&Place::of(path), options)?);
    read(path, &ReadOptions { role: Role::Starting, ..reading })
}

/// As [`read_start`], from a recording that need not have it: `None` where it does not.
///
/// # Errors
/// As [`read_start`].
pub fn read_if_there(path: &Path, options: &ReadOptions, channel: &Channel) -> Result<Option<Recording>> {
    if !has(path, options, &alone(channel))? {
        return Ok(None);
    }
    read_start(path, options, channel).map(Some)
}

/// A channel as one looks for an input.
fn alone(channel: &Channel) -> InputSource {
    let (name, channel) = (channel.header(), channel.clone());
    let (joint, column, topic, time_column, default, hold) = (None, None, None, None, None, Hold::Previous);
    InputSource { name, channel, joint, column, topic, time_column, default, hold }
}

/// Whether the recording at `path` has the input.
fn has(path: &Path, options: &ReadOptions, source: &InputSource) -> Result<bool> {
    let place = Place::of(path);
    let kind = kind_of(&place)?;
    Ok(!source.lacks(path, &place, kind, &of_file(&place, options)?)?)
}

/// `options` as they are about the file at a place: what the command line says of topics, units and rates is said of recordings, and this
/// may be a file of another kind next to one.
fn of_file(place: &Place, options: &ReadOptions) -> Result<ReadOptions> {
    let kind = kind_of(place)?;
    let log = matches!(kind, Some(Format::Mcap | Format::PackedMcap | Format::Bag));
    let hdf5 = kind == Some(Format::Hdf5);
    let units = if hdf5 || kind.is_none() { options.units.clone() } else { Vec::new() };
    let (topic, rate_hz) = (options.topic.clone().filter(|_| log), options.rate_hz.filter(|_| hdf5));
    Ok(ReadOptions { topic, units, rate_hz, ..options.clone() })
}

/// `recording` with its inputs, each under its name in the simulation file; cut where one of them ends. An input that is `None` has
/// this value throughout.
///
/// # Errors
/// [`Error::File`] where an input and the recording have no three samples in common.
pub fn under_inputs(
    path: &Path,
    recording: Recording,
    setup: usize,
    inputs: Vec<(&InputSource, Option<NotedInput>)>,
) -> Result<Recording> {
    let Recording { mut observation, mut notes } = recording;
    let mut found = Vec::with_capacity(inputs.len());
    for (source, input) in inputs {
        let name = &source.name;
        let Some((input, noticed)) = input else {
            let value = source.default.unwrap_or(0.0);
            let text = format!("the recording has no `{name}`: its default {value} is used");
            notes.push(Note::new(findings::INPUT_DEFAULT, text, ""));
            found.push(constant(source, &observation, value)?);
            continue;
        };
        notes.extend(noticed.into_iter().filter(|note| !notes.contains(note)).collect::<Vec<_>>());
        let (clock, given) = (observation.clock(), input.series().clock());
        let (first, last) = (given[0], given[given.len() - 1]);
        let within = clock.partition_point(|t| *t <= last);
        if within < FEWEST_SAMPLES || first > clock[clock.len() - 1] {
            let message = format!(
                "expected an input `{name}` that overlaps the recording ({} to {} s), found one from {first} to {last} s",
                clock[0],
                clock[clock.len() - 1]
            );
            let hint = "give both the same clock, or the file that was recorded with it";
            return Err(Error::file(path, message, hint));
        }
        if first - clock[0] > LEAST_LATE_S {
            let text =
                format!("`{name}` begins {:.3} s after the recording: its first value holds before", first - clock[0]);
            notes.push(Note::new(findings::INPUT_LATE, text, "record the input from the start"));
        }
        if within < clock.len() {
            let text = format!(
                "`{name}` ends {:.3} s before the recording: {} of {} samples are used",
                clock[clock.len() - 1] - last,
                within,
                clock.len()
            );
            notes.push(Note::new(findings::INPUT_SHORT, text, "record the input to the end"));
            observation = observation.slice(0..within)?;
        }
        found.push(input);
    }
    let name = path.file_name().map_or_else(String::new, |name| visible(&name.to_string_lossy()));
    let known = Circumstances { name, setup, ..Circumstances::driven_by(found) };
    Ok(Recording { observation: observation.under(known), notes })
}

/// An input of one value for as long as `seen` lasts.
///
/// # Errors
/// As [`Observation::new`].
fn constant(source: &InputSource, seen: &Observation, value: f64) -> Result<Input> {
    let clock = seen.clock();
    let times: Vec<f64> = [0, clock.len() / 2, clock.len() - 1].map(|i| clock[i]).to_vec();
    let series = Observation::new(Kind::Other, vec![source.channel.clone()], times, vec![value; FEWEST_SAMPLES])?;
    Ok(Input::new(series, source.hold))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Made, bag, error_text, file, joints, made};

    fn source(name: &str) -> InputSource {
        let channel = Channel::from_header(name).unwrap_or_else(|| Channel::new(name, "V"));
        InputSource {
            name: name.into(),
            channel,
            joint: None,
            column: None,
            topic: None,
            time_column: None,
            default: None,
            hold: Hold::Previous,
        }
    }

    fn recording(path: &Path) -> Recording {
        let channels = vec![Channel::new("x", "m")];
        let inputs = vec![Channel::new("force", "N")];
        read(path, &ReadOptions { channels, others: inputs, ..ReadOptions::default() }).unwrap()
    }

    const TABLE: &str = "t_s,x_m,force_n,u\n0,1,5,9\n1,2,6,8\n2,3,7,7\n3,4,8,6\n";

    #[test]
    fn an_input_is_a_column_by_its_name_or_by_the_name_that_the_file_has() {
        let (_folder, path) = file("a.csv", TABLE);
        let values = |source: &InputSource, columns: &[(&str, &str)]| {
            let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
            let (input, _) =
                read_input(&path, &ReadOptions { columns, ..ReadOptions::default() }, source).unwrap().unwrap();
            input.series().column(0).collect::<Vec<_>>()
        };
        assert_eq!(values(&source("force_n"), &[]), [5.0, 6.0, 7.0, 8.0]);
        assert_eq!(values(&source("u"), &[]), [9.0, 8.0, 7.0, 6.0]);
        assert_eq!(values(&InputSource { column: Some("u".into()), ..source("force_n") }, &[]), [9.0, 8.0, 7.0, 6.0]);
        assert_eq!(values(&source("force_n"), &[("force_n", "-u")]), [-9.0, -8.0, -7.0, -6.0]);
        assert_eq!(values(&InputSource { time_column: Some("x_m".into()), ..source("u") }, &[]).len(), 4);
        // An input is no forgotten column.
        let notes = recording(&path).notes;
        assert!(notes[0].text.ends_with("are ignored: `u`"), "{notes:?}");
    }

    /// Degrees are not read as radians because the column is an input's.
    #[test]
    fn an_input_is_converted_from_the_unit_that_the_mapping_states() {
        let (_folder, path) = file("a.csv", "time,pos,cmd,goal_rad\n0,0,180,1\n1,0,-90,2\n2,0,0,3\n");
        let goal = Channel::from_header("goal_rad").unwrap();
        let options = |columns: &[(&str, &str)]| {
            let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
            ReadOptions { columns, others: vec![goal.clone()], ..ReadOptions::default() }
        };
        let pi = std::f64::consts::PI;
        for (mapped, expected) in [
            (("goal_deg", "cmd"), [pi, -pi / 2.0, 0.0]),
            (("goal_deg", "-cmd"), [-pi, pi / 2.0, 0.0]),
            (("goal_rad", "cmd"), [180.0, -90.0, 0.0]),
            (("goal_deg", "goal_rad"), [1.0 * pi / 180.0, 2.0 * pi / 180.0, 3.0 * pi / 180.0]),
        ] {
            let options = options(&[("t_s", "time"), ("angle_deg", "pos"), mapped]);
            let (input, notes) = read_input(&path, &options, &source("goal_rad")).unwrap().unwrap();
            let found: Vec<f64> = input.series().column(0).collect();
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{mapped:?}: {found:?}");
            let noted = notes.iter().any(|note| note.kind == findings::COLUMNS_CONVERTED);
            assert_eq!(noted, mapped.0 == "goal_deg", "{notes:?}");
            let seen = ReadOptions { channels: vec![Channel::from_header("angle_rad").unwrap()], ..options };
            assert!(read(&path, &seen).is_ok());
        }
        let twice = options(&[("t_s", "time"), ("goal_deg", "cmd"), ("goal_rad", "pos")]);
        let refused = read_input(&path, &twice, &source("goal_rad")).unwrap_err().to_string();
        assert!(refused.contains("`goal_rad` once"), "{refused}");
    }

    #[test]
    fn a_missing_input_is_refused_or_takes_its_default() {
        let (_folder, path) = file("a.csv", "t_s,x_m,force_kn,u_mv\n0,1,5,2\n1,2,6,2\n2,3,7,2\n");
        let refused =
            |source: &InputSource| error_text(&read_input(&path, &ReadOptions::default(), source).unwrap_err());
        let (message, hint) = refused(&source("force_n"));
        assert!(message.ends_with("expected `force_n` in N, found the column in kn"), "{message}");
        assert!(hint.contains("--columns force_n=force_kn"), "{hint}");
        let (message, hint) = refused(&source("torque_nm"));
        assert!(message.contains("expected a column `torque_nm` (an input of the simulation), found"), "{message}");
        assert!(hint.contains("`column`") || hint.contains("--columns"), "{hint}");
        // A default does not replace what stands there in another unit.
        let (message, _) = refused(&InputSource { default: Some(0.0), ..source("force_n") });
        assert!(message.ends_with("expected `force_n` in N, found the column in kn"), "{message}");
        let absent = InputSource { default: Some(2.5), ..source("torque_nm") };
        assert_eq!(read_input(&path, &ReadOptions::default(), &absent).unwrap(), None);
        let whole = under_inputs(&path, recording(&path), 3, vec![(&absent, None)]).unwrap();
        let known = whole.observation.circumstances().unwrap();
        assert_eq!((known.setup, known.inputs[0].at(0, 1.7)), (3, 2.5));
        assert!(whole.notes.iter().any(|note| note.kind == findings::INPUT_DEFAULT));
    }

    #[test]
    fn a_default_stands_in_only_where_the_file_has_no_such_column() {
        let (_folder, path) = file("a.csv", TABLE);
        let mapped = vec![("force_n".to_owned(), "-u".to_owned())];
        let options = ReadOptions { columns: mapped, ..ReadOptions::default() };
        let negated = InputSource { default: Some(0.0), ..source("force_n") };
        let (input, _) = read_input(&path, &options, &negated).unwrap().unwrap();
        assert_eq!(input.series().column(0).collect::<Vec<_>>(), [-9.0, -8.0, -7.0, -6.0]);
        let channel = |header: &str| Channel::from_header(header).unwrap();
        let there = read_if_there(&path, &ReadOptions::default(), &channel("x_m")).unwrap().unwrap();
        assert_eq!(there.observation.row(0), [1.0]);
        assert_eq!(read_if_there(&path, &ReadOptions::default(), &channel("y_m")).unwrap(), None);
        // What cannot be read is no file that lacks something.
        let broken = path.with_file_name("b.csv");
        std::fs::write(&broken, "t_s,x_m\n0,1\n1,?\n2,3\n").unwrap();
        assert!(read_if_there(&broken, &ReadOptions::default(), &channel("x_m")).is_err());
    }

    #[test]
    fn a_topic_that_a_definition_makes_readable_needs_no_default() {
        let double = |_, value: f64| [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat();
        let states = made("/joints", "sensor_msgs/msg/JointState", 5, |ns, q| joints(ns, &["elbow"], &[q], &[]));
        let force = Made { definition: "", ..made("/force", "own/msg/Force", 5, double) };
        let log = bag(None, &[force, states]);
        let (_folder, path) = file("a.mcap", log);
        let options =
            ReadOptions { definitions: vec![("Force".into(), "float64 newton".into())], ..ReadOptions::default() };
        let force = InputSource { topic: Some("/force".into()), default: Some(0.0), ..source("force_n") };
        let (input, _) = read_input(&path, &options, &force).unwrap().unwrap();
        assert_eq!(input.series().column(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
        // A joint is found by its name, though its channel is called `q1`.
        let elbow = read_if_there(&path, &options, &Channel::from_header("elbow_rad").unwrap()).unwrap().unwrap();
        assert_eq!(elbow.observation.row(3), [3.0]);
    }

    #[test]
    fn a_recording_is_cut_where_its_input_ends() {
        let (_folder, path) = file("a.csv", TABLE);
        let given = |times: &[f64]| {
            let series =
                Observation::new(Kind::Other, vec![Channel::new("force", "N")], times.to_vec(), vec![1.0; times.len()]);
            Some((Input::new(series.unwrap(), Hold::Previous), Vec::new()))
        };
        let source = source("force_n");
        let cut = under_inputs(&path, recording(&path), 0, vec![(&source, given(&[0.5, 1.0, 2.5]))]).unwrap();
        assert_eq!(cut.observation.clock(), [0.0, 1.0, 2.0]);
        let texts: Vec<&str> = cut.notes.iter().map(|note| note.text.as_str()).collect();
        assert!(
            texts.contains(&"`force_n` begins 0.500 s after the recording: its first value holds before"),
            "{texts:?}"
        );
        assert!(texts.contains(&"`force_n` ends 0.500 s before the recording: 3 of 4 samples are used"), "{texts:?}");
        let refused = under_inputs(&path, recording(&path), 0, vec![(&source, given(&[5.0, 6.0, 7.0]))]).unwrap_err();
        assert!(error_text(&refused).0.contains("that overlaps the recording (0 to 3 s), found one from 5 to 7 s"));
    }
}
