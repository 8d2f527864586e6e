//! `tunenet tune --each`: every recording separately.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::network::Model;
use tunenet_core::{Error, Origin};
use tunenet_sim::{Session, SimulationFile};

use super::paths::{input_files, provenance};
use super::read::read;
use super::{answer, fit};
use crate::answers::tune::{Fitted, Spent};
use crate::args::Tune;
use crate::commands::each::{Answered, Work};
use crate::commands::load::{self, Setups};
use crate::exit_status::Exit;
use crate::files::manifest::Source;
use crate::files::{hash, names};
use crate::view::html;
use crate::view::json::tune as tune_json;
use crate::view::text::stage;
use crate::view::text::tune::sentence;

/// Fits each recording separately.
pub fn run(
    options: &Tune,
    file: &SimulationFile,
    session: &Session,
    model: Option<&Model>,
    entries: &[Source],
) -> Result<Exit> {
    if options.out.is_some() {
        let (expected, found) = ("no `--out` with `--each`, which has several results".into(), "both".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--out", expected, found }.into());
    }
    if options.apart.out_dir.is_some() && options.report.is_some() {
        let (expected, found) =
            ("no `--report` with `--out-dir`, which stores results without drawings".into(), "both".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--report", expected, found }.into());
    }
    let work = Work {
        tool: "tune",
        observation: &options.observation,
        inputs: input_files(options),
        apart: &options.apart,
        jobs: options.jobs,
        json: options.common.json,
        overwrite: options.writing.overwrite,
        run: decides(options, file)?,
    };
    let (exit, cases) = work.run(&|path, name| {
        let began = Instant::now();
        let entry: Vec<&Source> = entries.iter().filter(|entry| entry.path == path).take(1).collect();
        let setups = if entry.is_empty() {
            Setups::alike(file, 1)
        } else {
            Setups::of(options.manifest.as_deref(), file, &entry)?
        };
        let recording = read(path, options, &setups, 0)?;
        let Fitted { outcome, chosen, re_asks } =
            fit::tune_to(options, &setups, session, model, std::slice::from_ref(&recording), &[path.into()])?;
        let spent = Spent { seconds: began.elapsed().as_secs_f64(), re_asks };
        let object = tune_json::object(&outcome, &[names::file_name(path)], &chosen, spent);
        let line = sentence(&outcome);
        let drawn = || {
            answer(
                &setups,
                session,
                vec![name.to_owned()],
                vec![recording],
                outcome,
                options.drawn(setups.common().domain()),
            )
        };
        let case = options.report.is_some().then(drawn).transpose()?;
        Ok(Answered { object, line, case })
    })?;
    if let Some(path) = &options.report {
        html::tune::each(path, &cases, &provenance(options))?;
        stage("report", &path.display().to_string());
    }
    Ok(exit)
}

/// Everything but the recordings that decides what comes out.
fn decides(options: &Tune, file: &SimulationFile) -> Result<Value> {
    let hash = |path: &Option<PathBuf>| path.as_deref().map(hash::sha256).transpose();
    Ok(json!({
        "simulation": file.text(), "manifest": hash(&options.manifest)?, "urdf": load::urdf_hash(&options.simulation)?,
        "reading": format!("{:?}", options.reading), "reference": hash(&options.reference)?,
        "model": hash(&options.model)?, "initial": options.initial, "iterations": options.iterations,
        "clamp": options.clamp, "force": options.force, "seed": options.common.seed,
    }))
}
