//! The clock of `[record]` in place of a recording, with recorded inputs and initial states.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::{Channel, Hold, Input, Kind, Note, Observation};
use tunenet_formats::{Error, ReadOptions, Recording, read_if_there, read_start, refuse_unused_options};
use tunenet_sim::scene::{First, StartValue};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, declared};

use super::inputs;
use super::read_inputs::ReadInputs;
use super::record_end::{ended, goes_on};
use crate::findings;

/// The clock of `[record]` with the inputs that the file `given` holds, and the first samples that states start at. Whether that file is a
/// recording of all channels comes with it: estimated states start as its first samples show, unless they are `stated`.
pub fn record(
    file: &SimulationFile,
    given: Option<&Path>,
    options: &ReadOptions,
    stated: bool,
) -> Result<(Recording, bool)> {
    let channels = declared::channels(file)?;
    given.map(|path| refuse_unused_options(path, options)).transpose()?;
    let headers = file.headers();
    let mut clock = file.record().clock();
    let driven = given.map(|path| ReadInputs::of(file, path, options)).transpose()?;
    let extent_s = driven.as_ref().and_then(ReadInputs::extent_s);
    // Stamps of another epoch, as those of logs are: the simulation starts with the first of them.
    if let Some((first_s, last_s)) = extent_s
        && (first_s > clock[clock.len() - 1] || last_s < clock[0])
    {
        clock = clock.into_iter().map(|t| t + first_s).collect();
    }
    let mut values = vec![0.0; clock.len() * channels.len()];
    let first = StartValue::Word(First::First);
    for (name, _) in file.starts().filter(|(_, start)| start.value == first) {
        let at = headers.iter().position(|header| header == name).unwrap_or(0);
        let Some(path) = given else {
            let message = format!("expected a number to start `{name}` at, found \"first\" and no recording");
            let hint = format!("try `--set start.{name}=0.1`, or `--inputs FILE` with a column `{name}`");
            return Err(Error::file(file.path(), message, hint).into());
        };
        values[at] = read_start(path, options, &channels[at])?.observation.row(0)[0];
    }
    // Joints start where a file that has their positions begins, and at 0 where it has commands only.
    let joints =
        headers.iter().enumerate().filter(|(_, name)| file.domain() == Domain::Robot && !starts_at(file, name));
    for (at, path) in joints.filter_map(|(at, _)| Some((at, given?))) {
        if let Some(found) = read_if_there(path, options, &channels[at])? {
            // An initial state is judged by the first samples together, as in a recording that is tuned to.
            let seen = found.observation.values();
            let last = seen.len().saturating_sub(1);
            for (i, row) in values.chunks_exact_mut(channels.len()).enumerate() {
                row[at] = seen[i.min(last)];
            }
        }
    }
    let estimated = declared::shown_states(file);
    let shown = given.filter(|_| !stated && !estimated.is_empty());
    let whole = shown.map(|path| samples(path, options, &channels, &clock)).transpose()?.flatten();
    let recorded = whole.is_some();
    let observation = Observation::new(Kind::Other, channels, clock, whole.unwrap_or(values))?;
    let mut recording = Recording { observation, notes: Vec::new() };
    if recorded {
        let text = format!("{} as the first samples of the recording show", estimated.join(", "));
        let remedy = format!("to start at `value`: `--set start.{}.value=…`", estimated[0]);
        recording.notes.push(Note::new(findings::START_ESTIMATED, text, remedy));
    }
    let missing = file.inputs().find(|(_, input)| input.default.is_none() && input.file.is_none());
    if let (Some((name, _)), None) = (missing, given) {
        let message = format!("expected a file that holds the input `{name}`, found none");
        let hint = format!("give one with `--inputs FILE`, or a `default` under [inputs.{name}]");
        return Err(Error::file(file.path(), message, hint).into());
    }
    let whole = recording.observation.clone();
    let (Some(path), Some(driven)) = (given, driven) else {
        return Ok((ended(inputs::defaults(file, recording)?, &whole), recorded));
    };
    let (first_s, end_s) = (whole.clock()[0], *whole.clock().last().unwrap_or(&0.0));
    let mut driven = driven.drive(path, recording, 0)?;
    driven.notes.extend(extent_s.and_then(|(_, last_s)| goes_on(file, last_s - first_s, end_s - first_s)));
    Ok((ended(driven, &whole), recorded))
}

/// The samples of all `channels` at the instants of `clock`, both counted from their first one; `None` where the file at `path` lacks one.
fn samples(path: &Path, options: &ReadOptions, channels: &[Channel], clock: &[f64]) -> Result<Option<Vec<f64>>> {
    let mut columns = Vec::with_capacity(channels.len());
    for channel in channels {
        let Some(Recording { observation, .. }) = read_if_there(path, options, channel)? else { return Ok(None) };
        let (stamps, values) = (observation.clock().to_vec(), observation.values().to_vec());
        columns.push((stamps[0], Input::sampled(channel.clone(), Hold::Linear, stamps, values)?));
    }
    let row =
        |t: &f64| columns.iter().map(|(first_s, column)| column.at(0, t - clock[0] + first_s)).collect::<Vec<_>>();
    Ok(Some(clock.iter().flat_map(row).collect()))
}

/// Whether a file says where a channel starts.
fn starts_at(file: &SimulationFile, channel: &str) -> bool {
    file.starts().any(|(name, _)| name == channel)
}
