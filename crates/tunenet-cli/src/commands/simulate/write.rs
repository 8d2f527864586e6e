//! What `simulate` writes.

use std::path::{Path, PathBuf};

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::observation::Observation;
use tunenet_formats::{Action, Error, kind_name, write_csv, write_mcap};

use crate::args::Simulate;
use crate::exit_status::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::{hash, names};
use crate::view::answer::Printout;
use crate::view::text::stage;

/// Writes each into the folder `--out`.
pub fn write_all(options: &Simulate, inputs: &[&Path], all: &[(String, Observation)]) -> Result<Exit> {
    let paths: Vec<PathBuf> = all.iter().map(|(name, _)| options.out.join(format!("{name}.csv"))).collect();
    let outputs: Vec<Output> = paths
        .iter()
        .map(|path| Output { makes_folder: true, ..Output::new(path, "--out", Product::Unmarked) })
        .collect();
    destination::check(&outputs, inputs, true)?;
    std::fs::create_dir_all(&options.out).map_err(|e| Error::io(&options.out, Action::Creating, e))?;
    for (path, (_, observation)) in paths.iter().zip(all) {
        write(options, path, observation)?;
    }
    Printout::default().show(options.common.json, || {
        let files: Vec<Value> = paths.iter().zip(all).map(|(path, (_, seen))| described(path, seen)).collect();
        json!({ "schema": "tunenet.simulate.files/1", "files": files, "warnings": [] })
    })?;
    Ok(Exit::Done)
}

pub fn described(path: &Path, observation: &Observation) -> Value {
    json!({
        "schema": "tunenet.simulate/1", "file": names::file_name(path), "kind": kind_name(observation.kind()),
        "samples": observation.len(), "warnings": [],
    })
}

/// Writes what was simulated, and says so.
pub fn write(options: &Simulate, path: &Path, observation: &Observation) -> Result<()> {
    let csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let write = |to: &Path| if csv { write_csv(observation, to) } else { write_mcap(observation, to) };
    if options.writing.overwrite || !destination::holds_something(path) {
        write(path)?;
    } else {
        let again = tempfile::NamedTempFile::new()?;
        write(again.path())?;
        if hash::sha256(again.path())? != hash::sha256(path)? {
            return Err(destination::taken(&Output::new(path, "--out", Product::Unmarked)).into());
        }
    }
    stage("wrote", &format!("{}, {} samples", path.display(), observation.len()));
    Ok(())
}
