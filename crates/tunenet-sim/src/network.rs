//! Which network a fit starts with: the one given, the built-in one, or one for the scene, from a store or trained on the spot.

use std::time::Instant;

use rayon::prelude::*;
use serde_json::json;
use tunenet_core::network::{Model, Pair, Preset, Side, TrainOptions, stream, train_on};
use tunenet_core::observation::{Kind, Note, Observation};
use tunenet_core::simulator::{Preparation, Prepared, Simulator};

use crate::drawn::{Drawn, Ranges};
use crate::{ObservedBall, SimulationFile, built_in};

/// Raised where a network of the same key would be made in another way.
const RECIPE: u32 = 1;
/// Recordings that a scene's network learns from.
const PAIRS: u64 = 2000;
/// What a scene's network is trained beyond the octave that it is looked up by.
const MARGIN: f64 = 1.1;
/// Greatest noise that it learns from, in heights of fall.
const NOISE: f64 = 0.01;
/// More samples in a recording's `√(h/g)` than this teach nothing: the network sees means.
const MOST_SAMPLES: f64 = 60.0;
/// Slower than this along the surface, in `√(g h)`, counts as a drop.
const SLOWEST: f64 = 0.25;

/// Keeps networks that were trained for a scene.
pub trait NetworkStore {
    /// The network stored under `key`, if any, and what went wrong while looking for it.
    fn find(&self, key: &str) -> (Option<Model>, Vec<Note>);

    /// Stores a network under `key`; a note if that is not possible.
    fn keep(&self, key: &str, model: &Model) -> Option<Note>;
}

/// Where a network comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NetworkSource {
    /// The caller gave it.
    Given,
    /// It is part of this library.
    BuiltIn,
    /// It was trained for this scene before.
    Cached,
    /// It was trained for this scene now.
    Trained,
    /// There is none.
    None,
}

impl NetworkSource {
    /// As it is written in files.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::BuiltIn => "built_in",
            Self::Cached => "cached",
            Self::Trained => "trained",
            Self::None => "none",
        }
    }
}

/// A network, where it comes from, and what users should know of that.
#[derive(Debug)]
pub struct ChosenNetwork {
    /// The network, if there is one.
    pub model: Option<Model>,
    /// Where it comes from.
    pub source: NetworkSource,
    /// The same in words; why there is none, where there is none.
    pub text: String,
    /// Time that training took, s, if it was trained now.
    pub train_seconds: Option<f64>,
    /// Problems with the store.
    pub notes: Vec<Note>,
}

impl ChosenNetwork {
    fn new(model: Option<Model>, source: NetworkSource, text: impl Into<String>) -> Self {
        Self { model, source, text: text.into(), train_seconds: None, notes: Vec::new() }
    }

    /// The one that the caller gives.
    #[must_use]
    pub fn given(model: &Model) -> Self {
        Self::new(Some(model.clone()), NetworkSource::Given, format!("as given, preset `{}`", model.preset().name))
    }

    /// No network, and why.
    pub fn none(why: impl Into<String>) -> Self {
        Self::new(None, NetworkSource::None, why)
    }

    /// Whether a network was chosen here, so that a fit may fall back to none if it fails.
    #[must_use]
    pub fn is_own_choice(&self) -> bool {
        self.model.is_some() && self.source != NetworkSource::Given
    }
}

/// Chooses for these recordings of `file`'s ball; never fails: without a network the fit has other starts. `at` is called with
/// the step of a training and the number of steps.
pub fn choose_network(
    file: &SimulationFile,
    ball: &ObservedBall,
    recordings: &[Observation],
    seed: u64,
    store: &dyn NetworkStore,
    at: &mut dyn FnMut(u64, u64),
) -> ChosenNetwork {
    if ball.kind() == Kind::EventTimes {
        return ChosenNetwork::none("not needed for bounce times");
    }
    if !file.parameters().is_ok_and(|all| all.iter().any(|p| p.tune)) {
        return ChosenNetwork::none("not needed: only effects are tuned");
    }
    // Recordings to learn from would be drawn with the formula, whose force may run away from where it was seen.
    if file.effects().iter().any(|effect| file.candidate(&effect.name).is_some()) {
        return ChosenNetwork::none("none: a formula acts; the fit has its own starts");
    }
    let usable = |recording: &Observation| match ball.prepare(recording) {
        Ok(Preparation::Usable(prepared)) => Some(prepared),
        _ => None,
    };
    let Some(first) = recordings.iter().find_map(usable) else {
        return ChosenNetwork::none("not needed: no recording can be used");
    };
    let tuned = |i: &usize| ball.parameters()[*i].tune;
    if !(0..ball.parameters().len()).filter(tuned).any(|i| first.silent[i].is_none()) {
        return ChosenNetwork::none("not needed: the recording does not depend on the parameters");
    }
    if built_in::serves(file, &first).is_ok()
        && let Ok(model) = built_in::ball()
        && starts(&model, &first)
    {
        return ChosenNetwork::new(Some(model), NetworkSource::BuiltIn, "built in");
    }
    let Some((ranges, tau_max)) = around(file, ball, &first) else {
        return ChosenNetwork::none(
            "none: the recording is too different from a drop or a throw to train a network for it",
        );
    };
    for_scene(file, &ranges, tau_max, seed, &first, store, at)
}

