//! `tunenet tune`.
//!
//! | file | subject |
//! |---|---|
//! | `model` | which network the loop asks |
//! | `text` | the answer as JSON and as text |
//! | `written` | the simulation file with the answer in it |

mod model;
mod text;
mod written;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use serde_json::{Value, json};
use tunenet_core::findings;
use tunenet_core::network::Model;
use tunenet_core::observation::{Kind, Note, Observation};
use tunenet_core::tune::{Outcome, Settings, Verdict, tune};
use tunenet_core::{Error, Origin};
use tunenet_formats::Recording;
use tunenet_formats::{kind_name, load_model};
use tunenet_sim::replayed_arm::{replays, suspect};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{ObservedBall, Session, SimulationFile, observed, simulator};

use self::model::Chosen;
use self::text::{as_json, printout, render_end, render_start, sentence};
use self::written::write_tuned;
use super::each::{Answered, Work};
use super::model_cache::Cache;
use super::refusal::{self, Asked};
use super::{load, start, video};
use crate::args::{Tune, pool};
use crate::failure::Exit;
use crate::files::destination::{self, Output, Product};
use crate::files::{hash, names};
use crate::view::html::{self, tune::Answer};
use crate::view::text::{rolling, stage};

const SCHEMA: &str = "tunenet.tune/1";

pub fn run(options: &Tune) -> Result<Exit> {
    options.apart.check(options.each)?;
    let urdf = options.simulation.urdf_set();
    let inputs: Vec<&Path> = inputs(options).chain(urdf.as_deref()).collect();
    destination::check(&outputs(options), &inputs, options.writing.overwrite)?;
    let (file, session) = load::simulation_with(&options.simulation, options.leave)?;
    start::check(options, &file)?;
    let model = options.model.as_ref().map(load_model).transpose()?;
    if options.each {
        return each(options, &file, &session, model.as_ref());
    }
    let began = Instant::now();
    hash::refuse_copies(options.observation.iter().map(AsRef::as_ref))?;
    let threads = pool(options.jobs)?;
    let all = || options.observation.iter().map(|path| read(path, options, &file)).collect::<Result<Vec<_>>>();
    let recordings = threads.install(all);
    let recordings = match recordings {
        Ok(recordings) => recordings,
        Err(error) => return video::render_unseen(error, SCHEMA, options.common.json),
    };
    let (outcome, chosen) =
        threads.install(|| tune_to(options, &file, &session, model.as_ref(), &recordings, &options.observation))?;
    if let Some(out) = &options.out {
        write_tuned(options, &file, &recordings, &outcome, out)?;
    }
    let seconds = began.elapsed().as_secs_f64();
    render_start(options, &outcome, &chosen);
    printout(&outcome).show(options.common.json, || as_json(&outcome, &chosen, seconds))?;
    render_end(options, &outcome, seconds);
    let exit = exit(outcome.verdict);
    if let Some(report) = &options.report {
        let names = options.observation.iter().map(|path| names::file_name(path)).collect();
        let working = is_slow(&file, options).then(|| rolling("drawing", &session));
        let answer = answer(&file, &session, names, recordings, outcome)?;
        working.inspect(ProgressBar::finish_and_clear);
        html::tune::together(report, &answer, &provenance(options))?;
        stage("report", &report.display().to_string());
    }
    Ok(exit)
}

/// What is read, and must not be lost.
fn inputs(options: &Tune) -> impl Iterator<Item = &Path> {
    let scene = std::iter::once(options.simulation.sim.as_path());
    scene
        .chain(options.observation.iter().map(AsRef::as_ref))
        .chain(options.model.as_deref())
        .chain(options.reference.as_deref())
}

fn outputs(options: &Tune) -> Vec<Output> {
    let out = options.out.iter().map(|out| Output::new(out, "--out", Product::Simulation));
    let report = options.report.iter().map(|report| Output::new(report, "--report", Product::Page));
    out.chain(report).collect()
}

fn provenance(options: &Tune) -> html::Provenance {
    html::Provenance::new(options.common.seed, &inputs(options).collect::<Vec<_>>())
}

