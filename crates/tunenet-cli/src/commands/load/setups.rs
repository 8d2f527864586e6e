//! The setups of one object: what differs between its recordings besides what was recorded.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Kind;
use tunenet_core::simulator::Simulator;
use tunenet_formats::Error;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{Session, SimulationFile, observed};

use super::scene::in_scene;
use crate::files::manifest::Source;

/// Tables of a file that all recordings of one object share: what is fitted, and what may be missing.
const SHARED: [&str; 3] = ["parameters.", "effects.", "candidates."];

/// The simulation files of one object's recordings.
#[derive(Debug, Clone)]
pub struct Setups {
    /// What its recordings have in common.
    common: SimulationFile,
    /// A file for each setup; never empty.
    files: Vec<SimulationFile>,
    /// Which of them each recording has, in their order.
    of: Vec<usize>,
}

impl Setups {
    /// Recordings without any differences.
    pub fn alike(file: &SimulationFile, recordings: usize) -> Self {
        Self { common: file.clone(), files: vec![file.clone()], of: vec![0; recordings] }
    }

    /// The setups of one object's entries in `manifest`, with `file` for what they do not say.
    ///
    /// # Errors
    /// Where a key does not fit, or a setup differs in what all recordings of an object share.
    pub fn of(manifest: Option<&Path>, file: &SimulationFile, entries: &[&Source]) -> Result<Self> {
        let in_all = |key: &(String, String)| entries.iter().all(|entry| entry.scene.contains(key));
        let common =
            entries.first().map_or_else(Vec::new, |first| first.scene.iter().filter(|k| in_all(k)).cloned().collect());
        let own = |entry: &Source| entry.scene.iter().filter(|key| !common.contains(key)).cloned().collect::<Vec<_>>();
        if let Some(entry) = entries.iter().find(|entry| refused(file, &own(entry))) {
            return Err(Error::file(manifest.unwrap_or(Path::new("")), differing(entry, entries), ANOTHER).into());
        }
        let mut setups: Vec<(Vec<(String, String)>, SimulationFile)> = Vec::new();
        let mut of = Vec::with_capacity(entries.len());
        for entry in entries {
            let mut scene = entry.scene.clone();
            scene.sort();
            let known = setups.iter().position(|(other, _)| *other == scene);
            if known.is_none() {
                setups.push((scene, in_scene(manifest, entry, file)?));
            }
            of.push(known.unwrap_or(setups.len() - 1));
        }
        let whole = Source { scene: common.clone(), ..Source::alone(Path::new(""), "", None) };
        // What only some say may be needed by what all say, so that the common part alone need not fit together.
        let common = in_scene(manifest, &whole, file).unwrap_or_else(|_| file.clone());
        Ok(Self { common, files: setups.into_iter().map(|(_, file)| file).collect(), of })
    }

    /// What the recordings have in common, as a simulation file.
    pub fn common(&self) -> &SimulationFile {
        &self.common
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
    /// As [`observed::simulator`].
    pub fn simulator(&self, kind: Kind, session: &Session) -> tunenet_formats::Result<Box<dyn Simulator>> {
        if self.common.domain() == Domain::Process && kind == Kind::Other {
            return observed::program(&self.files.iter().collect::<Vec<_>>(), session);
        }
        observed::simulator(&self.files[0], kind, session)
    }
}

const ANOTHER: &str = "give it another `object`, or say the same of all";

/// Whether recordings of one object cannot differ in this.
fn refused(file: &SimulationFile, scene: &[(String, String)]) -> bool {
    let shared = |key: &str| SHARED.iter().any(|table| key.starts_with(table));
    scene.iter().any(|(key, _)| file.domain() != Domain::Process || shared(key))
}

/// What an entry has to have as the first of its object, and what it has; of the first itself, the next that differs from it.
fn differing(entry: &Source, entries: &[&Source]) -> String {
    let listed = |scene: &[(String, String)]| {
        let each: Vec<String> = scene.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        if each.is_empty() { "no keys of the scene".into() } else { each.join(", ") }
    };
    let first = entries[0];
    let next = || entries.iter().copied().find(|other| other.scene != first.scene).unwrap_or(first);
    let entry = if entry.path == first.path { next() } else { entry };
    format!(
        "{}: expected {} as for `{}`, another recording of `{}`, found {}",
        entry.path.display(),
        listed(&first.scene),
        first.path.display(),
        entry.object,
        listed(&entry.scene)
    )
}
