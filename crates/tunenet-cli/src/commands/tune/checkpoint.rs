//! Where answered rollouts are kept, so that an interrupted tuning goes on.

use std::path::PathBuf;

use anyhow::Result;
use serde_json::json;
use sha2::{Digest, Sha256};
use tunenet_core::observation::{Note, Observation};
use tunenet_formats::{Recording, RolloutFile};
use tunenet_sim::Session;

use crate::args::Tune;
use crate::commands::load::{self, Setups};
use crate::files::{destination, hash, names};
use crate::findings;
use crate::view::text::stage;

/// The file that the command line names, opened for the rollouts of these recordings.
pub fn open(options: &Tune, setups: &Setups, recordings: &[Recording], channels: usize) -> Result<Option<RolloutFile>> {
    let Some(path) = &options.checkpoint else { return Ok(None) };
    let sha256 = depends_on(options, setups, recordings)?;
    Ok(Some(RolloutFile::open(path, &sha256, channels)?))
}

/// Counts the rollouts that were not simulated again, and says what the file holds; a note where that is not all. Empties the file
/// where a program answered otherwise than before, so that none of its answers can be relied on.
pub fn close(kept: &RolloutFile, session: &Session) -> Result<Option<Note>> {
    if session.drifted() {
        kept.clear()?;
        return Ok(None);
    }
    let used = kept.used();
    session.recalled(used.recalled as u64);
    let name = names::file_name(kept.path());
    let (all, earlier) = (used.kept, used.recalled);
    stage(
        "kept",
        &format!("{name}, {all} rollouts, {earlier} of them from an earlier run; delete it once it is not needed"),
    );
    Ok(used.incomplete.map(|why| {
        let text = format!("{name} holds {all} rollouts and no later ones: {why}");
        Note::new(findings::CHECKPOINT_INCOMPLETE, text, findings::CHECKPOINT_INCOMPLETE.remedy())
    }))
}

/// The SHA-256 of everything that an answer depends on.
fn depends_on(options: &Tune, setups: &Setups, recordings: &[Recording]) -> Result<String> {
    let hashed = |path: PathBuf| hash::sha256(&path);
    let files = (0..recordings.len()).map(|number| setups.file(number).text()).collect::<Vec<_>>();
    let programs = destination::programs(setups.common()).into_iter().map(hashed).collect::<Result<Vec<_>>>()?;
    let mut hash = Sha256::new();
    let scene = json!({
        "tunenet": env!("CARGO_PKG_VERSION"), "simulation": setups.common().text(), "recordings": files, "programs": programs,
        "urdf": load::urdf_hash(&options.simulation)?, "force": options.force,
        "manifest": options.manifest.clone().map(hashed).transpose()?,
        "reference": options.reference.clone().map(hashed).transpose()?,
    });
    hash.update(scene.to_string());
    for recording in recordings {
        observed(&recording.observation, &mut hash);
    }
    Ok(hex::encode(hash.finalize()))
}

/// Hashes what a recording holds, inputs and initial state included.
fn observed(seen: &Observation, hash: &mut Sha256) {
    hash.update(format!("{:?} {:?} {}", seen.kind(), seen.channels(), seen.len()));
    for number in seen.clock().iter().chain(seen.values()) {
        hash.update(number.to_bits().to_le_bytes());
    }
    let Some(known) = seen.circumstances() else { return };
    hash.update(format!("{} {:?} {:?} {}", known.setup, known.start_s, known.start, known.inputs.len()));
    for input in &known.inputs {
        hash.update(format!("{:?}", input.hold()));
        observed(input.series(), hash);
    }
}