/// An outcome with what a report draws of it.
fn answer(
    file: &SimulationFile,
    session: &Session,
    names: Vec<String>,
    recordings: Vec<Recording>,
    outcome: Outcome,
) -> Result<Answer> {
    let seen: Vec<Observation> = recordings.into_iter().map(|r| r.observation).collect();
    let ball = simulator(file, seen[0].kind(), session)?;
    Ok(Answer::new(&ball, names, seen, outcome)?)
}

/// Each observation on its own.
fn each(options: &Tune, file: &SimulationFile, session: &Session, model: Option<&Model>) -> Result<Exit> {
    if options.out.is_some() {
        let (expected, found) = ("no `--out` beside `--each`, which has several answers".into(), "both".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--out", expected, found }.into());
    }
    if options.apart.out_dir.is_some() && options.report.is_some() {
        let (expected, found) =
            ("no `--report` beside `--out-dir`, which keeps answers without drawings".into(), "both".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--report", expected, found }.into());
    }
    let work = Work {
        tool: "tune",
        observation: &options.observation,
        apart: &options.apart,
        jobs: options.jobs,
        json: options.common.json,
        overwrite: options.writing.overwrite,
        run: decides(options, file)?,
    };
    let (exit, cases) = work.run(&|path, name| {
        let began = Instant::now();
        let recording = read(path, options, file)?;
        let (outcome, chosen) =
            tune_to(options, file, session, model, std::slice::from_ref(&recording), &[path.into()])?;
        let object = as_json(&outcome, &chosen, began.elapsed().as_secs_f64());
        let line = sentence(&outcome);
        let drawn = || answer(file, session, vec![name.to_owned()], vec![recording], outcome);
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
        "simulation": file.text(), "urdf": load::urdf_hash(&options.simulation)?,
        "reading": format!("{:?}", options.reading), "reference": hash(&options.reference)?,
        "model": hash(&options.model)?, "initial": options.initial, "iterations": options.iterations,
        "clamp": options.clamp, "force": options.force, "seed": options.common.seed,
    }))
}

fn read(path: &Path, options: &Tune, file: &SimulationFile) -> Result<Recording> {
    let recording = load::recording_of(file, path, &options.reading, load::MOST_SAMPLES)?;
    let recording = load::beside(file, recording, options.reference.as_deref(), &options.reading)?;
    let seen = &recording.observation;
    let clock = seen.clock();
    let span = if seen.kind() == Kind::EventTimes {
        format!("{} bounces", seen.len())
    } else {
        format!("{} samples, {:.2} s", seen.len(), clock[clock.len() - 1] - clock[0])
    };
    if !options.each {
        stage("read", &format!("{}, {span}", names::file_name(path)));
    }
    Ok(recording)
}

fn tune_to(
    options: &Tune,
    file: &SimulationFile,
    session: &Session,
    model: Option<&Model>,
    recordings: &[Recording],
    paths: &[PathBuf],
) -> Result<(Outcome, Chosen)> {
    // With `--each` several may be tuned to at a time.
    let session = &session.counted_separately();
    let kind = recordings[0].observation.kind();
    if let Some(other) = recordings.iter().position(|r| r.observation.kind() != kind) {
        let found = kind_name(recordings[other].observation.kind());
        let message = format!("expected {} as in {}, found {found}", kind_name(kind), names::file_name(&paths[0]));
        return Err(Error::file(&paths[other], message, "tune to each kind alone, or use `--each`").into());
    }
    let arm = file.domain() == Domain::Arm;
    let process = file.domain() == Domain::Process;
    let learned = |model: &Model| {
        arm || process || kind == Kind::Positions || kind == Kind::Pixels && !model.target_channels().is_empty()
    };
    if !model.is_none_or(learned) {
        let why = if kind == Kind::Pixels { "this model does not see" } else { "need no model" };
        let (expected, found) = ("positions".into(), format!("{}, which {why}", kind_name(kind)));
        return Err(Error::Model { what: "input".into(), expected, found }.into());
    }
    if model.is_some() && recordings.len() > 1 {
        let expected = "no model beside several observations, or --each".into();
        return Err(Error::Setting { origin: Origin::Flag, name: "--model", expected, found: "one".into() }.into());
    }
    let filmed = kind == Kind::Pixels;
    let bare = if filmed || arm || process || kind == Kind::Joints {
        None
    } else {
        Some(ObservedBall::new(file, kind).with_context(|| names(paths))?)
    };
    let bare = bare.map(|ball| ball.forced(options.force));
    let ball = match &bare {
        Some(bare) => observed::around(file, bare.clone())?,
        // What it refuses is the simulation file's or the URDF's, and says so.
        None if arm || process => simulator(file, kind, session)?,
        None => simulator(file, kind, session).with_context(|| names(paths))?,
    };
    let paper = model.is_some_and(|m| m.preset().name == "paper");
    let settings = Settings {
        iterations: usize::from(options.iterations),
        initial: options.initial.clone(),
        // A payload below 0 cannot be simulated.
        clamp: options.clamp || !paper || arm,
        finish: !paper,
        names: if options.each { Vec::new() } else { paths.iter().map(|p| names::file_name(p)).collect() },
    };
    let seen: Vec<_> = recordings.iter().map(|r| r.observation.clone()).collect();
    let cache = if options.no_cache { Cache::none() } else { Cache::of_user() };
    let seed = options.common.seed;
    let chosen = match (model, &bare) {
        (Some(model), _) => Chosen::given(model),
        (None, Some(bare)) => model::choose(file, bare, recordings, seed, &cache),
        (None, None) if arm => model::none("not needed: torques are almost linear in the payload".into()),
        (None, None) if process => model::none(
            "none: the fit has starts of its own; one that learned from `gen process` goes with --model".into(),
        ),
        (None, None) => model::none("none: give one that learned from `gen ball-video` with --model".into()),
    };
    let working = is_slow(file, options).then(|| rolling("tuning", session));
    let tuned = tune(&ball, &seen, chosen.model.as_ref(), &settings);
    // What the tool chose by itself must not be what fails.
    let again = tuned.is_err() && chosen.own_choice() && chosen.model.is_some();
    let tuned = if again { tune(&ball, &seen, None, &settings) } else { tuned };
    working.inspect(ProgressBar::finish_and_clear);
    // A fit takes a rollout that fails for bad values; a program that is gone is none of that.
    session.settle()?;
    if let Some(refusal) = tuned.as_ref().err().and_then(|error| refusal::of_program(file, Asked::Present, error)) {
        return Err(refusal.into());
    }
    let mut outcome = tuned.with_context(|| names(paths))?;
    outcome
        .notes
        .iter_mut()
        .filter(|note| note.kind == findings::FIT_POOR)
        .for_each(|note| note.remedy = DIAGNOSE.into());
    if replays(file) {
        suspect(file, &mut outcome, options.reference.is_some());
        outcome.notes.splice(0..0, load::lacks(file)?);
    }
    let several = recordings.len() > 1;
    let named = paths.iter().zip(recordings).flat_map(|(path, recording)| {
        recording.notes.iter().map(move |note| {
            let which = if several { format!("{}: ", names::file_name(path)) } else { String::new() };
            Note { text: format!("{which}{}", note.text), ..note.clone() }
        })
    });
    outcome.notes.splice(0..0, named);
    outcome.notes.extend(chosen.notes.iter().cloned());
    outcome.notes.extend(session.notes());
    Ok((outcome, chosen))
}

/// What to type where a fit is poor.
const DIAGNOSE: &str =
    "`tunenet diagnose` with the same files names the effect that is missing, or says that it is none it knows";

/// Whether it may take long and nothing else shows that it goes on: all of ours take no longer in all than a slow program for one
/// rollout.
fn is_slow(file: &SimulationFile, options: &Tune) -> bool {
    file.domain() == Domain::Process && !options.each && !options.common.json
}

fn names(paths: &[PathBuf]) -> String {
    if paths.len() == 1 { names::file_name(&paths[0]) } else { "these observations".into() }
}

fn exit(verdict: Verdict) -> Exit {
    if verdict == Verdict::Tuned { Exit::Done } else { Exit::Inconclusive }
}
