//! A trained network that estimates parameter differences.

use candle_core::{DType, Device, Tensor};
use serde::{Deserialize, Serialize};

use super::dataset::CoveredParameter;
use super::input::{Encoded, Input};
use super::library::Library;
use super::preset::Preset;
use super::two_branch::{TwoBranch, Widths};
use super::weights::{Weights, WeightsFault};
use crate::observation::{Channel, Observation, resample};
use crate::simulator::Scale;
use crate::{Error, Result};

/// Version of a model's [`Weights`]. Raised whenever an older program would misread a newer file.
pub const MODEL_VERSION: u32 = 1;

/// Everything about a model but its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct About {
    pub(super) version: u32,
    pub(super) preset: Preset,
    pub(super) input: Input,
    /// The tuned parameters.
    pub(super) parameters: Vec<CoveredParameter>,
    /// Names and units of the channels.
    pub(super) channels: Vec<(String, String)>,
    /// What targets are seen as, where that is something else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) target: Option<Target>,
    pub(super) seed: u64,
}

/// A target that is observed otherwise than a rollout: a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Target {
    pub(super) input: Input,
    pub(super) channels: Vec<(String, String)>,
}

/// One side of a comparison: an observation and, where the model is dimensionless, its scale.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// What was observed; its channels are those of the training set.
    pub observation: &'a Observation,
    /// What makes it dimensionless; see [`Input::needs_scale`].
    pub scale: Option<&'a Scale>,
}

/// A trained two-branch network.
///
/// It may be shared between threads; an estimate builds nothing but its result.
#[derive(Debug, Clone)]
pub struct Model {
    about: About,
    channels: Vec<Channel>,
    target_channels: Vec<Channel>,
    clock: Vec<f64>,
    network: TwoBranch,
    wide: TwoBranch,
    library: Option<Library>,
}

impl Model {
    pub(super) fn new(about: About, clock: Vec<f64>, network: TwoBranch, library: Option<Library>) -> Result<Self> {
        let made = |names: &[(String, String)]| names.iter().map(|(n, u)| Channel::new(n, u)).collect();
        let channels = made(&about.channels);
        let target_channels = about.target.as_ref().map(|t| made(&t.channels)).unwrap_or_default();
        let wide = network.widened()?;
        Ok(Self { about, channels, target_channels, clock, network, wide, library })
    }

    /// The training that made it.
    #[must_use]
    pub fn preset(&self) -> &Preset {
        &self.about.preset
    }

    /// What it sees of an observation.
    #[must_use]
    pub fn input(&self) -> &Input {
        &self.about.input
    }

    /// The parameters whose differences it estimates, with the range that it was trained on.
    #[must_use]
    pub fn parameters(&self) -> &[CoveredParameter] {
        &self.about.parameters
    }

    /// The channels that an observation must have.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The channels that a target may have besides, a picture's; empty where it learned from none.
    #[must_use]
    pub fn target_channels(&self) -> &[Channel] {
        &self.target_channels
    }

    /// Whether it sees heights read back from a picture, rather than the picture.
    #[must_use]
    pub fn reads_back(&self) -> bool {
        !matches!(self.about.target, Some(Target { input: Input::Raw { .. }, .. }))
    }

    /// The clock of its training set, in s; empty where every pair had its own.
    #[must_use]
    pub fn clock(&self) -> &[f64] {
        &self.clock
    }

    /// Whether it was trained on recordings with guesses of their initial state, each on its own clock, instead of on rollouts.
    #[must_use]
    pub fn from_recordings(&self) -> bool {
        self.clock.is_empty()
    }

