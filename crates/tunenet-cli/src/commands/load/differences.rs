//! In which keys of the scene the recordings of one object differ, and in which they must not.

use std::path::Path;

use anyhow::Result;
use toml_edit::{InlineTable, Value};
use tunenet_core::observation::Note;
use tunenet_formats::Error;

use crate::files::manifest::{ONLY, Source};
use crate::findings;

/// Keys of a file that all recordings of one object share: what is simulated, what is fitted, and what may be missing.
const SHARED: [&str; 8] =
    ["kind", "parameters.", "effects.", "candidates.", "states.", "derivatives.", "outputs.", "events."];
/// What belongs to a single recording anyway, and is nothing of a setup that a written file could keep.
pub(super) const START: &str = "start.";

/// A key of the scene with its value.
type Key = (String, String);

/// The keys of the scene that each recording has for itself, in their order; empty without differences.
#[derive(Debug, Clone, Default)]
pub struct Differences(Vec<Vec<Key>>);

/// The keys that all entries have alike.
pub fn common(entries: &[&Source]) -> Vec<Key> {
    let in_all = |key: &&Key| entries.iter().all(|entry| entry.scene.contains(key));
    entries.first().map_or_else(Vec::new, |first| first.scene.iter().filter(in_all).cloned().collect())
}

impl Differences {
    /// What the entries of one object in `manifest` have besides what is `common` to them.
    ///
    /// # Errors
    /// Where they differ in what all recordings of an object share.
    pub fn of(manifest: Option<&Path>, entries: &[&Source], common: &[Key]) -> Result<Self> {
        let own = |entry: &&Source| entry.scene.iter().filter(|key| !common.contains(key)).cloned().collect();
        let all: Vec<Vec<Key>> = entries.iter().map(own).collect();
        let shared = |key: &str| SHARED.iter().any(|table| key.starts_with(table));
        for (entry, keys) in entries.iter().zip(&all) {
            if let Some((key, _)) = keys.iter().find(|(key, _)| shared(key)) {
                let hint = "give it another `object`, or say the same of all";
                return Err(Error::file(manifest.unwrap_or(Path::new("")), differing(entry, key, entries), hint).into());
            }
        }
        Ok(Self(all))
    }

    /// Those of a recording, as a provenance names them.
    pub fn scene(&self, recording: usize) -> InlineTable {
        let mut keys: Vec<_> = self.0.get(recording).into_iter().flatten().filter(|(key, _)| of_setup(key)).collect();
        keys.sort();
        let value = |text: &str| text.parse::<Value>().unwrap_or_else(|_| text.into());
        keys.into_iter().map(|(key, text)| (key.as_str(), value(text))).collect()
    }

    /// That a written file has only what the recordings have in common, where they differ.
    pub fn note(&self) -> Option<Note> {
        let mut keys: Vec<&str> =
            self.0.iter().flatten().map(|(key, _)| key.as_str()).filter(|key| of_setup(key)).collect();
        keys.sort_unstable();
        keys.dedup();
        let listed = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        let text = format!(
            "the recordings differ in {listed}; the written file keeps what the simulation file says of these keys"
        );
        (!keys.is_empty()).then(|| Note::new(findings::SETUPS_DIFFER, text, ""))
    }
}

/// Whether a key is one of the setup, not of the start of a single recording.
fn of_setup(key: &str) -> bool {
    !key.starts_with(START)
}

/// What an entry has under a key, and what another recording of its object has.
fn differing(entry: &Source, key: &str, entries: &[&Source]) -> String {
    let said = |entry: &Source| {
        let found = entry.scene.iter().find(|(other, _)| other == key);
        found.map_or_else(|| "nothing".into(), |(_, value)| value.clone())
    };
    let other = entries.iter().find(|other| said(other) != said(entry)).unwrap_or(&entries[0]);
    let object = if entry.object == ONLY { "one object".into() } else { format!("`{}`", entry.object) };
    format!(
        "{}: expected the same `{key}` in all recordings of {object} ({} as in `{}`), found {}",
        entry.path.display(),
        said(other),
        other.path.display(),
        said(entry)
    )
}
