//! What drove a recording, as its simulation file declares it.

use anyhow::Result;
use tunenet_core::observation::{Channel, Hold, Observation};
use tunenet_formats::{InputSource, ReadOptions, Recording, read_input, under_inputs};
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
            joint: commanded_joint(file, name, &channel),
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

/// The joint that an input commands, with the unit of what is commanded; `None` where it commands none.
fn commanded_joint(file: &SimulationFile, name: &str, channel: &Channel) -> Option<Channel> {
    let robot = file.robot().ok()?;
    let (joint, _) = robot.joints.iter().find(|(_, joint)| joint.command == name)?;
    Some(Channel::new(joint.clone(), channel.unit.clone()))
}

/// The channels of the inputs that stand in the recording itself.
pub fn in_recording(file: &SimulationFile) -> Vec<Channel> {
    let own = sources(file).into_iter().filter(|(_, input)| input.file.is_none());
    own.flat_map(|(source, _)| [source.channel.clone(), named(&source)]).collect()
}

/// The topics that the inputs name which stand in the recording itself.
pub fn topics(file: &SimulationFile) -> Vec<String> {
    file.inputs().filter(|(_, input)| input.file.is_none()).filter_map(|(_, input)| input.topic.clone()).collect()
}

/// An input under the very name that its file has for it.
fn named(source: &InputSource) -> Channel {
    Channel::new(source.column.as_ref().unwrap_or(&source.name), "1")
}

/// `recording` driven by the defaults of the inputs of `file`, or by the files that they name.
///
/// # Errors
/// Where an input cannot be read, or does not overlap the recording.
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
