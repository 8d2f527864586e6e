//! What a program is simulated under: recorded inputs and initial states, without or with a recording.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Preparation, Prepared, Simulator};
use tunenet_formats::{Error, ReadOptions, Recording, read_channel, read_if_there, refuse_unused_options};
use tunenet_sim::scene::{First, StartValue};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, declared};

use super::input_files::own_files_of;
use super::inputs;
use super::options::reading as read_options;
use super::setups::Setups;
use crate::args::{Numbers, Simulation};
use crate::files::manifest::{Source, read as entries};

/// What is simulated: instants with their circumstances, by the name of the recording that they are taken from.
pub struct Driven {
    pub setups: Setups,
    pub recordings: Vec<(String, Recording)>,
}

impl Driven {
    /// The clock of `[record]`, driven by what stands in the file `given`; or, with a manifest, every recording that it lists.
    /// `reading` says how these are read.
    ///
    /// # Errors
    /// Where an input or an initial state is missing, or a file cannot be read.
    pub fn of(file: &SimulationFile, given: Option<&Path>, manifest: Option<&Path>, reading: &Numbers) -> Result<Self> {
        let Some(manifest) = manifest else {
            return Ok(Self {
                setups: Setups::alike(file, 1),
                recordings: vec![(String::new(), record(file, given, &read_options(reading)?)?)],
            });
        };
        let entries = entries(manifest)?;
        if let Some(other) = entries.iter().find(|entry| entry.object != entries[0].object) {
            let found = format!("`{}` and `{}`", entries[0].object, other.object);
            let message = format!("expected recordings of one object, found {found}");
            return Err(Error::file(manifest, message, "write a manifest for each object").into());
        }
        let setups = Setups::of(Some(manifest), file, &entries.iter().collect::<Vec<_>>())?;
        let one = |(i, entry): (usize, &Source)| {
            let name = entry.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            let (file, setup, most) = (setups.file(i), setups.number(i), super::MOST_SAMPLES);
            Ok((name, super::of_channels(file, setup, &entry.path, reading, most)?))
        };
        let recordings = entries.iter().enumerate().map(one).collect::<Result<_>>()?;
        Ok(Self { setups, recordings })
    }

    /// The files of their own in which inputs stand, where [`Self::of`] reads them.
    pub fn input_files(simulation: &Simulation, given: Option<&Path>, manifest: Option<&Path>) -> Vec<PathBuf> {
        let alone = || vec![Source::alone(given.unwrap_or(&simulation.sim), "", None)];
        let sources = manifest.map_or_else(alone, |path| entries(path).unwrap_or_default());
        own_files_of(simulation, manifest, &sources).concat()
    }

    /// All recordings as the simulator prepares them.
    ///
    /// # Errors
    /// As [`Simulator::prepare`].
    pub fn prepared(&self, simulator: &dyn Simulator) -> Result<Vec<Prepared>> {
        let mut all = Vec::new();
        for (_, recording) in &self.recordings {
            if let Preparation::Usable(prepared) = simulator.prepare(&recording.observation)? {
                all.push(*prepared);
            }
        }
        Ok(all)
    }
}

/// The clock of `[record]` with the inputs that the file `given` holds, and the first samples that states start at.
fn record(file: &SimulationFile, given: Option<&Path>, options: &ReadOptions) -> Result<Recording> {
    let channels = declared::channels(file)?;
    given.map(|path| refuse_unused_options(path, options)).transpose()?;
    let headers = file.headers();
    let clock = file.record().clock();
    let mut values = vec![0.0; clock.len() * channels.len()];
    let first = StartValue::Word(First::First);
    for (name, _) in file.starts().filter(|(_, start)| start.value == first) {
        let at = headers.iter().position(|header| header == name).unwrap_or(0);
        let Some(path) = given else {
            let message = format!("expected a number to start `{name}` at, found \"first\" and no recording");
            let hint = format!("try `--set start.{name}=0.1`, or `--inputs FILE` with a column `{name}`");
            return Err(Error::file(file.path(), message, hint).into());
        };
        values[at] = read_channel(path, options, &channels[at])?.observation.row(0)[0];
    }
    // Joints start where a file that has their positions begins, and at 0 where it has commands only.
    let joints =
        headers.iter().enumerate().filter(|(_, name)| file.domain() == Domain::Robot && !starts_at(file, name));
    for (at, path) in joints.filter_map(|(at, _)| Some((at, given?))) {
        if let Some(found) = read_if_there(path, options, &channels[at])? {
            values[at] = found.observation.row(0)[0];
        }
    }
    let observation = Observation::new(Kind::Other, channels, clock, values)?;
    let recording = Recording { observation, notes: Vec::new() };
    let missing = file.inputs().find(|(_, input)| input.default.is_none() && input.file.is_none());
    if let (Some((name, _)), None) = (missing, given) {
        let message = format!("expected a file that holds the input `{name}`, found none");
        let hint = format!("give one with `--inputs FILE`, or a `default` under [inputs.{name}]");
        return Err(Error::file(file.path(), message, hint).into());
    }
    match given {
        Some(path) => inputs::attach(file, path, recording, 0, options),
        None => inputs::defaults(file, recording),
    }
}

/// Whether a file says where a channel starts.
fn starts_at(file: &SimulationFile, channel: &str) -> bool {
    file.starts().any(|(name, _)| name == channel)
}
