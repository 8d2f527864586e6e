//! Which network a `tune` starts with: the one given, the one built in, or one for the scene, from the cache or trained on
//! the spot.

use std::time::Instant;

use rayon::prelude::*;
use serde_json::{Value, json};
use tunenet_core::network::{Model, Pair, Preset, Side, TrainOptions, stream, train_on};
use tunenet_core::observation::{Kind, Note};
use tunenet_core::simulator::{Preparation, Prepared, Simulator};
use tunenet_formats::Recording;
use tunenet_sim::drawn::{Drawn, Ranges};
use tunenet_sim::{ObservedBall, SimulationFile, built_in};

use crate::commands::model_cache::Cache;
use crate::view::text::{progress, stage};

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

/// A network, where it comes from, and what a person should know of that.
pub struct Chosen {
    pub model: Option<Model>,
    source: &'static str,
    text: String,
    seconds: Option<f64>,
    pub notes: Vec<Note>,
}

impl Chosen {
    fn new(model: Option<Model>, source: &'static str, text: impl Into<String>) -> Self {
        Self { model, source, text: text.into(), seconds: None, notes: Vec::new() }
    }

    /// The one that `--model` names.
    pub fn given(model: &Model) -> Self {
        Self::new(Some(model.clone()), "given", format!("as given, preset `{}`", model.preset().name))
    }

    /// Whether the tool chose it, so that nobody misses it where it fails.
    pub fn own_choice(&self) -> bool {
        self.source != "given"
    }

    /// As `tune`'s JSON has it.
    pub fn json(&self) -> Value {
        json!({ "source": self.source, "text": self.text, "train_seconds": self.seconds })
    }

    /// `model    built in`.
    pub fn render(&self) {
        stage("model", &self.text);
    }
}

/// No network, and why.
pub fn none(why: String) -> Chosen {
    Chosen::new(None, "none", why)
}

/// Chooses for these recordings of `file`'s ball; never fails: without a network the fit has other starts.
pub fn choose(
    file: &SimulationFile,
    ball: &ObservedBall,
    recordings: &[Recording],
    seed: u64,
    cache: &Cache,
) -> Chosen {
    if ball.kind() == Kind::EventTimes {
        return none("not needed for bounce times".into());
    }
    let usable = |recording: &Recording| match ball.prepare(&recording.observation) {
        Ok(Preparation::Usable(prepared)) => Some(prepared),
        _ => None,
    };
    let Some(first) = recordings.iter().find_map(usable) else {
        return none("not needed: no recording can be used".into());
    };
    let tuned = |i: &usize| ball.parameters()[*i].tune;
    if !(0..ball.parameters().len()).filter(tuned).any(|i| first.silent[i].is_none()) {
        return none("not needed: the recording does not depend on the parameters".into());
    }
    if built_in::serves(file, &first).is_ok()
        && let Ok(model) = built_in::ball()
        && starts(&model, &first)
    {
        return Chosen::new(Some(model), "built_in", "built in");
    }
    let Some((ranges, tau_max)) = around(file, ball, &first) else {
        return none("none: the recording is too unlike a drop or a throw to train one for it".into());
    };
    for_scene(file, &ranges, tau_max, seed, cache, &first)
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
    cache: &Cache,
    recording: &Prepared,
) -> Chosen {
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
    let (found, mut notes) = cache.find(&key);
    if let Some(model) = found.filter(|m| starts(m, recording)) {
        return Chosen { notes, ..Chosen::new(Some(model), "cached", "cached for this scene") };
    }
    let began = Instant::now();
    match train(file, ranges, preset, seed) {
        Ok(model) if starts(&model, recording) => {
            let seconds = began.elapsed().as_secs_f64();
            notes.extend(cache.keep(&key, &model));
            let text = format!("trained for this scene, {seconds:.1} s");
            Chosen { notes, seconds: Some(seconds), ..Chosen::new(Some(model), "trained", text) }
        }
        Ok(_) => Chosen { notes, ..Chosen::new(None, "none", "none: the one for this scene cannot see the recording") },
        Err(error) => Chosen { notes, ..Chosen::new(None, "none", format!("none for this scene: {error}")) },
    }
}

fn train(file: &SimulationFile, ranges: &Ranges, preset: Preset, seed: u64) -> tunenet_core::Result<Model> {
    let drawn = Drawn::new(file, ranges.clone())?;
    let header = drawn.header("ball/scene", seed, PAIRS);
    let bar = progress(0, "training");
    let pair = |number: u64| drawn.pair(&mut stream(seed, number));
    let pairs = (0..PAIRS).into_par_iter().map(pair).collect::<tunenet_core::Result<Vec<Pair>>>()?;
    let options = TrainOptions::new(preset, seed);
    let model = train_on(&header, &pairs, &options, &mut |at| {
        bar.set_length(at.steps);
        bar.set_position(at.step);
        true
    });
    bar.finish_and_clear();
    model
}
