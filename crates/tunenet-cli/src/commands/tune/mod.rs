//! `tunenet tune`.
//!
//! | file | subject |
//! |---|---|
//! | `checkpoint` | where answered rollouts are kept |
//! | `fit` | one fit: which simulator, which network, and what to say of it |
//! | `manifest` | what a manifest says of the recordings |
//! | `network` | which network it starts with |
//! | `notes` | what it says besides its numbers |
//! | `paths` | what is read and written |
//! | `read` | a recording and its reference run |
//! | `simulated` | what simulates the recordings |
//! | `each` | every recording separately |
//! | `written` | the simulation file with the answer in it |

mod checkpoint;
mod each;
mod fit;
mod manifest;
mod network;
mod notes;
mod paths;
mod read;
mod simulated;
mod written;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use tunenet_core::observation::Observation;
use tunenet_core::tune::{Detail, Outcome};
use tunenet_formats::{Recording, load_model};
use tunenet_sim::Session;

pub use self::manifest::entries;
use self::paths::{inputs, outputs, provenance};
use self::read::read;
use self::written::{check, write_others, write_tuned};
use super::load::{self, Setups};
use super::video::TrackFailure;
use crate::answers::tune::{Fitted, Spent};
use crate::args::{Tune, pool};
use crate::exit_status::Exit;
use crate::files::{destination, hash, names};
use crate::view::answer::Printout;
use crate::view::html::{self, tune::Answer};
use crate::view::json::tune as json;
use crate::view::text::stage;
use crate::view::text::tune::{printout, render_end, render_start};

pub fn run(options: &Tune) -> Result<Exit> {
    options.apart.check(options.each)?;
    let urdf = options.simulation.urdf_set();
    let named = inputs(options);
    let inputs: Vec<&Path> = named.iter().map(PathBuf::as_path).chain(urdf.as_deref()).collect();
    destination::check(&outputs(options)?, &inputs, options.writing.overwrite)?;
    let (file, session) = load::simulation_with(&options.simulation, options.permission)?;
    check(options, &file)?;
    let model = options.model.as_ref().map(load_model).transpose()?;
    let entries = entries(options)?;
    if options.each {
        return each::run(options, &file, &session, model.as_ref(), &entries);
    }
    let setups = manifest::setups(options, &file, &entries)?;
    let began = Instant::now();
    hash::refuse_copies(options.observation.iter().map(AsRef::as_ref))?;
    let threads = pool(options.jobs)?;
    let each = || options.observation.iter().enumerate();
    let all = || each().map(|(i, path)| read(path, options, &setups, i)).collect::<Result<Vec<_>>>();
    let recordings = threads.install(all);
    let recordings = match recordings {
        Ok(recordings) => recordings,
        Err(error) => return rejected_video(error, options.common.json),
    };
    let Fitted { outcome, chosen, re_asks } = threads
        .install(|| fit::tune_to(options, &setups, &session, model.as_ref(), &recordings, &options.observation))?;
    if let Some(out) = &options.out {
        write_tuned(options, &setups, &recordings, &outcome, out)?;
    }
    let spent = Spent { seconds: began.elapsed().as_secs_f64(), re_asks };
    render_start(&options.observation, &outcome, &chosen);
    let names: Vec<String> = options.observation.iter().map(|path| names::file_name(path)).collect();
    printout(&outcome, &names).show(options.common.json, || json::object(&outcome, &names, &chosen, spent))?;
    write_others(options, &setups, &outcome)?;
    render_end(options.out.as_deref(), options.common.seed, &outcome, spent);
    let exit = Exit::from(outcome.verdict);
    if let Some(report) = &options.report {
        let working = fit::working(&file, &session, "drawing");
        let answer = answer(&setups, &session, names, recordings, outcome, options.drawn(setups.common().domain()))?;
        working.finish_and_clear();
        html::tune::together(report, &answer, &provenance(options))?;
        stage("report", &report.display().to_string());
    }
    Ok(exit)
}

/// An outcome with what a report draws of it.
fn answer(
    setups: &Setups,
    session: &Session,
    names: Vec<String>,
    recordings: Vec<Recording>,
    outcome: Outcome,
    detail: Detail,
) -> Result<Answer> {
    let seen: Vec<Observation> = recordings.into_iter().map(|r| r.observation).collect();
    let simulator = setups.simulator(seen[0].kind(), session)?;
    Ok(Answer::new(&simulator, names, seen, outcome, detail)?)
}

/// A video that shows no ball to tune to is an answer; every other error stays one.
fn rejected_video(error: anyhow::Error, as_json: bool) -> Result<Exit> {
    let rejected_video = error.downcast::<TrackFailure>()?;
    let mut shown = Printout::default();
    shown.verdict(&format!("REJECTED  {rejected_video}"));
    shown.warn(&rejected_video.note);
    shown.show(as_json, || json::rejected(&rejected_video.note))?;
    Ok(Exit::Inconclusive)
}