/// Whether the model has something to say to this recording.
fn starts(model: &Model, recording: &Prepared) -> bool {
    model.start(Side { observation: &recording.seen, scale: recording.scale.as_ref() }).is_ok()
}

/// What recordings like this one are drawn from: the octaves that it lies in, so that the network serves the next one too.
/// `None` where no such recordings can be imagined.
fn around(file: &SimulationFile, ball: &ObservedBall, recording: &Prepared) -> Option<(Ranges, f64)> {
    let (scale, clock) = (recording.scale?, recording.seen.clock());
    let duration = (clock[clock.len() - 1] - scale.start_s) / scale.time_s;
    let rate = ((clock.len() - 1) as f64 / (clock[clock.len() - 1] - clock[0])).min(MOST_SAMPLES / scale.time_s);
    let start = ball.start(&recording.nuisance_values());
    let speed = scale.length / scale.time_s;
    let across = start.velocity_m_s[0].hypot(start.velocity_m_s[1]) / speed;
    let plausible = (1e-3..=1e3).contains(&scale.length) && (0.5..=200.0).contains(&duration) && across < 100.0;
    if !plausible || !(1.0..=1e5).contains(&rate) {
        return None;
    }
    let wider = |(low, high): (f64, f64)| (low / MARGIN, high * MARGIN);
    let fall_m = match file.ball().ok().and_then(|scene| scene.release.height_m) {
        Some(height) => (height, height),
        None => wider(octave(scale.length)),
    };
    let longest = octave(duration).1;
    let ranges = Ranges {
        fall_m,
        rate_hz: wider(octave(rate)),
        begun: (0.0, 0.6),
        across: if across < SLOWEST { (0.0, SLOWEST) } else { wider(octave(across)) },
        bounces: (1, 5),
        longest,
        noise: NOISE,
    };
    Some((ranges, longest.min(16.0)))
}

/// The octave that a number lies in.
fn octave(value: f64) -> (f64, f64) {
    let low = 2f64.powf(value.log2().floor());
    (low, 2.0 * low)
}

fn for_scene(
    file: &SimulationFile,
    ranges: &Ranges,
    tau_max: f64,
    seed: u64,
    recording: &Prepared,
    store: &dyn NetworkStore,
    at: &mut dyn FnMut(u64, u64),
) -> ChosenNetwork {
    let preset = Preset::scene(tau_max);
    let recipe = json!([
        env!("CARGO_PKG_VERSION"),
        RECIPE,
        PAIRS,
        seed,
        file.essence(),
        format!("{ranges:?}"),
        serde_json::to_value(&preset).unwrap_or_default(),
    ]);
    let key = recipe.to_string();
    let (found, mut notes) = store.find(&key);
    if let Some(model) = found.filter(|m| starts(m, recording)) {
        return ChosenNetwork {
            notes,
            ..ChosenNetwork::new(Some(model), NetworkSource::Cached, "cached for this scene")
        };
    }
    let began = Instant::now();
    match train(file, ranges, preset, seed, at) {
        Ok(model) if starts(&model, recording) => {
            let seconds = began.elapsed().as_secs_f64();
            notes.extend(store.keep(&key, &model));
            let text = format!("trained for this scene, {seconds:.1} s");
            ChosenNetwork {
                notes,
                train_seconds: Some(seconds),
                ..ChosenNetwork::new(Some(model), NetworkSource::Trained, text)
            }
        }
        Ok(_) => ChosenNetwork {
            notes,
            ..ChosenNetwork::none("not used: the network for this scene does not fit the recording")
        },
        Err(error) => ChosenNetwork {
            notes,
            ..ChosenNetwork::none(format!("not used: no network can be trained for this scene ({error})"))
        },
    }
}

fn train(
    file: &SimulationFile,
    ranges: &Ranges,
    preset: Preset,
    seed: u64,
    at: &mut dyn FnMut(u64, u64),
) -> tunenet_formats::Result<Model> {
    let drawn = Drawn::new(file, ranges.clone())?;
    let header = drawn.header("ball/scene", seed, PAIRS);
    let pair = |number: u64| drawn.pair(&mut stream(seed, number));
    let pairs = (0..PAIRS).into_par_iter().map(pair).collect::<tunenet_core::Result<Vec<Pair>>>()?;
    Ok(train_on(&header, &pairs, &TrainOptions::new(preset, seed), &mut |reached| {
        at(reached.step, reached.steps);
        true
    })?)
}
