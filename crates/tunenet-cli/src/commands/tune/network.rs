//! Which network a fit starts with, and which recordings one has no use for.

use anyhow::Result;
use indicatif::ProgressBar;
use tunenet_core::network::Model;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::{Error, Origin};
use tunenet_formats::kind_name;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{ChosenNetwork, ObservedBall, SimulationFile, choose_network};

use crate::args::Tune;
use crate::files::model_cache::Cache;
use crate::view::text::progress;

/// Refuses a network that has no use for these recordings.
pub fn require_use(model: &Model, file: &SimulationFile, kind: Kind, recordings: usize) -> Result<()> {
    let learned = file.domain() != Domain::Ball
        || kind == Kind::Positions
        || kind == Kind::Pixels && !model.target_channels().is_empty();
    if !learned {
        let why = if kind == Kind::Pixels { "which this network was not trained on" } else { "which need no network" };
        let (expected, found) = ("positions".into(), format!("{}, {why}", kind_name(kind)));
        return Err(Error::Model { what: "does not fit the recording".into(), expected, found }.into());
    }
    if recordings > 1 {
        let expected = "no network with several recordings, or `--each`".into();
        return Err(Error::Setting { origin: Origin::Flag, name: "--model", expected, found: "one".into() }.into());
    }
    Ok(())
}

/// The network that the fit starts with.
pub fn choose(
    options: &Tune,
    file: &SimulationFile,
    model: Option<&Model>,
    bare: &[ObservedBall],
    seen: &[Observation],
) -> ChosenNetwork {
    match (model, bare) {
        (Some(model), _) => ChosenNetwork::given(model),
        (None, [bare]) => {
            let cache = if options.no_cache { Cache::none() } else { Cache::of_user() };
            let mut bar = None;
            let chosen = choose_network(file, bare, seen, options.common.seed, &cache, &mut |step, steps| {
                bar.get_or_insert_with(|| progress(steps, "training")).set_position(step);
            });
            bar.inspect(ProgressBar::finish_and_clear);
            chosen
        }
        (None, [_, ..]) => {
            ChosenNetwork::none("none: the recordings differ in keys of the scene; the fit has its own starts")
        }
        (None, []) => ChosenNetwork::none(match file.domain() {
            Domain::Arm => "not needed: torques are almost linear in the payload",
            Domain::Process => "none: the fit has its own starts; pass a network trained on `gen process` with --model",
            Domain::Equations => {
                "none: the fit has its own starts; pass a network trained on `gen equations` with --model"
            }
            Domain::Robot => "none: the fit has its own starts; pass a network trained on `gen robot` with --model",
            Domain::Ball => "none: pass a network trained on `gen ball-video` with --model",
        }),
    }
}
