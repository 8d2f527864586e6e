//! One fit: the simulator and the network for the recordings, the fit, and what it should say besides its numbers.

use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use tunenet_core::network::Model;
use tunenet_core::observation::Kind;
use tunenet_core::tune::{RolloutStore, Settings, Watch, tune};
use tunenet_formats::{Error, Recording, kind_name};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{Session, SimulationFile};

use super::{checkpoint, network, notes, simulated};
use crate::answers::tune::Fitted;
use crate::args::Tune;
use crate::commands::load::Setups;
use crate::commands::refusal::{self, Asked};
use crate::files::names;
use crate::view::text::{self, FitProgress, rolling};

/// Tunes to recordings together.
pub fn tune_to(
    options: &Tune,
    setups: &Setups,
    session: &Session,
    model: Option<&Model>,
    recordings: &[Recording],
    paths: &[PathBuf],
) -> Result<Fitted> {
    let file = setups.common();
    // With `--each` several fits may run at a time.
    let session = &session.counted_separately();
    let kind = one_kind(recordings, paths)?;
    if let Some(model) = model {
        network::require_use(model, file, kind, recordings.len())?;
    }
    let (simulator, bare) = simulated::of(options, setups, kind, session, || names(paths))?;
    let kept = checkpoint::open(options, setups, recordings, simulator.channels().len())?.map(Arc::new);
    let paper = model.is_some_and(|m| m.preset().name == "paper");
    // On a terminal the object and a bar would stand in each other's way.
    let silent = options.each || options.common.json && std::io::stderr().is_terminal();
    let working = (!silent).then(|| working(file, session, "tuning"));
    let settings = Settings {
        iterations: usize::from(options.iterations),
        initial: options.initial.clone(),
        // A payload below 0 cannot be simulated.
        clamp: options.clamp || !paper || file.domain() == Domain::Arm,
        finish: !paper,
        quick: options.quick,
        max_rollouts: options.max_rollouts,
        store: kept.clone().map(|kept| kept as Arc<dyn RolloutStore>),
        watch: working.as_ref().map(|bar| Arc::new(FitProgress::on(bar)) as Arc<dyn Watch>),
        names: if options.each { Vec::new() } else { paths.iter().map(|p| names::file_name(p)).collect() },
    };
    let seen: Vec<_> = recordings.iter().map(|r| r.observation.clone()).collect();
    let chosen = network::choose(options, file, model, &bare, &seen);
    let tuned = tune(&simulator, &seen, chosen.model.as_ref(), &settings);
    // What the tool chose by itself must not be what fails.
    let again = tuned.is_err() && chosen.is_own_choice();
    let tuned = if again { tune(&simulator, &seen, None, &settings) } else { tuned };
    working.inspect(ProgressBar::finish_and_clear);
    // A fit takes a rollout that fails for bad values; a program that is gone is none of that.
    let settled = session.settle();
    let incomplete = kept.and_then(|kept| checkpoint::close(&kept, session).transpose()).transpose()?;
    settled?;
    if let Some(refusal) = tuned.as_ref().err().and_then(|error| refusal::of_program(file, Asked::Present, error)) {
        return Err(refusal.into());
    }
    let mut outcome = tuned.with_context(|| names(paths))?;
    notes::add(options, file, recordings, paths, &mut outcome)?;
    outcome.notes.extend(chosen.notes.iter().cloned());
    outcome.notes.extend(session.notes());
    outcome.notes.extend(incomplete);
    outcome.notes.extend(options.out.as_ref().and_then(|_| setups.differences().note()));
    if file.domain() == Domain::Process {
        // Equal requests were simulated once.
        outcome.rollouts = usize::try_from(session.rollouts()).unwrap_or(usize::MAX);
    }
    Ok(Fitted { outcome, chosen, re_asks: session.rechecks() })
}

/// All recordings have to be of one kind.
fn one_kind(recordings: &[Recording], paths: &[PathBuf]) -> Result<Kind> {
    let kind = recordings[0].observation.kind();
    let Some(other) = recordings.iter().position(|r| r.observation.kind() != kind) else { return Ok(kind) };
    let found = kind_name(recordings[other].observation.kind());
    let message = format!("expected {} as in {}, found {found}", kind_name(kind), names::file_name(&paths[0]));
    Err(Error::file(&paths[other], message, "tune to each kind separately, or use `--each`").into())
}

/// Shows that it goes on, with the number of rollouts where a program is asked for them.
pub fn working(file: &SimulationFile, session: &Session, what: &'static str) -> ProgressBar {
    if file.domain() == Domain::Process { rolling(what, session) } else { text::working(what) }
}

fn names(paths: &[PathBuf]) -> String {
    if paths.len() == 1 { names::file_name(&paths[0]) } else { "these recordings".into() }
}