    /// The seed of its training.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.about.seed
    }

    /// The estimated difference target − proposed of each of [`Model::parameters`], in its unit.
    ///
    /// Not clipped: the bounds are the caller's. With an antisymmetric preset, equal observations give exactly 0.
    ///
    /// # Errors
    /// [`Error::Model`] where an observation has other channels than the training set, or lacks the scale that
    /// [`Input::needs_scale`] asks for.
    pub fn estimate(
        &self,
        proposed: &Observation,
        proposed_scale: Option<&Scale>,
        target: &Observation,
        target_scale: Option<&Scale>,
    ) -> Result<Vec<f64>> {
        let pair =
            (Side { observation: proposed, scale: proposed_scale }, Side { observation: target, scale: target_scale });
        Ok(self.estimate_batch(&[pair])?.swap_remove(0))
    }

    /// As [`Model::estimate`] for many pairs (proposed, target) at once, shape `[pair, parameter]`.
    ///
    /// # Errors
    /// As [`Model::estimate`].
    pub fn estimate_batch(&self, pairs: &[(Side<'_>, Side<'_>)]) -> Result<Vec<Vec<f64>>> {
        if pairs.is_empty() {
            return Ok(Vec::new());
        }
        let width = self.about.input.width();
        let (mut proposed, mut target) =
            (Vec::with_capacity(pairs.len() * width), Vec::with_capacity(pairs.len() * width));
        for (a, b) in pairs {
            let (mut a, mut b) = (self.encode(a)?, self.encode(b)?);
            a.pair(&mut b);
            proposed.extend(a.values);
            target.extend(b.values);
        }
        let tensor = |values| Tensor::from_vec(values, (pairs.len(), width), &Device::Cpu);
        let shares = self.wide.forward(&tensor(proposed)?, &tensor(target)?)?.to_vec2::<f64>()?;
        let scaled = |row: Vec<f64>| row.iter().zip(&self.about.parameters).map(|(d, p)| d * p.span()).collect();
        Ok(shares.into_iter().map(scaled).collect())
    }

    /// Where to start before anything is rolled out: the parameters of the stored rollout nearest to `target`, moved by
    /// the difference that the network sees between the two, each in its unit. `None` where no rollouts are stored, or
    /// none overlaps the target. Not clipped.
    ///
    /// # Errors
    /// As [`Model::estimate`].
    pub fn start(&self, target: Side<'_>) -> Result<Option<Vec<f64>>> {
        let Some(library) = &self.library else { return Ok(None) };
        let mut seen = self.encode(&target)?;
        let whole = seen.clone();
        let Some((mut nearest, place)) = library.nearest(&seen) else { return Ok(None) };
        nearest.pair(&mut seen);
        let width = self.about.input.width();
        let tensor = |values| Tensor::from_vec(values, (1, width), &Device::Cpu);
        let moved = self.wide.forward(&tensor(nearest.values)?, &tensor(seen.values)?)?.to_vec2::<f64>()?;
        let worse = || {
            let distance = |at: f64| library.distance(at, &whole);
            Some(distance(place[0] + moved[0][0])? > distance(place[0])?)
        };
        // Next to where nothing changes (impacts that return next to nothing) the network may see a difference that is not there. Where
        // it has learned how guesses of the initial state err, the distance is no judge of it.
        let step =
            if !self.from_recordings() && worse().unwrap_or(false) { vec![0.0; place.len()] } else { moved[0].clone() };
        let each = self.about.parameters.iter().zip(place.iter().zip(&step));
        Ok(Some(each.map(|(p, (place, step))| p.min + p.span() * (place + step)).collect()))
    }

    /// The Gauss–Newton step from a rollout `proposed` at `value` towards `target`, its slope taken from the stored
    /// rollouts; in the unit of the one parameter. `None` where the model estimates several, or stores no slope there.
    ///
    /// # Errors
    /// As [`Model::estimate`].
    pub fn library_step(&self, value: f64, proposed: Side<'_>, target: Side<'_>) -> Result<Option<f64>> {
        let (Some(library), [parameter]) = (&self.library, self.parameters()) else { return Ok(None) };
        let Some(slope) = library.slope((value - parameter.min) / parameter.span()) else { return Ok(None) };
        let (a, b) = (self.encode(&proposed)?, self.encode(&target)?);
        let start = slope.covered.start.max(a.covered.start).max(b.covered.start);
        let both = start..slope.covered.end.min(a.covered.end).min(b.covered.end);
        let square: f64 = both.clone().map(|i| slope.values[i].powi(2)).sum();
        let product: f64 = both.map(|i| slope.values[i] * (b.values[i] - a.values[i])).sum();
        Ok((square > 0.0).then(|| product / square * parameter.span()))
    }

    fn encode(&self, side: &Side<'_>) -> Result<Encoded> {
        let seen = side.observation;
        let pixels = self.about.target.as_ref().filter(|_| seen.channels() == self.target_channels);
        let input = pixels.map_or(&self.about.input, |t| &t.input);
        if pixels.is_none() && seen.channels() != self.channels {
            let list = |channels: &[Channel]| {
                channels.iter().map(|c| format!("{} ({})", c.name, c.unit)).collect::<Vec<_>>().join(", ")
            };
            let (expected, found) = (list(&self.channels), list(seen.channels()));
            return Err(Error::Model { what: "takes other channels".into(), expected, found });
        }
        let channels = seen.channels().len();
        // Raw samples mean something only at the instants of the training set.
        if matches!(input, Input::Raw { .. } | Input::Recorded { .. }) && seen.clock() != self.clock {
            let seen = resample(seen, &self.clock)?;
            return input.encode(seen.clock(), seen.values(), channels, side.scale);
        }
        input.encode(seen.clock(), seen.values(), channels, side.scale)
    }

    /// All of it as named arrays: weights under their field names, the training set's clock as `clock`, stored rollouts under
    /// `library`, and everything else as JSON. The same training gives the same arrays.
    ///
    /// # Errors
    /// [`Error::Network`] where a tensor cannot be read.
    pub fn weights(&self) -> Result<Weights> {
        let about = serde_json::to_string(&self.about).map_err(|e| candle_core::Error::Msg(e.to_string()))?;
        let mut tensors = named(&self.network);
        tensors.push(("clock".into(), Tensor::from_slice(&self.clock, self.clock.len(), &Device::Cpu)?));
        if let Some(library) = &self.library {
            tensors.extend(library.tensors()?);
        }
        Weights::new(about, &tensors)
    }

    /// The model that [`Model::weights`] described.
    ///
    /// # Errors
    /// [`Error::Weights`] where they are no model, of another version, or an array is missing or has another shape.
    pub fn from_weights(mut weights: Weights) -> Result<Self> {
        let about = read_about(&weights.about)?;
        let samples = weights.shape("clock").map_or(0, |shape| shape.iter().product());
        let clock = weights.take("clock", DType::F64, &[samples])?.to_vec1()?;
        let network = take_network(&mut weights, &about)?;
        let library = Library::take(&mut weights, about.input.width(), about.parameters.len())?;
        Self::new(about, clock, network, library)
    }
}

