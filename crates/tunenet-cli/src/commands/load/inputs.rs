//! What drove a recording, as its simulation file declares it.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::{Channel, Hold, Observation};
use tunenet_formats::{Error, InputSource, NotedInput, ReadOptions, Recording, read_input, under_inputs};
use tunenet_sim::{SimulationFile, scene};

use super::input_files::own_file;

/// Where the inputs of `file` stand, in its order.
pub fn sources(file: &SimulationFile) -> Vec<(InputSource, &scene::Input)> {
    let one = |(name, input): (&str, &scene::Input)| {
        // A name without unit has one in its table, or is refused when the file is read.
        let channel = input.channel(name).unwrap_or_else(|| Channel::new(name, "1"));
        let hold = match input.hold {
            scene::Hold::Previous => Hold::Previous,
            scene::Hold::Linear => Hold::Linear,
        };
        InputSource {
            name: name.to_owned(),
            channel,
            column: input.column.clone(),
            topic: input.topic.clone(),
            time_column: input.time_column.clone(),
            default: input.default,
            hold,
        }
    };
    file.inputs().map(|(name, input)| (one((name, input)), input)).collect()
}

/// The channels of the inputs that stand in the recording itself.
pub fn in_recording(file: &SimulationFile) -> Vec<Channel> {
    let own = sources(file).into_iter().filter(|(_, input)| input.file.is_none());
    own.flat_map(|(source, _)| [source.channel.clone(), named(&source)]).collect()
}

/// An input under the very name that its file has for it.
fn named(source: &InputSource) -> Channel {
    Channel::new(source.column.as_ref().unwrap_or(&source.name), "1")
}

/// Inputs as they were read, each with where it stands; `None` where its default replaces it.
pub struct ReadInputs(Vec<(InputSource, Option<NotedInput>)>);

impl ReadInputs {
    /// The inputs of `file` that drove the recording at `path`.
    ///
    /// # Errors
    /// Where an input cannot be read.
    pub fn of(file: &SimulationFile, path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut found = Vec::new();
        for (source, input) in sources(file) {
            let own = own_file(input, path);
            if let Some(missing) = own.as_deref().filter(|own| !own.exists()) {
                let hint = format!("`file` of `[inputs.{}]` names it, from the folder of the recording", source.name);
                return Err(Error::file(missing, "no such file", hint).into());
            }
            let read = read_input(own.as_deref().unwrap_or(path), options, &source)?;
            found.push((source, read));
        }
        Ok(Self(found))
    }

    /// The first and the last stamp of all inputs that were read, s; `None` where defaults replace all of them.
    pub fn extent_s(&self) -> Option<(f64, f64)> {
        let clocks = self.0.iter().filter_map(|(_, read)| read.as_ref().map(|(input, _)| input.series().clock()));
        let ends = clocks.filter_map(|clock| Some((*clock.first()?, *clock.last()?)));
        ends.reduce(|(first, last), (begin, end)| (first.min(begin), last.max(end)))
    }

    /// `recording`, which was read from `path`, under these inputs and in this setup.
    ///
    /// # Errors
    /// Where an input does not overlap the recording.
    pub fn drive(self, path: &Path, recording: Recording, setup: usize) -> Result<Recording> {
        let found = self.0.iter().map(|(source, read)| (source, read.clone())).collect();
        Ok(under_inputs(path, recording, setup, found)?)
    }
}

/// `recording`, which was read from `path`, with the inputs of `file` and in this setup.
///
/// # Errors
/// As [`ReadInputs::of`] and [`ReadInputs::drive`].
pub fn attach(
    file: &SimulationFile,
    path: &Path,
    recording: Recording,
    setup: usize,
    options: &ReadOptions,
) -> Result<Recording> {
    ReadInputs::of(file, path, options)?.drive(path, recording, setup)
}

/// `recording` driven by the defaults of the inputs of `file`, or by the files that they name.
///
/// # Errors
/// As [`attach`].
pub fn defaults(file: &SimulationFile, recording: Recording) -> Result<Recording> {
    let sources = sources(file);
    let mut found = Vec::with_capacity(sources.len());
    for (source, input) in &sources {
        let own = own_file(input, file.path());
        let input = own.map(|path| read_input(&path, &ReadOptions::default(), source)).transpose()?;
        found.push((source, input.flatten()));
    }
    Ok(under_inputs(file.path(), recording, 0, found)?)
}

/// `observation` with its inputs as further columns, by the names that a recording has for them.
///
/// # Errors
/// As [`Observation::new`].
pub fn with_columns(file: &SimulationFile, observation: &Observation) -> Result<Observation> {
    let sources = sources(file);
    let Some(known) = observation.circumstances().filter(|_| !sources.is_empty()) else {
        return Ok(observation.clone());
    };
    let own = sources.iter().map(|(source, _)| {
        let plain = source.column.is_none() && source.channel.header() == source.name;
        if plain { source.channel.clone() } else { named(source) }
    });
    let channels = observation.channels().iter().cloned().chain(own).collect();
    let rows = observation.clock().iter().enumerate();
    let values = rows.flat_map(|(i, t)| {
        let driven = known.inputs.iter().map(|input| input.at(0, *t));
        observation.row(i).iter().copied().chain(driven).collect::<Vec<_>>()
    });
    Ok(Observation::new(observation.kind(), channels, observation.clock().to_vec(), values.collect())?)
}
