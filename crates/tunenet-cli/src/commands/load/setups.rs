//! The setups of one object: what differs between its recordings besides what was recorded.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::{Circumstances, Kind};
use tunenet_core::simulator::Simulator;
use tunenet_formats::Recording;
use tunenet_sim::{Session, SimulationFile, observed};

use super::differences::{self, Differences};
use super::scene::in_scene;
use crate::files::manifest::Source;

/// The simulation files of one object's recordings.
#[derive(Debug, Clone)]
pub struct Setups {
    /// What its recordings have in common.
    common: SimulationFile,
    /// A file for each setup; never empty.
    files: Vec<SimulationFile>,
    /// Which of them each recording has, in their order.
    of: Vec<usize>,
    differences: Differences,
}

impl Setups {
    /// Recordings without any differences.
    pub fn alike(file: &SimulationFile, recordings: usize) -> Self {
        Self {
            common: file.clone(),
            files: vec![file.clone()],
            of: vec![0; recordings],
            differences: Differences::default(),
        }
    }

    /// The setups of one object's entries in `manifest`, with `file` for what they do not say.
    ///
    /// # Errors
    /// Where a key does not fit, or a setup differs in what all recordings of an object share.
    pub fn of(manifest: Option<&Path>, file: &SimulationFile, entries: &[&Source]) -> Result<Self> {
        let common = differences::common(entries);
        let differences = Differences::of(manifest, entries, &common)?;
        let mut files: Vec<SimulationFile> = Vec::new();
        let mut scenes: Vec<Vec<(String, String)>> = Vec::with_capacity(entries.len());
        let mut of: Vec<usize> = Vec::with_capacity(entries.len());
        for entry in entries {
            let mut scene = entry.scene.clone();
            scene.sort();
            let number = if let Some(same) = scenes.iter().position(|other| *other == scene) {
                of[same]
            } else {
                // Keys that say what the file says already make no other setup.
                let made = in_scene(manifest, entry, file)?;
                files.iter().position(|other| other.text() == made.text()).unwrap_or_else(|| {
                    files.push(made);
                    files.len() - 1
                })
            };
            scenes.push(scene);
            of.push(number);
        }
        let differences = if files.len() > 1 { differences } else { Differences::default() };
        let whole = Source { scene: common, ..Source::alone(Path::new(""), "", None) };
        // What only some say may be needed by what all say, so that the common part alone need not fit together.
        let common = in_scene(manifest, &whole, file).unwrap_or_else(|_| file.clone());
        Ok(Self { common, files, of, differences })
    }

    /// What the recordings have in common, as a simulation file.
    pub fn common(&self) -> &SimulationFile {
        &self.common
    }

    /// The files of all setups.
    pub fn files(&self) -> Vec<&SimulationFile> {
        self.files.iter().collect()
    }

    /// `recording` with the number of its setup, where there are several and it has none yet.
    pub fn placed(&self, number: usize, recording: Recording) -> Recording {
        if self.files.len() == 1 || recording.observation.circumstances().is_some() {
            return recording;
        }
        let known = Circumstances { setup: self.number(number), ..Circumstances::default() };
        Recording { observation: recording.observation.under(known), ..recording }
    }

    /// The keys of the scene that each recording has for itself.
    pub fn differences(&self) -> &Differences {
        &self.differences
    }

    /// The simulation file of a recording.
    pub fn file(&self, recording: usize) -> &SimulationFile {
        &self.files[self.number(recording)]
    }

    /// Which setup a recording has.
    pub fn number(&self, recording: usize) -> usize {
        self.of.get(recording).copied().unwrap_or(0)
    }

    /// The simulator of the recordings.
    ///
    /// # Errors
    /// As [`observed::in_setups`].
    pub fn simulator(&self, kind: Kind, session: &Session) -> tunenet_formats::Result<Box<dyn Simulator>> {
        observed::in_setups(&self.files(), kind, session)
    }
}