fn read_about(text: &str) -> Result<About> {
    let refuse = |found: String| {
        let expected = format!("a model of version {MODEL_VERSION}");
        Error::Weights { expected, found, fault: WeightsFault::Version }
    };
    // The version decides whether the rest can be understood at all.
    let json: serde_json::Value = serde_json::from_str(text).map_err(|e| refuse(e.to_string()))?;
    match json.get("version").and_then(serde_json::Value::as_u64) {
        Some(version) if version == u64::from(MODEL_VERSION) => {}
        Some(version) => return Err(refuse(format!("version {version}"))),
        None => return Err(refuse("none".into())),
    }
    let about: About = serde_json::from_value(json).map_err(|e| refuse(e.to_string()))?;
    about.preset.check()?;
    Ok(about)
}

/// The weights with their names.
pub(super) fn named(network: &TwoBranch) -> Vec<(String, Tensor)> {
    TwoBranch::NAMES.iter().map(|name| (*name).to_owned()).zip(network.weights().into_iter().cloned()).collect()
}

/// The network that `about` describes, out of stored weights.
pub(super) fn take_network(stored: &mut Weights, about: &About) -> Result<TwoBranch> {
    let mut weights = Vec::with_capacity(8);
    for (name, shape) in TwoBranch::NAMES.iter().zip(TwoBranch::shapes(widths(about))) {
        weights.push(stored.take(name, DType::F32, &shape)?);
    }
    let Ok(weights) = <[Tensor; 8]>::try_from(weights) else { unreachable!("eight names") };
    Ok(TwoBranch::from_weights(weights, about.preset.head))
}

/// The widths that `about` asks for.
pub(super) fn widths(about: &About) -> Widths {
    Widths {
        inputs: about.input.width(),
        features: about.preset.features,
        hidden: about.preset.hidden,
        outputs: about.parameters.len(),
    }
}
