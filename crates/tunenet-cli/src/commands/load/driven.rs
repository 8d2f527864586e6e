//! What a program is simulated under: recorded inputs and initial states, without or with a recording.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::simulator::{Preparation, Prepared, Simulator};
use tunenet_formats::{Error, Recording};
use tunenet_sim::{SimulationFile, declared};

use super::clock;
use super::differences::START;
use super::input_files::own_files_of;
use super::options::reading as read_options;
use super::setups::Setups;
use crate::args::{Numbers, Simulation};
use crate::files::manifest::{Source, read as entries};

/// What is simulated: instants with their circumstances, by the name of the recording that they are taken from.
pub struct Driven {
    pub setups: Setups,
    pub recordings: Vec<(String, Recording)>,
    /// Whether what is estimated starts as the recordings show, instead of at the values of the file.
    recorded: bool,
}

impl Driven {
    /// The clock of `[record]`, driven by what stands in the file `given`; or, with a manifest, every recording that it lists.
    /// `reading` says how these are read, and `set` what the command line changes in the file: where it says where a state starts, no
    /// recording does.
    ///
    /// # Errors
    /// Where an input or an initial state is missing, or a file cannot be read.
    pub fn of(
        (file, set): (&SimulationFile, &[String]),
        given: Option<&Path>,
        manifest: Option<&Path>,
        reading: &Numbers,
    ) -> Result<Self> {
        let stated = set.iter().any(|assignment| assignment.trim_start().starts_with(START));
        let Some(manifest) = manifest else {
            let (recording, recorded) = clock::record(file, given, &read_options(reading)?, stated)?;
            let recordings = vec![(String::new(), recording)];
            return Ok(Self { setups: Setups::alike(file, 1), recordings, recorded });
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
        Ok(Self { setups, recordings, recorded: !stated })
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
            if let Preparation::Usable(mut prepared) = simulator.prepare(&recording.observation)? {
                if self.recorded {
                    begin_as_shown(self.setups.common(), &mut prepared);
                } else {
                    prepared.begin.clear();
                }
                all.push(*prepared);
            }
        }
        Ok(all)
    }
}

/// Lets estimated states that an output shows begin at the first sample of it.
fn begin_as_shown(file: &SimulationFile, prepared: &mut Prepared) {
    for (nuisance, begin) in prepared.nuisances.iter().zip(&mut prepared.begin) {
        let shown = nuisance.name.strip_prefix(START).and_then(|state| declared::shown_by(file, state));
        if let Some(channel) = shown {
            *begin = Some(prepared.seen.row(0)[channel].clamp(nuisance.min, nuisance.max));
        }
    }
}
